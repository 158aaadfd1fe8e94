#pragma once

// Shared by the Siconos adapters: one solver of linear complementarity problems by its number in Siconos's list, with a
// tolerance and a limit on iterations.

#include <cstdint>

#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
struct NumericsMatrix;
struct SolverOptions;
#endif

namespace lcpbench {

template <class Settings>
class SiconosSolver;

#ifndef LCPBENCH_DESCRIBE_ONLY

struct FreeOptions {
  void operator()(SolverOptions* options) const;
};

/// Of Siconos's view of a matrix that stays ours: columns one after the other, as Eigen has them.
struct FreeView {
  void operator()(NumericsMatrix* view) const;
};

/// The parameters that an adapter passes to Siconos.
struct SiconosRequest {
  int solver = 0;  ///< SICONOS_LCP_...
  double tolerance = 0;
  std::int64_t max_iterations = 0;
};

/// Runs linearComplementarity_driver. Sets claim, z, iterations and detail.
/// @pre answer.z has n entries: where the methods that take a start begin.
void run_siconos(const Lcp& lcp, const SiconosRequest& request, Answer& answer);

/// Settings: a struct with `tolerance` and `max_iterations`, and static members `solver` and `capabilities`.
template <class Settings>
class SiconosSolver final : public Solver {
 public:
  explicit SiconosSolver(const Settings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return Settings::capabilities; }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }
  void on_solve(const SolveRequest& request, Answer& answer) override {
    if (request.start != nullptr && Settings::capabilities.warm_start) answer.z = *request.start;
    run_siconos(lcp_, {Settings::solver, settings_.tolerance, settings_.max_iterations}, answer);
  }

 private:
  Settings settings_;
  Lcp lcp_;
};

#endif

/// Completes a definition with the capabilities that stand in its settings.
template <class Settings>
SolverDefinition define_siconos(SolverDefinition definition) {
  definition.capabilities = Settings::capabilities;
  return define_adapter<SiconosSolver<Settings>, Settings>(std::move(definition));
}

}  // namespace lcpbench
