#pragma once

#include <new>

#include "native/active_set/dual_method.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

template <class Scalar>
struct Interface {
  using Method = DualMethod<Scalar>;

  static void* create() { return new (lemke::allocate_aligned(sizeof(Method))) Method; }
  static void destroy(void* engine) {
    static_cast<Method*>(engine)->~Method();
    lemke::free_aligned(engine);
  }
  static void reserve(void* engine, const Input& input) { static_cast<Method*>(engine)->reserve(input); }
  static void load(void* engine, const Input& input) { static_cast<Method*>(engine)->load(input); }
  static void update(void* engine, const double* v) { static_cast<Method*>(engine)->update(v); }
  static Outcome solve(void* engine, const Rules& rules, double* z, double* velocity, double* u) {
    return static_cast<Method*>(engine)->solve(rules, z, velocity, u);
  }
  static bool accepts(void* engine, const double* z, double accept_residual) {
    return static_cast<Method*>(engine)->accepts(z, accept_residual);
  }
  static double residual(void* engine, const double* z) { return static_cast<Method*>(engine)->residual(z); }
};

template <class Scalar>
constexpr Engine engine_over() {
  using I = Interface<Scalar>;
  return {I::create, I::destroy, I::reserve, I::load, I::update, I::solve, I::accepts, I::residual};
}

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
