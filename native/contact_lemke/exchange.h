#pragma once

#include "native/contact_lemke/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The exchange of a pivot: how the basis changes as one variable enters and another leaves.
template <class Scalar>
class Exchange {
 public:
  Exchange(Basis<Scalar>& basis, BasicVariables<Scalar>& variables, RatioTest<Scalar>& ratio_test)
      : basis_(basis),
        variables_(variables),
        ratio_test_(ratio_test),
        contacts_(basis.contacts),
        kernel_(basis.kernel),
        friction_(basis.friction) {}

  /// Takes all memory; touches none of it. @pre the basis is reserved
  void reserve() {
    slip_.resize(contacts_.most_padded_half());
    coefficients_.resize(kernel_.stride());
  }

  /// z0 takes the place of the velocity `row`: the first basis of a path. @pre the basis is clear
  void start(Label row) {
    load_row(row);
    put_row(0, row);
    for (Count i = 0; i < contacts_.extent(); ++i) basis_.column[i] = 0;
    kernel_.put_column(0, Label{}, basis_.column.data(), Scalar(1));
    kernel_.start(Scalar(1) / basis_.covering.of(row));
    ratio_test_.forbid(row);
  }

  /// The velocities of the first half of a contact's directions. Valid until the next call.
  const Scalar* slip(Count contact) {
    contacts_.slip(contact, variables_.u.data(), slip_.data());
    return slip_.data();
  }

  /// A contact begins to press: its friction starts in the direction against its slip.
  void activate_friction(Count contact) {
    if (!contacts_.has_friction(contact) || friction_.is_active(contact)) return;
    const Scalar* const slip = this->slip(contact);
    const Count half = contacts_.half(contact);
    Count base = 2 * half;
    Scalar largest = 0;
    for (Count t = 0; t < half; ++t) {  // without branches that nothing could foretell
      const Scalar size = magnitude(slip[t]);
      base = size > largest ? t : base;
      largest = size > largest ? size : largest;
    }
    if (base < half && !(slip[base] < 0)) base += half;
    activate_friction_with_base(contact, base, false);
  }

  /// @param classic  the covering vector covers friction, too @pre the contact has friction, and it is not active
  void activate_friction_with_base(Count contact, Count base, bool classic) {
    friction_.activate(contact, base);
    ratio_test_.allow_friction(contact);
    FrictionSimplex<Scalar>& simplex = basis_.simplex[contact];
    simplex.directions = contacts_.block(contact);
    simplex.allowed = ratio_test_.allowed_of(contact);
    simplex.width = contacts_.padded_half(contact);
    simplex.cover = basis_.covering.of_directions(contact);
    simplex.weights[0] = -1;
    simplex.weights[1] = contacts_.mu(contact);
    simplex.norms[1] = 0;
    simplex.set_base(base, contacts_.half(contact));
    if (!classic) return;
    basis_.load_normal(contact, basis_.column.data());
    basis_.respond(basis_.column.data(), basis_.row.data());
    simplex.norms[1] = basis_.norm_of(basis_.row.data());
    basis_.covering.cover_cone(contact, simplex.norms[1]);
  }

  /// Exchanges the two variables. @returns false where the new basis is singular
  /// @param entering  becomes the complement of the variable that left, which enters next
  /// @param closes  whether a contact whose normal leaves loses its friction with it
  bool run(Entering& entering, LeavingVariable leaving, bool closes) {
    if (leaving.kind == LeavingVariable::Kind::kBase) {  // another friction impulse of the contact becomes its base
      const Count contact = leaving.label.contact;
      if (friction_.support(contact) == 0) return replace_base_by_entering(entering);
      leaving.column = largest_friction_column(contact);
      make_base(contact, leaving.column, entering);
    }
    if (leaving.kind == LeavingVariable::Kind::kVelocity) return bring_row(entering, leaving.label);
    const Label label = leaving.label;
    const bool contact_opens = closes && label.is_normal() && friction_.is_active(label.contact);
    const bool friction_enters = entering.label.contact == label.contact && !entering.label.is_normal();
    if (contact_opens && (friction_.support(label.contact) > 0 || friction_enters)) {
      return open_sticking(entering, label.contact);
    }
    drop_column(entering, leaving.column);
    if (contact_opens) friction_.deactivate(label.contact);
    entering = {true, label};
    return true;
  }

