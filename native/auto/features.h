#pragma once

#include <array>
#include <cstddef>

#include "core/contact_problem.h"

namespace lcpbench {

/// What the cost of a method depends on. Logarithms are to base 2, to about 0.09, and the same on every machine.
enum class Feature {
  kOne,
  kContacts,     ///< log of their number
  kCoordinates,  ///< log of the number of those that a contact moves
  kEdges,        ///< log of the unknowns for each contact
  kSeparator,    ///< log of the coordinates whose removal cuts the problem in two, see separator_size()
  kRedundancy,   ///< log of normals and tangents (three rows for each contact with friction) over coordinates
  kSlip,         ///< log of 1 + slip ratio
  kFriction,     ///< the largest mu, at most 2
  kMasses,       ///< log of the largest over the least entry of G's diagonal
  kDigits,       ///< decimal digits of the residual that is asked for
};
inline constexpr std::size_t kSizes = 5;  ///< the first ones, on which alone the cost of a load depends
inline constexpr std::size_t kFeatures = 10;

/// Of a contact problem that is one island, but for kDigits, which is 0. O(nonzeros); allocates for more than two
/// blocks of G. The slip alone depends on the velocity.
class Features {
 public:
  /// @param idle coordinates that no contact moves, which do not count
  void measure(const ContactProblem& contact, const Vector& v, Index idle);
  void set_velocity(const ContactProblem& contact, const Vector& v);
  void set_digits(double digits) { of(Feature::kDigits) = digits; }

  double operator[](Feature feature) const { return values_[static_cast<std::size_t>(feature)]; }
  const std::array<double, kFeatures>& values() const { return values_; }

  /// The fastest slip at the velocity now, over the largest mu times the fastest approach: friction may hold every
  /// contact where that is at most 1. Offsets count as approach.
  double slip_ratio() const { return slip_ratio_; }
  /// Normals and tangents over coordinates.
  double redundancy() const { return redundancy_; }

 private:
  double& of(Feature feature) { return values_[static_cast<std::size_t>(feature)]; }

  std::array<double, kFeatures> values_{};
  double largest_mu_ = 0;
  double slip_ratio_ = 0;
  double redundancy_ = 0;
};

}  // namespace lcpbench
