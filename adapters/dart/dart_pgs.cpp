// DART's PgsBoxedLcpSolver: projected Gauss-Seidel, the second solver of its constraint solver.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <dart/constraint/PgsBoxedLcpSolver.hpp>

#include "adapters/dart/boxed_contacts.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kDartPgsCapabilities{
    .needs = Needs::kFactored,
    .guarantees = "converges for symmetric positive definite M (no friction); with friction none",
    .warm_start = true};

struct DartPgsSettings {
  std::int64_t max_iterations = 30;
  double first_tolerance = 1e-6;
  double relative_tolerance = 1e-3;
  double smallest_diagonal = 1e-9;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps at most (mMaxIteration); 30 is DART's default");
    field("first_tolerance", first_tolerance, RealRange{.min = 0.0},
          "stop after the first sweep if no unknown changed by more (mDeltaXThreshold); 1e-6 is DART's default");
    field(
        "relative_tolerance", relative_tolerance, RealRange{.min = 0.0},
        "stop when no unknown changed by more, relative to itself (mRelativeDeltaXTolerance); 1e-3 is DART's default");
    field("smallest_diagonal", smallest_diagonal, RealRange{.min = 0.0},
          "rows of a smaller diagonal are left out (mEpsilonForDivision); 1e-9 is DART's default");
  }
};

class DartPgs;

#ifndef LCPBENCH_DESCRIBE_ONLY

class DartPgs final : public BoxedSolver {
 public:
  explicit DartPgs(const DartPgsSettings& settings) {
    solver_.setOption({static_cast<int>(settings.max_iterations), settings.first_tolerance, settings.relative_tolerance,
                       settings.smallest_diagonal});
  }
  const Capabilities& capabilities() const override { return kDartPgsCapabilities; }

 protected:
  void solve(BoxedContacts& contacts, Answer& answer) override {
    constexpr bool kIgnored = false;  // the method has no early termination
    const bool solved = contacts.solve(solver_, kIgnored, answer.z);
    answer.claim = solved ? Claim::kSolved : Claim::kIterationLimit;
  }

 private:
  dart::constraint::PgsBoxedLcpSolver solver_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_dart_pgs() {
  return define_adapter<DartPgs, DartPgsSettings>(
      {.name = "dart_pgs",
       .summary = "DART's PgsBoxedLcpSolver: projected Gauss-Seidel, with DART's friction rows",
       .source = "DART, dart/constraint/PgsBoxedLcpSolver",
       .capabilities = kDartPgsCapabilities});
}

}  // namespace lcpbench
