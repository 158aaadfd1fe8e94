// Lemke's pivoting with LEMKE's rules over two representations of the basis. Compiled once per instruction-set level
// into the namespace LCPBENCH_LEVEL; see lemke_engine.h for what may cross the border.
#include "native/lemke_engine.h"

#include <new>

#include "native/lemke_engine/dense_basis.h"
#include "native/lemke_engine/kernel_basis.h"
#include "native/lemke_engine/pack.h"
#include "native/lemke_engine/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {
namespace {

Count complement(Count variable, Count n) { return variable < n ? variable + n : variable - n; }

bool out_of_time(const Rules& rules) {
  return rules.deadline_s < kInfinity<double> && !(rules.clock_s() < rules.deadline_s);
}

/// Lemke's path from the first exchange to its end. On kSolved the basis holds the solution's values.
template <bool kResolve, class Scalar, class Basis>
Outcome follow_path(Basis& basis, const Rules& rules) {
  const Count n = basis.problem().n();
  const Count artificial = basis.problem().artificial();
  const Scalar pivot_tolerance = static_cast<Scalar>(rules.pivot_tolerance);
  const Scalar zero_tolerance = static_cast<Scalar>(rules.zero_tolerance);
  Outcome outcome;
  Count leaving = basis.problem().most_negative_row();
  basis.start(leaving);
  while (leaving != artificial) {
    if (outcome.pivots >= rules.max_pivots) return outcome.ending = Ending::kPivotLimit, outcome;
    if (outcome.pivots % 16 == 0 && out_of_time(rules)) return outcome.ending = Ending::kTimeLimit, outcome;
    const Count entering = complement(leaving, n);
    ++outcome.factorizations;
    if (!basis.template solve<kResolve>(entering)) return outcome;
    const Blocking<Scalar> blocking =
        ratio_test(basis.slots(), pivot_tolerance, zero_tolerance, artificial, basis.slot_of(artificial));
    if (blocking.kind == Block::kRay) return outcome.ending = Ending::kRay, outcome;
    if (blocking.kind == Block::kBreakdown) return outcome;
    leaving = blocking.slot_id;
    const Scalar value = kResolve ? Scalar(0) : advance(basis.slots(), basis.slot_of(leaving));
    basis.exchange(entering, leaving, value);
    ++outcome.pivots;
    if (rules.on_pivot != nullptr) rules.on_pivot(rules.context, entering, leaving);
  }
  if constexpr (kResolve) {
    ++outcome.factorizations;
    if (!basis.resolve()) return outcome;
  }
  outcome.ending = Ending::kSolved;
  return outcome;
}

/// Writes z; false when a value is not finite.
template <class Scalar, class Basis>
bool write_solution(const Basis& basis, double* z) {
  const Slots<Scalar>& slots = basis.slots();
  const Count n = basis.problem().n();
  for (Count i = 0; i < slots.count; ++i) {
    if (!(slots.x[i] - slots.x[i] == 0)) return false;
  }
  for (Count i = 0; i < slots.count; ++i) {
    const Scalar id = slots.id[i];
    if (id >= static_cast<Scalar>(n) && id < static_cast<Scalar>(2 * n)) {
      z[static_cast<Count>(id) - n] = static_cast<double>(slots.x[i]);
    }
  }
  return true;
}

template <class Scalar, class Basis>
struct Interface {
  static void* create() { return new (allocate_aligned(sizeof(Basis))) Basis; }
  static void destroy(void* basis) {
    static_cast<Basis*>(basis)->~Basis();
    free_aligned(basis);
  }
  static void load(void* basis, const Input& input) { static_cast<Basis*>(basis)->load(input); }
  static Outcome solve(void* memory, const Rules& rules, double* z) {
    Basis& basis = *static_cast<Basis*>(memory);
    Outcome outcome;
    if (basis.problem().zero_solves(static_cast<Scalar>(rules.zero_tolerance))) {
      outcome.ending = Ending::kSolved;
      return outcome;
    }
    outcome = rules.resolve ? follow_path<true, Scalar>(basis, rules) : follow_path<false, Scalar>(basis, rules);
    if (outcome.ending == Ending::kSolved && !write_solution<Scalar>(basis, z)) outcome.ending = Ending::kBreakdown;
    return outcome;
  }
};

template <class Basis>
constexpr Engine engine_over() {
  using I = Interface<double, Basis>;
  return {I::create, I::destroy, I::load, I::solve};
}

}  // namespace

const Engine kDenseEngine = engine_over<DenseBasis<double>>();
const Engine kKernelEngine = engine_over<KernelBasis<double>>();

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
