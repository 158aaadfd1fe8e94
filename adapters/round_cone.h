#pragma once

#include <string>
#include <vector>

#include "adapters/define_adapter.h"

namespace lcpbench {

/// The contacts of a problem as W r + q = u with the round cone |r_t| <= mu r_N in place of each pyramid.
///
/// A contact has three rows, its normal and two tangents, which are the directions 0 and edges / 4: see
/// why_no_round_cone(). Without friction the cone is the half-line of the LCP, and the two problems are one. Of a bare
/// LCP with a symmetric M every row is a contact without friction. For adapters of solvers of the round cone.
class RoundCones {
 public:
  /// Rows of a contact without friction: one, or three, with mu = 0 and tangents that nothing couples (W_ii = 1, q_i =
  /// 0).
  enum class Frictionless { kOneRow, kThreeRows };

  /// Replaces pyramids by their cones. Forms M: O(n^2) numbers. @returns why there is no such form, or ""; after a
  /// reason nothing else may be called
  std::string load(const Problem& problem, Frictionless frictionless);

  bool frictional() const { return layout_.cones > 0; }
  Index contacts() const { return layout_.nc; }
  const Matrix& W() const { return W_; }
  const Vector& q() const { return q_; }
  double mu(Index contact) const { return mu_[static_cast<std::size_t>(contact)]; }
  /// The row of a contact's normal; its tangents, if it has any, are the next two.
  Index normal_row(Index contact) const { return normal_row_[static_cast<std::size_t>(contact)]; }
  bool has_tangents(Index contact) const;

  /// The impulses in z of the LCP: a friction impulse on the two directions that it lies between, lambda as the largest
  /// slip along a direction.
  void write(const Vector& r, Vector& z) const;
  /// The impulses r of a z of the LCP.
  Vector read(const Vector& z) const;

 private:
  /// Where a contact's friction directions are in z, and how many.
  auto directions(Index contact) const {
    const auto i = static_cast<std::size_t>(contact);
    return std::pair(layout_.friction_offset() + layout_.friction_begin[i],
                     layout_.friction_begin[i + 1] - layout_.friction_begin[i]);
  }

  Lcp lcp_;
  ContactLayout layout_;
  Matrix W_;
  Vector q_;
  std::vector<double> mu_;
  std::vector<Index> normal_row_;
};

/// z of the LCP has impulses: lambda becomes the largest slip along a direction. @pre lambda is zero
void complete_slip_bounds(const Lcp& lcp, const ContactLayout& layout, Vector& z);

inline constexpr const char* kConeHelp =
    "solve contacts with friction with the round cone, which is another problem; false: refuse them";

/// An adapter that takes contacts with friction if its setting `cone` is true.
template <class Settings>
class RoundConeAdapter : public Adapter<Settings> {
 public:
  using Adapter<Settings>::Adapter;
  const Capabilities& capabilities() const override {
    return this->settings_.cone ? kConeCapabilities : Settings::capabilities;
  }

 protected:
  RoundCones cones_;

 private:
  static constexpr Capabilities kConeCapabilities{.guarantees = Settings::capabilities.guarantees,
                                                  .warm_start = Settings::capabilities.warm_start};
};

}  // namespace lcpbench
