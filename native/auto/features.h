#pragma once

#include <array>
#include <cstddef>

#include "core/contact_problem.h"
#include "native/contacts/body_graph.h"

namespace lcpbench {

/// What the cost of a method depends on. Logarithms are to base 2, to about 0.09, and the same on every machine.
enum class Feature {
  kOne,
  kContacts,     ///< log of their number
  kCoordinates,  ///< log of the number of those that a contact moves
  kEdges,        ///< log of the unknowns for each contact
  kSeparator,    ///< log of the coordinates whose removal cuts the problem in two, see BodyGraph
  kRedundancy,   ///< log of normals and tangents (three rows for each contact with friction) over coordinates
  kSlip,         ///< log of 1 + slip_ratio()
  kFriction,     ///< the largest mu, at most 2
  kMasses,       ///< log of the largest over the least entry of G's diagonal
  kDigits,       ///< decimal digits of the residual that is asked for
};
inline constexpr std::size_t kSizes = 5;  ///< the first ones, on which alone the cost of a load depends
inline constexpr std::size_t kFeatures = 10;

/// The largest of -(N'v + b), at least 0; infinity for what overflows to NaN. O(nonzeros)
double fastest_approach(const ContactProblem& contact, const Vector& v);

/// Of a contact problem that is one island. What is costly is measured when it is first asked for.
class Features {
 public:
  /// Another problem. O(contacts) @param idle coordinates that no contact moves, which do not count
  void begin(const ContactProblem& contact, Index idle);
  /// Another velocity, on which the slip alone depends.
  void forget_slip() { has_slip_ = is_measured_ = false; }

  /// Normals and tangents (two for each contact with friction) over coordinates.
  double redundancy() const { return redundancy_; }
  /// The fastest slip at velocity v, over the largest mu times the fastest approach: friction may hold every contact
  /// where that is at most 1. Offsets count as approach. O(nonzeros)
  double slip_ratio(const ContactProblem& contact, const Vector& v);
  /// All, by Feature. O(nonzeros)
  /// @param digits of the residual that is asked for
  const std::array<double, kFeatures>& measure(const ContactProblem& contact, const Vector& v, double digits);

 private:
  double& of(Feature feature) { return values_[static_cast<std::size_t>(feature)]; }

  BodyGraph graph_;
  std::array<double, kFeatures> values_{};
  double contacts_ = 0;
  double coordinates_ = 0;
  double redundancy_ = 0;
  double largest_mu_ = 0;
  double slip_ratio_ = 0;
  double masses_ = -1;  ///< log of their ratio; negative: not measured yet
  double separator_ = 0;
  bool has_slip_ = false;
  bool is_measured_ = false;
};

}  // namespace lcpbench
