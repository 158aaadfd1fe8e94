#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/answer/contact_scale.h"
#include "core/answer/refined_inertia.h"
#include "core/compliance.h"

namespace lcpbench {

/// The LCP of a contact problem in 113 bits. M is never formed: a point z is carried
/// with its response, the velocity u = v + G* J f, from which any row of w = M z + q follows. A diagonal entry M_ii =
/// J_i' G* J_i costs one solve with G. Opposite directions of friction are twins: the columns of J that differ in sign
/// alone share their entries, and their rows share q_i, J_i'u and M_ii up to that sign. One thread at a time: const
/// members share scratch.
class ContactLcp {
 public:
  /// @param problem, inertia  must outlive this object; inertia.well_defined() must hold.
  ContactLcp(const ContactProblem& problem, const RefinedInertia& inertia);

  /// Another velocity before the impact (ngc), in place of that of the problem.
  void set_velocity(const Vector& v);

  std::size_t size() const { return static_cast<std::size_t>(layout_.size()); }
  /// Of a normal or friction row; those of the cone rows are zero.
  Quad q(std::size_t i) const { return project(i, v_) + offset(i); }
  /// q_i - J_i'v: b_i of a normal row, the tangential offset along the direction of a friction row.
  Quad offset(std::size_t i) const { return i < b_.size() ? b_[i] : Quad{0}; }
  /// The offsets of the rows from this one on are zero.
  std::size_t offsets() const { return b_.size(); }

  /// u = v + G* J f for the impulses f in z. One solve with G; v itself where no impulse acts.
  QuadVector response(const QuadVector& z) const {
    QuadVector u;
    respond(z, u);
    return u;
  }
  /// u := response(z), in the memory of u.
  void respond(const QuadVector& z, QuadVector& u) const;
  /// How far response() may be off where the inertia has reduced rank: see RefinedInertia::solve_error(). Else empty.
  QuadVector response_error(const QuadVector& z) const;
  /// How far that makes the residual of row i be off, M_ii included. @param off  response_error(z)
  Quad residual_error(std::size_t i, const QuadVector& z, Quad w, const QuadVector& off) const;
  /// w = M z + q. @param u  response(z)
  QuadVector all_rows(const QuadVector& z, const QuadVector& u) const {
    QuadVector w;
    write_rows(z, u, w);
    return w;
  }
  /// w := all_rows(z, u), in the memory of w.
  void write_rows(const QuadVector& z, const QuadVector& u, QuadVector& w) const;
  /// Sets the lambdas of z to the least doubles that its impulses allow. @param u  response(z)
  void complete(QuadVector& z, const QuadVector& u) const;
  /// w_i of a normal or friction row without lambda: the velocity along it, with offset and compliance.
  Quad velocity(std::size_t i, const QuadVector& z, const QuadVector& u) const {
    return project(i, u) + offset(i) + (soft_ ? yielding(i, z) : Quad{0});
  }
  /// M_ii.
  Quad diagonal(std::size_t i);
  std::size_t impulses() const { return begin_.size() - 1; }
  std::size_t contacts() const { return contacts_; }
  const QuadVector& velocity_before() const { return v_; }
  /// The contact to which row i belongs.
  Index contact_of(Index i) const {
    if (i >= layout_.lambda_offset())
      return layout_.cone_contact[static_cast<std::size_t>(i - layout_.lambda_offset())];
    return i < layout_.nc ? i : contact_of_[static_cast<std::size_t>(i - layout_.nc)];
  }
  /// The normal row of the contact to which cone row i belongs.
  std::size_t normal_of_cone(std::size_t i) const {
    return static_cast<std::size_t>(layout_.cone_contact[i - impulses()]);
  }

  const ContactLayout& layout() const { return layout_; }

  /// Whether every impulse in z is zero.
  bool at_rest(const QuadVector& z) const;
  /// J f for the impulses f in z. Impulses that cancel leave what 113 bits lose of their sum.
  QuadVector generalized_impulse(const QuadVector& z) const {
    QuadVector impulse;
    sum_impulses(z, impulse);
    return impulse;
  }
  /// |J| |f|, entry by entry: the scale of rounding in J f.
  QuadVector generalized_impulse_scale(const QuadVector& z) const;
  /// What the residuals of an island are relative to, from its rows. @param without  the residual of no impulses, where
  /// it is not that of pyramid and cone
  Quad scale(std::span<const std::size_t> rows, std::optional<Quad> without = std::nullopt) const;
  /// J_i' x.
  Quad project(std::size_t i, const QuadVector& x) const;

 private:
  /// The nonzero entries of a column of J; of the later twin, those of the earlier one, with the opposite sign.
  struct Entries {
    const std::size_t* rows;
    const double* values;
    std::size_t count;
  };
  Entries entries(std::size_t j) const {
    const std::size_t begin = begin_[twin_[j]];
    return {rows_.data() + begin, values_.data() + begin, begin_[twin_[j] + 1] - begin};
  }
  bool is_twin(std::size_t j) const { return twin_[j] != j; }

  /// What the compliance of its contact adds to row i. @pre soft_
  Quad yielding(std::size_t i, const QuadVector& z) const;
  void soften();
  /// impulse := generalized_impulse(z)
  void sum_impulses(const QuadVector& z, QuadVector& impulse) const;
  /// @param fastest  the normal row of the largest -q_i
  template <class Number>
  ContactScale<Number> scale_in(std::span<const std::size_t> rows, std::size_t& fastest) const;
  std::pair<Index, Index> friction_of_row(std::size_t i) const;
  void add_columns();
  void add_column(const Jacobian& J, Index column);
  void add_twin(std::size_t of);
  /// sum of e values[e] x[rows[e]] over the entries of column i: J_i'x but for the sign of a twin.
  Quad sum_of(std::size_t i, const QuadVector& x) const;
  Quad cone_row(std::size_t i, const QuadVector& z) const;
  /// |J_i|'x.
  Quad project_magnitudes(std::size_t i, const QuadVector& x) const;
  Quad diagonal_error(std::size_t i) const;
  /// The index of the lambda of a friction row.
  std::size_t lambda_of(std::size_t i) const {
    return impulses() + static_cast<std::size_t>(layout_.lambda[static_cast<std::size_t>(contact_of_[i - contacts_])]);
  }

  const ContactProblem& problem_;
  const RefinedInertia& inertia_;
  Vector velocity_;  ///< before the impact
  QuadVector v_;     ///< the same
  QuadVector b_;  ///< of the rows from the first on; beyond its end zero
  std::size_t contacts_ = 0;
  ContactLayout layout_;
  std::optional<SoftRows<Quad>> soft_;  ///< of a problem with compliance or tangential offsets
  std::vector<std::size_t> begin_{0};   ///< of each column of J = [N D], by columns; a twin has no entries of its own
  std::vector<std::size_t> rows_;
  std::vector<double> values_;
  std::vector<std::size_t> twin_;  ///< the column's own index, or that of an earlier column that is its negative
  std::vector<Index> contact_of_;  ///< of each friction row
  std::vector<std::optional<Quad>> diagonals_;  ///< of the first of twins, where they were asked for
  mutable QuadVector lost_;
};

}  // namespace lcpbench
