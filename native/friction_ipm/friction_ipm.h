#pragma once

#include <cstdint>
#include <memory>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// friction_ipm with limits that may change from one solve to the next. A solve in parts begins with the settings
/// given. If it has a start, the first slip bounds are those of the velocity that the start gives.
class LimitedFrictionIpm : public ResumableSolver {
 public:
  /// From now on at most so many convex problems, and solved is claimed only up to this residual (accept_residual).
  virtual void limit_rounds(std::int64_t rounds, double accept_residual) = 0;
  /// From now on rounds end at this residual, up to which solved is claimed, be it more than the verdict allows.
  virtual void aim_at(double residual) = 0;
  /// As the settings have it.
  virtual void unlimit_rounds() = 0;
};

/// At the defaults of friction_ipm.
std::unique_ptr<LimitedFrictionIpm> make_friction_ipm();

}  // namespace lcpbench
