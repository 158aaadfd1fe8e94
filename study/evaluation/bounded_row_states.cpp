#include "study/evaluation/bounded_row_states.h"

#include <cmath>

namespace lcpbench {
namespace {

/// Which of M_ii (f - lower), M_ii (f - upper) and w is the middle one. An impulse that rounding parts from its bound
/// is at it.
BoundedRowState::At place_of(const BoundedRowState& state, double diagonal) {
  constexpr double kRounding = 1e-12;
  const auto reaches = [&](double bound) {
    return std::isfinite(bound) && std::abs(state.impulse - bound) <= kRounding * std::abs(bound);
  };
  if (reaches(state.lower)) return BoundedRowState::At::kLower;
  if (reaches(state.upper)) return BoundedRowState::At::kUpper;
  if (std::isfinite(state.lower) && state.velocity >= diagonal * (state.impulse - state.lower)) {
    return BoundedRowState::At::kLower;
  }
  if (std::isfinite(state.upper) && state.velocity <= diagonal * (state.impulse - state.upper)) {
    return BoundedRowState::At::kUpper;
  }
  return BoundedRowState::At::kBetween;
}

}  // namespace

const char* to_string(BoundedRowState::At at) {
  constexpr const char* kNames[] = {"at its lower bound", "at its upper bound", "between"};
  return kNames[static_cast<std::size_t>(at)];
}

std::pair<double, double> bounds_of(const BoundedRows& rows, Index row, const Vector& impulses) {
  const int of = rows.bounds.friction_of[static_cast<std::size_t>(row)];
  if (of < 0) return {rows.bounds.lower(row), rows.bounds.upper(row)};
  const double limit = std::abs(rows.bounds.mu(row) * impulses(of));
  return {-limit, limit};
}

std::vector<BoundedRowState> BoundedRowStates::of(const Vector& z) {
  const BoundedRows& rows = residual_.problem.rows;
  const Vector impulses = z.tail(rows.size());
  ContactResidual::Point point;
  if (residual_.lcp) residual_.take(z, point);
  const bool is_known = residual_.lcp && point.is_finite();
  std::vector<BoundedRowState> states;
  for (Index row = 0; row < rows.size(); ++row) {
    const auto [lower, upper] = bounds_of(rows, row, impulses);
    BoundedRowState& state = states.emplace_back(BoundedRowState{lower, upper, impulses(row)});
    const std::size_t i = is_known ? residual_.lcp->first_bounded() + static_cast<std::size_t>(row) : 0;
    if (is_known) state.velocity = to_double(point.w[i]);
    state.at = place_of(state, is_known ? to_double(residual_.lcp->diagonal(i)) : 0);
  }
  return states;
}

}  // namespace lcpbench
