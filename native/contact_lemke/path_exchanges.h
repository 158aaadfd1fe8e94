#pragma once

#include "native/contact_lemke/path.h"

// How the basis changes.

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basis changes; `entering` becomes the complement of what left.
template <class Scalar>
inline bool Path<Scalar>::exchange(Entering& entering, LeavingVariable leaving) {
  if (leaving.kind == Kind::kBase) {
    const Count contact = leaving.label.contact;
    if (friction_.support(contact) == 0) return replace_base_by_entering(entering);
    leaving.column = change_base(contact, entering);
    leaving.kind = Kind::kColumn;
  }
  if (leaving.kind == Kind::kVelocity) return bring_row(entering, leaving.label);
  const bool contact_opens = leaving.label.is_normal() && !rules_.classic && friction_.is_active(leaving.label.contact);
  if (contact_opens && has_friction_labels(leaving.label.contact, entering)) {
    return open_sticking(entering, leaving.label.contact);
  }
  drop_column(entering, leaving.column);
  if (contact_opens) friction_.deactivate(leaving.label.contact);
  entering = {true, leaving.label};
  return true;
}

template <class Scalar>
inline void Path<Scalar>::drop_column(const Entering& entering, Count column) {
  friction_.count_unknown(kernel_.column_label(column), -1);
  if (entering.is_velocity) {
    ratio_test_.allow(entering.label);
    kernel_.remove(kernel_.find_row(entering.label), column);
    const Count last = kernel_.order();
    artificial_ = artificial_ == column ? -1 : (artificial_ == last ? column : artificial_);
  } else {
    kernel_.replace_column(column, dx_.data());
    kernel_.put_column(column, entering.label, entering_response_.data(), entering_norm_);
    friction_.count_unknown(entering.label, 1);
    artificial_ = artificial_ == column ? -1 : artificial_;
  }
}

template <class Scalar>
inline bool Path<Scalar>::bring_row(Entering& entering, Label leaving) {
  load_row(leaving);
  const Scalar cover = covering_.of(leaving);
  const Scalar target = -dot(row_.data(), contacts_.velocity(), contacts_.extent());
  ratio_test_.forbid(leaving);
  if (entering.is_velocity) {
    const Count r = kernel_.find_row(entering.label);
    if (!kernel_.replace_row(r, row_.data(), cover, artificial_)) return false;
    kernel_.put_row(r, leaving, row_.data(), cover, target);
    ratio_test_.allow(entering.label);
  } else {
    if (kernel_.full()) return false;
    if (!kernel_.append(row_.data(), cover, artificial_, entering_response_.data(), dx_.data())) return false;
    const Count last = kernel_.order();
    kernel_.put_row(last, leaving, row_.data(), cover, target);
    kernel_.put_column(last, entering.label, entering_response_.data(), entering_norm_);
    kernel_.grow();
    friction_.count_unknown(entering.label, 1);
  }
  entering = {false, leaving};
  return true;
}

/// The friction impulse in the column `place` becomes the base, the old base the unknown there.
template <class Scalar>
inline void Path<Scalar>::make_base(Count contact, Count place, const Entering& entering) {
  const Count old_base = friction_.base(contact);
  const Label new_base = kernel_.column_label(place);
  const Count row = kernel_.find_row(new_base);
  move_rows(contact, row);
  move_columns(contact, place, entering);
  set_base(contact, new_base.direction);
  kernel_.relabel_row(row, Label{contact, old_base});
  kernel_.relabel_column(place, Label{contact, old_base});
  x_[place] = simplex_[contact].value;
  dx_[place] = simplex_[contact].rate;
}

template <class Scalar>
inline Count Path<Scalar>::largest_friction_column(Count contact) const {
  Count largest = -1;
  for (Count j = 0; j < kernel_.order(); ++j) {
    if (is_friction_of(contact, j) && (largest < 0 || x_[j] > x_[largest])) largest = j;
  }
  return largest;
}

/// d_s - d_t becomes d_s - d_new; the new base's own row that of the old base.
template <class Scalar>
inline void Path<Scalar>::move_rows(Count contact, Count row) {
  for (Count r = 0; r < kernel_.order(); ++r) {
    const Label label = kernel_.row_label(r);
    if (r != row && label.contact == contact && !label.is_normal()) kernel_.subtract_row(r, row);
  }
  kernel_.negate_row(row);
}

