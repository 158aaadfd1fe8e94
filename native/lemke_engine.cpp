// Lemke's pivoting with LEMKE's rules over two representations of the basis. Compiled once per instruction-set level
// into the namespace LCPBENCH_LEVEL; see lemke_engine.h for what may cross the border.
#include "native/lemke_engine.h"

#include <new>

#include "native/lemke_engine/dense_basis.h"
#include "native/lemke_engine/kernel_basis.h"
#include "native/lemke_engine/pack.h"
#include "native/lemke_engine/path.h"
#include "native/lemke_engine/path_tree.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {
namespace {

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
    return rules.resolve ? follow_path<true, Scalar>(basis, rules, z) : follow_path<false, Scalar>(basis, rules, z);
  }
};

/// A kernel basis with the room in which a sweep's paths part.
template <class Scalar>
struct BranchingKernelBasis : KernelBasis<Scalar> {
  TreeRoom<Scalar> room;
};

template <class Scalar>
Count walk(void* memory, const Cell* cells, Count count, const WalkRules& rules, double* z) {
  auto& basis = *static_cast<BranchingKernelBasis<Scalar>*>(memory);
  if (rules.resolve) return PathTree<true, Scalar>(basis, basis.room, cells, rules, z).walk(count);
  return PathTree<false, Scalar>(basis, basis.room, cells, rules, z).walk(count);
}

template <class Basis>
constexpr Engine engine_over(decltype(Engine::walk) walk) {
  using I = Interface<double, Basis>;
  return {I::create, I::destroy, I::load, I::solve, walk};
}

}  // namespace

const Engine kDenseEngine = engine_over<DenseBasis<double>>(nullptr);
const Engine kKernelEngine = engine_over<BranchingKernelBasis<double>>(walk<double>);

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
