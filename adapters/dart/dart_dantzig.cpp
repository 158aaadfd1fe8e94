// DART's DantzigBoxedLcpSolver, the first solver of its constraint solver.
//
// Its solve() is one call of dSolveLCP in DART's copy of ODE's code. Without friction it is therefore the code of
// ode_dantzig; this adapter adds DART's friction rows, which ode_dantzig does not take.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>

#include "adapters/dart/boxed_contacts.h"
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kDartDantzigCapabilities{.needs = Needs::kFactored,
                                     .guarantees = "symmetric positive definite M (no friction)"};

struct DartDantzigSettings {
  bool early_termination = true;

  void visit(auto&& field) {
    field("early_termination", early_termination,
          "stop and report a failure at a pivot that is not positive; without it DART never reports one");
  }
};

class DartDantzig;

#ifndef LCPBENCH_DESCRIBE_ONLY

class DartDantzig final : public BoxedSolver {
 public:
  explicit DartDantzig(const DartDantzigSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kDartDantzigCapabilities; }

 protected:
  void solve(BoxedContacts& contacts, Answer& answer) override {
    const bool solved = contacts.solve(solver_, settings_.early_termination, answer.z);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) {
      answer.detail = "solve returned false";
    } else if (contacts.frictional()) {
      answer.detail = "another problem: friction limited by the normal impulses of a solve without friction";
    }
  }

 private:
  DartDantzigSettings settings_;
  dart::constraint::DantzigBoxedLcpSolver solver_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_dart_dantzig() {
  return define_adapter<DartDantzig, DartDantzigSettings>(
      {.name = "dart_dantzig",
       .summary = "DART's DantzigBoxedLcpSolver: the code of ode_dantzig, with DART's friction rows",
       .source =
           "DART, dart/constraint/DantzigBoxedLcpSolver, which calls ODE's dSolveLCP; after Baraff, SIGGRAPH 1994",
       .capabilities = kDartDantzigCapabilities});
}

}  // namespace lcpbench