template <class Scalar>
inline void Path<Scalar>::move_columns(Count contact, Count place, const Entering& entering) {
  const Count order = kernel_.order();
  for (Count j = 0; j < P::padded(order); ++j) coefficients_[j] = 0;
  kernel_.get_column(place, column_.data());
  for (Count j = 0; j < order; ++j) {
    const Label label = kernel_.column_label(j);
    if (j == artificial_) {
      coefficients_[j] = covering_.of_cone(contact);
    } else if (label.contact == contact) {
      coefficients_[j] = simplex_weight(label);
    } else {
      continue;
    }
    if (j != place) kernel_.add_to_column(j, coefficients_[j], column_.data());
    if (j != artificial_) kernel_.set_norm(j, norm_of_column(j));
  }
  scale(kernel_.column(place), Scalar(-1), kernel_.column_length());
  kernel_.substitute_unknown(place, coefficients_.data());
  if (!entering.is_velocity && entering.label.contact == contact) {
    add_multiple(entering_response_.data(), simplex_weight(entering.label), column_.data(), contacts_.extent());
    entering_norm_ = norm_of(entering_response_.data());
  }
}

/// The only friction impulse of a contact leaves while another of it enters: that becomes the base.
template <class Scalar>
inline bool Path<Scalar>::replace_base_by_entering(Entering& entering) {
  const Count contact = entering.label.contact;
  const Count normal = kernel_.find_column(Label{contact, kNormal});
  const Scalar mu = contacts_.mu(contact);
  const Scalar cone = covering_.of_cone(contact);
  const Count z0 = cone != 0 ? artificial_ : -1;
  if (!kernel_.add_outer(normal, mu, z0, cone, dx_.data())) return false;
  if (normal >= 0) {
    kernel_.add_to_column(normal, mu, entering_response_.data());
    kernel_.set_norm(normal, norm_of_column(normal));
  }
  if (z0 >= 0) kernel_.add_to_column(z0, cone, entering_response_.data());
  const Count row = kernel_.find_row(entering.label);
  kernel_.negate_row(row);
  const Label old_base{contact, friction_.base(contact)};
  kernel_.relabel_row(row, old_base);
  set_base(contact, entering.label.direction);
  entering = {true, old_base};
  return true;
}

/// A contact opens while several of its friction impulses are basic, all zero then: they go with it.
template <class Scalar>
inline bool Path<Scalar>::open_sticking(Entering& entering, Count contact) {
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
template <class Scalar>
inline bool Path<Scalar>::rebuild() {
  artificial_ = kernel_.find_column(Label{});
  outcome_.work += kernel_.order() * response_.work();
  for (Count r = 0; r < kernel_.order(); ++r) {
    const Label label = kernel_.row_label(r);
    load_row(label);
    kernel_.put_row(r, label, row_.data(), covering_.of(label),
                    -dot(row_.data(), contacts_.velocity(), contacts_.extent()));
  }
  for (Count j = 0; j < kernel_.order(); ++j) {
    const Label label = kernel_.column_label(j);
    if (resumed_ && label.contact == kArtificial) {
      kernel_.put_column(j, label, drift_.data(), norm_of(drift_.data()));
      continue;
    }
    load_any_column(label);
    respond(column_.data(), entering_response_.data());
    const Scalar norm = label.contact == kArtificial ? Scalar(1) : norm_of(entering_response_.data());
    kernel_.put_column(j, label, entering_response_.data(), norm);
  }
  return invert();
}

template <class Scalar>
inline void Path<Scalar>::load_any_column(Label label) {
  if (label.contact != kArtificial) return load_column(label);
  for (Count i = 0; i < contacts_.extent(); ++i) column_[i] = 0;
  if (!rules_.classic) return;
  for (Count k = 0; k < friction_.count(); ++k) {
    contacts_.add_direction(friction_.contact(k), friction_.base(friction_.contact(k)),
                            covering_.of_cone(friction_.contact(k)), column_.data());
  }
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
