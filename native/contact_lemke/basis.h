#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/covering_vector.h"
#include "native/contact_lemke/friction_state.h"
#include "native/contact_lemke/kernel.h"
#include "native/kernels/response.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The variable that enters the basis.
struct Entering {
  bool is_velocity = false;  ///< a velocity of the kernel's rows, else an impulse
  Label label;
};

/// What leaves the basis.
struct LeavingVariable {
  enum class Kind { kNone, kColumn, kBase, kVelocity, kBroken };
  Kind kind = Kind::kNone;
  Count column = -1;  ///< kColumn
  Label label;        ///< kBase: the contact; kVelocity: whose
};

/// A basis of a contact problem, and the vectors of its variables.
///
/// A contact that presses has friction impulses on a simplex of size mu f_N, spanned by its directions and the zero
/// vector (see Contacts). One of the basic ones, the contact's base t, is eliminated by f_t = mu f_N - (the others),
/// and with it lambda = -d_t'u and the cone row. What is left are unknowns with the columns
///
///     normal:     a = N_i + mu d_t   b = N_i            direction s:   a = b = d_s - d_t
///
/// so that the kernel B'G*A never exceeds rank(G) + 1 rows, the last for the artificial variable z0. The velocities of
/// the rows of the kernel are zero; all other velocities follow from u = v + G* A x.
template <class Scalar>
struct Basis {
  using P = Packed<Scalar>;
  using Tangents = typename Contacts<Scalar>::Tangents;

  /// Takes all memory that load() needs; touches hardly any of it.
  void reserve(const contact_lemke::Input& input) {
    contacts.reserve(input);
    response.reserve(input);
    kernel.reserve(contacts, most_rows());
    friction.reserve(contacts.nc() + 1);
    simplex.resize(contacts.nc() + 1);
    covering.reserve();
    Buffer<Scalar>* const by_coordinate[] = {&column, &row, &drift};
    for (Buffer<Scalar>* buffer : by_coordinate) buffer->resize(contacts.extent());
  }

  void load(const contact_lemke::Input& input) {
    contacts.load(input);
    response.load(input);
    fill_with_zeros(contacts.extent(), column, row);
    simplex[contacts.nc()] = {};
  }

  /// Of the kernel, with room for one more.
  Count most_rows() const {
    Count rows = 0;
    for (Count c = 0; c < contacts.nc(); ++c) rows += 1 + (contacts.has_friction(c) ? contacts.edges(c) : 0);
    return (rows < coordinates() ? rows : coordinates()) + 2;
  }
  /// With those of what contacts yield.
  Count coordinates() const { return contacts.is_soft() ? contacts.extent() : contacts.ngc(); }

  /// No impulse is basic.
  void clear() {
    kernel.clear();
    friction.clear(contacts.nc() + 1);
    has_drift = false;
  }

  // --- the vectors of a label, extent() entries ---

  /// b of a velocity
  void load_row(Label label, Scalar* to) const {
    if (label.is_normal()) return load_normal(label.contact, to);
    load_difference(label, to);
  }
  /// a of an impulse
  void load_column(Label label, Scalar* to) const {
    const Count c = label.contact;
    if (!label.is_normal()) return load_difference(label, to);
    if (!friction.is_active(c)) return load_normal(c, to);
    const double* const base = contacts.direction(c, friction.base(c));
    contacts.get_sum(contacts.impulse_column(c), contacts.mu(c), base, to);
    if (!contacts.is_soft()) return;
    const Tangents along = contacts.tangents(c, friction.base(c));
    load_yields(c, Scalar(1), {contacts.mu(c) * along.first, contacts.mu(c) * along.second}, to);
  }
  void load_normal(Count contact, Scalar* to) const {
    contacts.get_normal(contact, to);
    if (contacts.is_soft()) load_yields(contact, Scalar(1), {}, to);
  }
  void load_difference(Label label, Scalar* to) const {
    const Count c = label.contact;
    contacts.get_sum(contacts.direction(c, label.direction), Scalar(-1), contacts.direction(c, friction.base(c)), to);
    if (!contacts.is_soft()) return;
    const Tangents own = contacts.tangents(c, label.direction), base = contacts.tangents(c, friction.base(c));
    load_yields(c, Scalar(0), {own.first - base.first, own.second - base.second}, to);
  }
  /// The entries behind those of the coordinates.
  void load_yields(Count contact, Scalar normal, Tangents along, Scalar* to) const {
    for (Count i = contacts.padded_ngc(); i < contacts.extent(); i += P::kWidth) P::store(to + i, typename P::Pack{});
    to[contacts.normal_at(contact)] = normal;
    to[contacts.tangents_at(contact)] = along.first;
    to[contacts.tangents_at(contact) + 1] = along.second;
  }
  /// c := the velocities that the impulses a cause, with what contacts yield.
  void respond(const Scalar* a, Scalar* c) {
    response.apply(a, c);
    contacts.yield(a, c);
  }
  /// At least the normal velocity that a response brings to any contact.
  Scalar norm_of(const Scalar* c) const { return norm_of(c, contacts.extent()); }
  Scalar norm_of_column(Count j) const { return norm_of(kernel.column(j), kernel.column_length()); }
  Scalar norm_of(const Scalar* c, Count length) const {
    const Count ngc = contacts.padded_ngc();
    const Scalar moved = contacts.reach() * square_root(dot(c, c, ngc));
    return length > ngc ? moved + square_root(dot(c + ngc, c + ngc, length - ngc)) : moved;
  }
  /// Of a contact's friction impulse in mu f_N - (the others), of its normal mu.
  Scalar simplex_weight(Label label) const { return label.is_normal() ? contacts.mu(label.contact) : Scalar(-1); }

  /// The kernel's inverse anew. False when it is singular.
  bool invert() {
    ++factorizations;
    work += kernel.order() * kernel.order() * (kernel.order() + contacts.ngc());
    return kernel.invert();
  }

  void set_base(Count contact, Count direction) {
    friction.set_base(contact, direction);
    simplex[contact].set_base(direction, contacts.half(contact));
  }

  Contacts<Scalar> contacts;
  Response<Scalar> response;
  Kernel<Scalar> kernel;
  FrictionState friction;
  CoveringVector<Scalar> covering{contacts, friction};
  Buffer<FrictionSimplex<Scalar>> simplex;  ///< by contact, and one more place for what is of none
  Buffer<Scalar> column, row;               ///< scratch, extent() entries
  bool has_drift = false;                   ///< z0 multiplies `drift`, a change of v, and no covering vector
  Buffer<Scalar> drift;                     ///< extent() entries
  Count work = 0, factorizations = 0;       ///< see contact_lemke::Outcome
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
