// DART's DantzigBoxedLcpSolver, the first solver of its constraint solver.
//
// Its solve() is one call of dSolveLCP in DART's copy of ODE's code. Without friction it is therefore the code of
// ode_dantzig; this adapter adds DART's friction rows, which ode_dantzig does not take.
#include "core/registry.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>

#include "adapters/dart/boxed_contacts.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.needs = Needs::kFactored,
                                     .guarantees = "symmetric positive definite M (no friction)"};

struct DartDantzigSettings {
  bool early_termination = true;

  void visit(auto&& field) {
    field("early_termination", early_termination,
          "stop and report a failure at a pivot that is not positive; without it DART never reports one");
  }
};

#ifndef LCPBENCH_DESCRIBE_ONLY

class DartDantzig final : public Solver {
 public:
  explicit DartDantzig(const DartDantzigSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem& problem) override { refusal_ = boxed_.load(*problem.contact()); }

  void on_solve(const SolveRequest&, Answer& answer) override {
    if (!refusal_.empty()) {
      answer.claim = Claim::kUnsupported;
      answer.detail = refusal_;
      return;
    }
    if (answer.z.size() == 0) {
      answer.claim = Claim::kSolved;
      return;
    }
    const bool solved = boxed_.solve(solver_, settings_.early_termination, answer.z);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) {
      answer.detail = "solve returned false";
    } else if (boxed_.frictional()) {
      answer.detail = "another problem: friction limited by the normal impulses of a solve without friction";
    }
  }

 private:
  DartDantzigSettings settings_;
  std::string refusal_;
  BoxedContacts boxed_;
  dart::constraint::DantzigBoxedLcpSolver solver_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_dart_dantzig() {
  SolverDefinition definition{
      .name = "dart_dantzig",
      .summary = "DART's DantzigBoxedLcpSolver: the code of ode_dantzig, with DART's friction rows",
      .source = "DART, dart/constraint/DantzigBoxedLcpSolver, which calls ODE's dSolveLCP; after Baraff, SIGGRAPH 1994",
      .capabilities = kCapabilities};
#ifdef LCPBENCH_DESCRIBE_ONLY
  return with_settings<DartDantzigSettings>(std::move(definition));
#else
  return define_solver<DartDantzig, DartDantzigSettings>(std::move(definition));
#endif
}

}  // namespace lcpbench
