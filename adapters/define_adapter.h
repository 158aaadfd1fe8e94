#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/registry.h"

namespace lcpbench {

/// For (q, M) that a library is to be given: products of finite data may overflow, and libraries answer to infinity and
/// NaN by anything. @throws InputError where they did; an Adapter refuses the problem then
inline void require_finite(const Matrix& M, const Vector& q) {
  // 0 times each is NaN if it is not finite. allFinite() looks at one entry after the other.
  if ((M.array() * 0).sum() == 0 && (q.array() * 0).sum() == 0) return;
  throw InputError("M or q overflows when it is formed from the data");
}

/// make_lcp(), finite. @throws InputError where products of the data overflow
inline Lcp finite_lcp(const Problem& problem) {
  Lcp lcp = make_lcp(problem);
  require_finite(lcp.M, lcp.q);
  return lcp;
}

/// Engines divide by these.
inline bool has_finite_inverses(const RigidScene& scene) {
  return std::all_of(scene.bodies.begin(), scene.bodies.end(), [](const RigidBody& body) {
    return std::isfinite(1 / body.mass) && body.inertia.inverse().allFinite();
  });
}

/// A solver that calls a library: what all adapters share. A problem that the library does not take is answered as
/// unsupported, an empty one as solved. Settings: a settings struct with a static member `capabilities`.
template <class Settings>
class Adapter : public Solver {
 public:
  explicit Adapter(const Settings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return Settings::capabilities; }

 protected:
  /// As on_load(). @returns why the library does not take the problem, or ""
  virtual std::string take(const Problem& problem) = 0;
  /// As on_solve(). @pre take() returned "", and z is not empty
  virtual void call(const SolveRequest& request, Answer& answer) = 0;

  Settings settings_;

 private:
  void on_load(const Problem& problem) final {
    try {
      const bool divides = Settings::capabilities.needs == Needs::kScene;
      refusal_ = divides && !has_finite_inverses(*problem.scene()) ? "the inverse of a mass or an inertia overflows"
                                                                   : take(problem);
    } catch (const InputError& error) {
      refusal_ = error.what();
    }
  }
  void on_solve(const SolveRequest& request, Answer& answer) final {
    if (!refusal_.empty()) {
      answer.claim = Claim::kUnsupported;
      answer.detail = refusal_;
    } else if (answer.z.size() == 0) {
      answer.claim = Claim::kSolved;
    } else {
      call(request, answer);
    }
  }

  std::string refusal_;
};

/// An adapter of a library that takes (q, M).
template <class Settings>
class MatrixAdapter : public Adapter<Settings> {
 public:
  using Adapter<Settings>::Adapter;

 protected:
  std::string take(const Problem& problem) override {
    lcp_ = finite_lcp(problem);
    return {};
  }

  Lcp lcp_;
};

/// Completes a definition for either of the two programs that an adapter's file is compiled for: the worker, which has
/// the library, and the main program, which only describes the solver. There SolverType is declared and never defined.
template <class SolverType, class Settings>
SolverDefinition define_adapter(SolverDefinition definition) {
  if constexpr (requires { Settings::capabilities; }) definition.capabilities = Settings::capabilities;
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<Settings>(std::move(definition));
#else
  return define_solver<SolverType, Settings>(std::move(definition));
#endif
}

}  // namespace lcpbench