 private:
  using P = Packed<Scalar>;

  void load_row(Label label) { basis_.load_row(label, basis_.row.data()); }

  /// The row that load_row() loaded.
  void put_row(Count r, Label label) {
    kernel_.put_row(r, label, basis_.row.data(), basis_.covering.of(label),
                    -dot(basis_.row.data(), contacts_.velocity(), contacts_.extent()));
  }

  void put_entering_column(Count j, Label label) {
    kernel_.put_column(j, label, variables_.entering_response.data(), variables_.entering_norm);
    friction_.count_unknown(label, 1);
  }

  /// An impulse or z0 leaves.
  void drop_column(const Entering& entering, Count column) {
    friction_.count_unknown(kernel_.column_label(column), -1);
    if (entering.is_velocity) {
      ratio_test_.allow(entering.label);
      kernel_.remove(kernel_.find_row(entering.label), column);
    } else {
      kernel_.replace_column(column, variables_.dx.data());
      put_entering_column(column, entering.label);
    }
  }

  /// A velocity leaves: it is zero from now on, and a row of the kernel.
  bool bring_row(Entering& entering, Label leaving) {
    load_row(leaving);
    const Scalar cover = basis_.covering.of(leaving);
    ratio_test_.forbid(leaving);
    if (entering.is_velocity) {
      const Count r = kernel_.find_row(entering.label);
      if (!kernel_.replace_row(r, basis_.row.data(), cover)) return false;
      put_row(r, leaving);
      ratio_test_.allow(entering.label);
    } else {
      if (kernel_.full()) return false;
      if (!kernel_.append(basis_.row.data(), cover, variables_.entering_response.data(), variables_.dx.data())) {
        return false;
      }
      const Count last = kernel_.order();
      put_row(last, leaving);
      put_entering_column(last, entering.label);
      kernel_.grow();
    }
    entering = {false, leaving};
    return true;
  }

