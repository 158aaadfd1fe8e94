#pragma once

#include <cstdint>
#include <memory>

#include "core/solver.h"

namespace lcpbench {

/// psor with limits that may change from one solve to the next.
class LimitedPsor : public Solver {
 public:
  /// From now on acceleration=exact, or local.
  virtual void take_parts(bool exact) = 0;
  /// From now on at most so many sweeps at the default relaxation, and solved is claimed up to this residual.
  virtual void limit_sweeps(std::int64_t sweeps, double tolerance) = 0;
  /// From now on solved is claimed up to this residual, be it more than the verdict allows.
  virtual void aim_at(double residual) = 0;
  /// From now on psor's defaults; with acceleration=exact 100,000 sweeps with relaxation 1, another path than that of
  /// limited sweeps.
  virtual void unlimit_sweeps() = 0;

  /// The velocity that these impulses give to the contacts that are loaded, O(nonzeros). Allocates nothing.
  /// @param z n entries @param u ngc entries
  virtual void respond(const Vector& z, Vector& u) = 0;
};

/// With acceleration=exact, not limited.
std::unique_ptr<LimitedPsor> make_limited_psor();

}  // namespace lcpbench
