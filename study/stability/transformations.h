#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "core/problem.h"
#include "generators/random.h"

namespace lcpbench {

/// Changes of a problem whose effect on the physical answer is known: exactly, or (the last two) as a small bound.
enum class TransformationKind {
  kRowScaling,      ///< bare LCP: rows of M and q by powers of two, 2^-10 to 2^10
  kColumnScaling,   ///< bare LCP: columns of M
  kContactScaling,  ///< columns of N and D, those of one contact by one power of two
  kMassUnit,        ///< kg to g: G 1,000 times as large
  kLengthUnit,      ///< m to mm: v, lever arms and moments of inertia
  kPermutation,     ///< another order of the contacts, or of the rows and columns of a bare LCP
  kDirectionOrder,  ///< friction columns of each contact shifted cyclically
  kDuplicate,       ///< one contact twice
  kNearDuplicate,   ///< one contact twice, every entry of the second off by 2^-30
  kOneUlp,          ///< every number but zeros moved to a neighbouring double
};

inline constexpr std::array kAllTransformations{TransformationKind::kRowScaling,     TransformationKind::kColumnScaling,
                                                TransformationKind::kContactScaling, TransformationKind::kMassUnit,
                                                TransformationKind::kLengthUnit,     TransformationKind::kPermutation,
                                                TransformationKind::kDirectionOrder, TransformationKind::kDuplicate,
                                                TransformationKind::kNearDuplicate,  TransformationKind::kOneUlp};

/// "row_scaling", "column_scaling", "contact_scaling", "kg_to_g", "m_to_mm", "permutation", "direction_order",
/// "duplicate", "near_duplicate", "one_ulp".
const char* to_string(TransformationKind kind);

/// False for changes that are exact (changes of units: except for the rounding of products by 1,000).
bool perturbs(TransformationKind kind);

/// One transformation, drawn for one problem.
struct Transformation {
  std::function<Problem(const Problem&)> apply;
  /// Undoes `apply` bit for bit (units: where the products by 1,000 were exact).
  std::function<Problem(const Problem&)> undo;
  /// The velocity (ngc) of a transformed contact problem in the coordinates and units of the original.
  std::function<Vector(Vector)> velocity_back;
  /// z of a transformed bare LCP as an answer to the original.
  std::function<Vector(Vector)> unknowns_back;
  /// Relative size of the change of the data, entry by entry; 0 where there is none.
  double data_change = 0;
};

/// Draws a transformation for a problem. A scene stays one under units, permutation, duplicates and neighbouring
/// doubles; else its contact problem is changed.
/// @param key, attempt  the random stream: equal ones give the same transformation
/// @returns nullopt where the kind does not apply: to the other form of problem, without friction, to fewer than two
/// contacts (rows) to permute; where it would not leave the solution set as it is (a change of units where only a
/// singular G* is known); or where a neighbouring G is not positive definite. Draws of a scene and of its contact
/// problem are the same, but for neighbouring doubles.
std::optional<Transformation> draw_transformation(TransformationKind kind, const Problem& problem, const TrialKey& key,
                                                  std::uint64_t attempt);

}  // namespace lcpbench