  Count largest_friction_column(Count contact) const {
    Count largest = -1;
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      const bool is_friction = label.contact == contact && !label.is_normal();
      if (is_friction && (largest < 0 || variables_.x[j] > variables_.x[largest])) largest = j;
    }
    return largest;
  }

  /// The friction impulse in the column `place` becomes the base, the old base the unknown there.
  void make_base(Count contact, Count place, const Entering& entering) {
    const Label old_base{contact, friction_.base(contact)};
    const Label new_base = kernel_.column_label(place);
    const Count row = kernel_.find_row(new_base);
    move_rows(contact, row);
    move_columns(contact, place, entering);
    basis_.set_base(contact, new_base.direction);
    kernel_.relabel_row(row, old_base);
    kernel_.relabel_column(place, old_base);
    variables_.x[place] = basis_.simplex[contact].value;
    variables_.dx[place] = basis_.simplex[contact].rate;
  }

  /// d_s - d_t becomes d_s - d_new; the new base's own row that of the old base.
  void move_rows(Count contact, Count row) {
    for (Count r = 0; r < kernel_.order(); ++r) {
      const Label label = kernel_.row_label(r);
      if (r != row && label.contact == contact && !label.is_normal()) kernel_.subtract_row(r, row);
    }
    kernel_.negate_row(row);
  }

  void move_columns(Count contact, Count place, const Entering& entering) {
    const Count order = kernel_.order();
    Scalar* const moved = basis_.column.data();
    for (Count j = 0; j < P::padded(order); ++j) coefficients_[j] = 0;
    kernel_.get_column(place, moved);
    for (Count j = 0; j < order; ++j) {
      const Label label = kernel_.column_label(j);
      if (j == kernel_.artificial()) {
        coefficients_[j] = basis_.covering.of_cone(contact);
      } else if (label.contact == contact) {
        coefficients_[j] = basis_.simplex_weight(label);
      } else {
        continue;
      }
      if (j != place) kernel_.add_to_column(j, coefficients_[j], moved);
      if (j != kernel_.artificial()) kernel_.set_norm(j, basis_.norm_of_column(j));
    }
    scale(kernel_.column(place), Scalar(-1), kernel_.column_length());
    kernel_.substitute_unknown(place, coefficients_.data());
    if (!entering.is_velocity && entering.label.contact == contact) {
      Scalar* const response = variables_.entering_response.data();
      add_multiple(response, basis_.simplex_weight(entering.label), moved, contacts_.extent());
      variables_.entering_norm = basis_.norm_of(response);
    }
  }

  /// The only friction impulse of a contact leaves while another of it enters: that becomes the base.
  bool replace_base_by_entering(Entering& entering) {
    const Count contact = entering.label.contact;
    const Count normal = kernel_.find_column(Label{contact, kNormal});
    const Scalar mu = contacts_.mu(contact);
    const Scalar cone = basis_.covering.of_cone(contact);
    const Count z0 = cone != 0 ? kernel_.artificial() : -1;
    const Scalar* const response = variables_.entering_response.data();
    if (!kernel_.add_outer(normal, mu, z0, cone, variables_.dx.data())) return false;
    if (normal >= 0) {
      kernel_.add_to_column(normal, mu, response);
      kernel_.set_norm(normal, basis_.norm_of_column(normal));
    }
    if (z0 >= 0) kernel_.add_to_column(z0, cone, response);
    const Count row = kernel_.find_row(entering.label);
    kernel_.negate_row(row);
    const Label old_base{contact, friction_.base(contact)};
    kernel_.relabel_row(row, old_base);
    basis_.set_base(contact, entering.label.direction);
    entering = {true, old_base};
    return true;
  }

  /// A contact opens while several of its friction impulses are basic, all zero then: they go with it.
  bool open_sticking(Entering& entering, Count contact) {
    kernel_.begin_labels();
    for (Count r = kernel_.rows_left() - 1; r >= 0; --r) {
      const Label label = kernel_.row_label(r);
      if (label.contact == contact && !label.is_normal()) kernel_.drop_row_label(r);
    }
    for (Count j = kernel_.columns_left() - 1; j >= 0; --j) {
      if (kernel_.column_label(j).contact == contact) kernel_.drop_column_label(j);
    }
    const bool of_contact = entering.label.contact == contact;
    if (!of_contact && entering.is_velocity) {
      for (Count r = 0; r < kernel_.rows_left(); ++r) {
        if (kernel_.row_label(r) == entering.label) kernel_.drop_row_label(r);
      }
      ratio_test_.allow(entering.label);
    }
    if (!of_contact && !entering.is_velocity) {
      kernel_.add_column_label(entering.label);
      friction_.count_unknown(entering.label, 1);
    }
    friction_.deactivate(contact);
    entering = {true, Label{contact, kNormal}};
    return kernel_.end_labels() && rebuild();
  }

  /// Rows, columns and inverse from the labels.
  bool rebuild() {
    basis_.work += kernel_.order() * basis_.response.work();
    for (Count r = 0; r < kernel_.order(); ++r) {
      load_row(kernel_.row_label(r));
      put_row(r, kernel_.row_label(r));
    }
    Scalar* const a = basis_.column.data();
    Scalar* const response = variables_.entering_response.data();
    for (Count j = 0; j < kernel_.order(); ++j) {
      const Label label = kernel_.column_label(j);
      if (label.contact != kArtificial) {
        basis_.load_column(label, a);
        basis_.respond(a, response);
        kernel_.put_column(j, label, response, basis_.norm_of(response));
      } else if (basis_.has_drift) {
        kernel_.put_column(j, label, basis_.drift.data(), basis_.norm_of(basis_.drift.data()));
      } else {  // what z0 adds to the bases of the contacts with active friction
        for (Count i = 0; i < contacts_.extent(); ++i) a[i] = 0;
        for (Count k = 0; k < friction_.count(); ++k) {
          const Count contact = friction_.contact(k);
          const Scalar cone = basis_.covering.of_cone(contact);
          if (cone != 0) contacts_.add_direction(contact, friction_.base(contact), cone, a);
        }
        basis_.respond(a, response);
        kernel_.put_column(j, label, response, Scalar(1));
      }
    }
    return basis_.invert();
  }

  Basis<Scalar>& basis_;
  BasicVariables<Scalar>& variables_;
  RatioTest<Scalar>& ratio_test_;
  Contacts<Scalar>& contacts_;
  Kernel<Scalar>& kernel_;
  FrictionState& friction_;
  Buffer<Scalar> slip_;          ///< of a contact's directions
  Buffer<Scalar> coefficients_;  ///< per column of the kernel
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
