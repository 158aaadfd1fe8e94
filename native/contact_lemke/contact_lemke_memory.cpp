// The memory that contact_lemke's engines reserve before problems come.
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "native/contact_lemke/contact_lemke.h"

namespace lcpbench {

void ContactLemke::reserve(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  if (may_be_unsolvable(contact)) farkas_.reserve(contact);
  doubtful_.reserve(contact);
  const Index ngc = ContactInput::coordinates(contact);
  if (!has_layout(contact)) return reserve(ngc, contact.nc());
  data_.reserve(ngc, contact.nc(), cols(contact.D));
  best_.reserve(problem.size());
  z_.reserve(problem.size());
  for (GrowingVector* of_coordinates : {&velocity_, &best_velocity_, &resumable_v_, &given_v_}) {
    of_coordinates->reserve(ngc);
  }
  data_.load_layout(contact);
  reserve_engines(data_.input);
}

/// For all frictionless problems up to these dimensions: the same sizes again and again ask for nothing.
void ContactLemke::reserve(Index ngc, Index nc) {
  if (ngc <= reserved_ngc_ && nc <= reserved_nc_) return;
  reserved_ngc_ = std::max(ngc, reserved_ngc_);
  reserved_nc_ = std::max(nc, reserved_nc_);
  data_.reserve(reserved_ngc_, reserved_nc_, 0);
  best_.reserve(reserved_nc_);
  z_.reserve(reserved_nc_);
  for (GrowingVector* of_coordinates : {&velocity_, &best_velocity_, &resumable_v_, &given_v_}) {
    of_coordinates->reserve(reserved_ngc_);
  }
  const std::vector<std::ptrdiff_t> no_friction(static_cast<std::size_t>(reserved_nc_) + 1, 0);
  contact_lemke::Input input;
  input.ngc = reserved_ngc_;
  input.nc = reserved_nc_;
  input.friction_begin = no_friction.data();
  reserve_engines(input);
}

void ContactLemke::reserve_engines(const contact_lemke::Input& input) {
  double_.reserve(input);
  reserve_later_stages(input);
}

void ContactLemke::reserve_later_stages(const contact_lemke::Input& input) {
  if (has_room_in_later_stages(input)) return;
  later_->quad.reserve(input);  // with precision=double too, where it tests what double is in doubt of
  later_->holder = nullptr;
}

/// Whether a problem that is not smaller in any respect was the last to be reserved. If not, this one will be.
bool ContactLemke::has_room_in_later_stages(const contact_lemke::Input& input) {
  std::array<std::ptrdiff_t, 8> room{
      input.ngc, input.nc, 0, 0, 0, 0, input.inertia.Ginv == nullptr ? 1 : 0, input.compliance_n != nullptr ? 1 : 0};
  for (std::ptrdiff_t c = 0; c < input.nc; ++c) {
    const std::ptrdiff_t edges = input.friction_begin[c + 1] - input.friction_begin[c];
    const bool has_friction = edges > 0 && input.mu != nullptr && input.mu[c] > 0;
    room[2] = std::max(room[2], edges);
    room[3] += edges;
    room[4] += has_friction ? 1 : 0;
    room[5] += has_friction ? edges : 0;
  }
  bool has_room = true;
  for (std::size_t k = 0; k < room.size(); ++k) has_room = has_room && room[k] <= room_in_later_stages_[k];
  if (!has_room) room_in_later_stages_ = room;
  return has_room;
}

}  // namespace lcpbench
