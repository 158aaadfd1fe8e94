#pragma once

#include <new>
#include <type_traits>

#include "native/kernels/pack.h"
#include "native/lemke/path.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

template <class Basis>
struct Held {
  Basis basis;
};

/// The functions of an Engine over an object that holds a `basis`.
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
    if constexpr (!std::remove_reference_t<decltype(basis)>::kRulesOf2012) {
      if (rules.resolve) return follow_path<true, Scalar>(basis, rules, z);
    }
    return follow_path<false, Scalar>(basis, rules, z);
  }
};

template <class Scalar, class Object>
constexpr Engine engine_over(decltype(Engine::walk) walk) {
  using I = Interface<Scalar, Object>;
  return {I::create, I::destroy, I::load, I::solve, walk};
}

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
