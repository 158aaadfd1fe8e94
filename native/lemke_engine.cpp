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

template <class Basis>
struct Held {
  Basis basis;
};

/// A kernel basis with the room in which a sweep's paths part.
template <class Scalar>
struct HeldWithRoom {
  KernelBasis<Scalar> basis;
  TreeRoom<Scalar> room;
};

template <class Scalar, class Object>
struct Interface {
  static void* create() { return new (allocate_aligned(sizeof(Object))) Object; }
  static void destroy(void* object) {
    static_cast<Object*>(object)->~Object();
    free_aligned(object);
  }
  static void load(void* object, const Input& input) { static_cast<Object*>(object)->basis.load(input); }
  static Outcome solve(void* object, const Rules& rules, double* z) {
    auto& basis = static_cast<Object*>(object)->basis;
    Outcome outcome;
    if (basis.problem().zero_solves(static_cast<Scalar>(rules.zero_tolerance))) {
      outcome.ending = Ending::kSolved;
      return outcome;
    }
    return rules.resolve ? follow_path<true, Scalar>(basis, rules, z) : follow_path<false, Scalar>(basis, rules, z);
  }
};

template <class Scalar>
Count walk(void* object, const Cell* cells, Count count, const WalkRules& rules, double* z) {
  auto& [basis, room] = *static_cast<HeldWithRoom<Scalar>*>(object);
  if (rules.resolve) return PathTree<true, Scalar>(basis, room, cells, rules, z).walk(count);
  return PathTree<false, Scalar>(basis, room, cells, rules, z).walk(count);
}

template <class Object>
constexpr Engine engine_over(decltype(Engine::walk) walk) {
  using I = Interface<double, Object>;
  return {I::create, I::destroy, I::load, I::solve, walk};
}

}  // namespace

const Engine kDenseEngine = engine_over<Held<DenseBasis<double>>>(nullptr);
const Engine kKernelEngine = engine_over<HeldWithRoom<double>>(walk<double>);

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
