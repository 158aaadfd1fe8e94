#pragma once

#include <limits>
#include <utility>
#include <vector>

#include "core/answer/contact_residual.h"

namespace lcpbench {

/// How an answer leaves one bounded row, in the row's own units.
struct BoundedRowState {
  enum class At { kLower, kUpper, kBetween };

  double lower = 0;     ///< those of friction at the answer's own load [N s, N m s]
  double upper = 0;     ///< alike
  double impulse = 0;   ///< f [N s, N m s]
  /// w = R'v+ + b + r f [m/s, rad/s]; NaN where 113 bits do not tell G*
  double velocity = std::numeric_limits<double>::quiet_NaN();
  At at = At::kBetween;
};

/// "at its lower bound", "at its upper bound", "between".
const char* to_string(BoundedRowState::At at);

/// "m/s", "rad/s", of the velocity along a bounded row, and "N s", "N m s" of its impulse.
inline const char* velocity_unit(const BoundedRows& rows, Index row) {
  return rows.is_angle[static_cast<std::size_t>(row)] != 0 ? "rad/s" : "m/s";
}
inline const char* impulse_unit(const BoundedRows& rows, Index row) {
  return rows.is_angle[static_cast<std::size_t>(row)] != 0 ? "N m s" : "N s";
}

/// The bounds of a row for the impulses of all rows; those of friction from its load.
std::pair<double, double> bounds_of(const BoundedRows& rows, Index row, const Vector& impulses);

/// Tells how answers to one problem leave its bounded rows, in 113 bits.
class BoundedRowStates {
 public:
  /// @param contact  finite, must outlive this object
  explicit BoundedRowStates(const ContactProblem& contact) : residual_(contact) {}

  /// Of every bounded row. A row is at the bound that the answer's impulse is nearer to than the row is to rest, as the
  /// residual compares them. @param z  finite, of the right length
  std::vector<BoundedRowState> of(const Vector& z);

 private:
  ContactResidual residual_;
};

}  // namespace lcpbench
