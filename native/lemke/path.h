#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/lemke_engine.h"
#include "native/lemke/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

constexpr Count kPivotsPerClockReading = 16;

inline Count complement(Count variable, Count n) { return variable < n ? variable + n : variable - n; }

/// Writes z; false when a value is not finite.
template <class Basis>
bool write_solution(const Basis& basis, double* z) {
  const auto& slots = basis.slots();
  const Count n = basis.problem().n();
  for (Count i = 0; i < slots.count; ++i) {
    if (!(slots.x[i] - slots.x[i] == 0)) return false;
  }
  for (Count i = 0; i < slots.count; ++i) {
    const double id = slots.id[i];
    if (id >= static_cast<double>(n) && id < static_cast<double>(2 * n)) z[static_cast<Count>(id) - n] = slots.x[i];
  }
  return true;
}

/// How a path ends on which the artificial variable has left; writes the basic entries of z.
template <class Basis>
Ending finish(Basis& basis, Outcome& outcome, double* z) {
  ++outcome.factorizations;
  if (!basis.resolve()) return Ending::kBreakdown;
  return write_solution(basis, z) ? Ending::kSolved : Ending::kBreakdown;
}

inline bool out_of_time(const Rules& rules) {
  return rules.deadline_s < kInfinity<double> && !(rules.clock_s() < rules.deadline_s);
}

/// Lemke's path from the first exchange to its end.
template <class Basis>
Outcome follow_path(Basis& basis, const Rules& rules, double* z) {
  const Count n = basis.problem().n();
  const Count artificial = basis.problem().artificial();
  Count leaving = basis.problem().last_to_be_covered();
  basis.start(leaving);
  Outcome outcome;
  while (leaving != artificial) {
    if (outcome.pivots >= rules.max_pivots) return outcome.ending = Ending::kPivotLimit, outcome;
    if (outcome.pivots % kPivotsPerClockReading == 0 && out_of_time(rules)) {
      return outcome.ending = Ending::kTimeLimit, outcome;
    }
    const Count entering = complement(leaving, n);
    ++outcome.factorizations;
    if (!basis.solve(entering)) return outcome;
    const Blocking blocking = ratio_test(basis.slots(), rules, artificial, basis.slot_of(artificial));
    if (blocking.kind == Block::kRay) return outcome.ending = Ending::kRay, outcome;
    if (blocking.kind == Block::kBreakdown) return outcome;
    leaving = blocking.leaving;
    basis.exchange(entering, leaving);
    ++outcome.pivots;
    if (rules.on_pivot != nullptr) rules.on_pivot(rules.context, entering, leaving);
  }
  outcome.ending = finish(basis, outcome, z);
  return outcome;
}

/// An engine over one representation of the basis.
template <class Basis>
class BasisEngine final : public Engine {
 public:
  void load(const Input& input) override { basis_.load(input); }

  Outcome solve(const Rules& rules, double* z) override {
    if (basis_.problem().zero_solves(rules.zero_tolerance)) return {.ending = Ending::kSolved};
    return follow_path(basis_, rules, z);
  }

 private:
  Basis basis_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
