#pragma once

#include <string>
#include <utility>

#include "core/registry.h"

namespace lcpbench {

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
  void on_load(const Problem& problem) final { refusal_ = take(problem); }
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
    lcp_ = make_lcp(problem);
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
