#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/path.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// An engine over one representation of the basis.
template <class Basis>
class BasisEngine : public Engine {
 public:
  void load(const Input& input) override { basis_.load(input); }

  Outcome solve(const Rules& rules, double* z) override {
    if (basis_.problem().zero_solves(rules.zero_tolerance)) return {.ending = Ending::kSolved};
    if constexpr (!Basis::kRulesOf2012) {
      if (rules.resolve) return follow_path<true>(basis_, rules, z);
    }
    return follow_path<false>(basis_, rules, z);
  }

  Count walk(const Cell*, Count, const WalkRules&, double*) override { return 0; }

 protected:
  Basis basis_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
