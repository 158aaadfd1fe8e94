// DART's Lemke method, dart::lcpsolver::Lemke, on the matrix.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <dart/lcpsolver/Lemke.hpp>
#endif

namespace lcpbench {
namespace {

constexpr Capabilities kDartLemkeCapabilities{.guarantees = "copositive M, where no two ratios of a pivot are alike"};

/// The library has none: its tolerances and its limit of 1000 pivots are constants in its code.
struct DartLemkeSettings {
  void visit(auto&&) {}
};

class DartLemke;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// The function's return values, which its header does not name.
enum DartCode { kDartSolved = 0, kDartIterations = 1, kDartRay = 2, kDartNotValidated = 3, kDartNoRatio = 4 };

class DartLemke final : public Solver {
 public:
  explicit DartLemke(const DartLemkeSettings&) {}
  const Capabilities& capabilities() const override { return kDartLemkeCapabilities; }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }

  void on_solve(const SolveRequest&, Answer& answer) override {
    if (lcp_.size() == 0) {
      answer.claim = Claim::kSolved;
      return;
    }
    const int code = dart::lcpsolver::Lemke(lcp_.M, lcp_.q, &answer.z);
    switch (code) {
      case kDartSolved: answer.claim = Claim::kSolved; return;
      case kDartIterations:
        answer.claim = Claim::kIterationLimit;
        answer.detail = "Lemke returned 1: 1000 pivots";
        return;
      case kDartRay:
        answer.claim = Claim::kUnsolvable;
        answer.detail = "Lemke returned 2: a ray";
        return;
      case kDartNotValidated:
        answer.detail = "Lemke returned 3: its own test of the answer (1e-4, absolute) failed";
        return;
      case kDartNoRatio: answer.detail = "Lemke returned 4: no ratio to choose from"; return;
      default: answer.detail = "Lemke returned " + std::to_string(code);
    }
  }

 private:
  Lcp lcp_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_dart_lemke() {
  return define_adapter<DartLemke, DartLemkeSettings>(
      {.name = "dart_lemke",
       .summary = "DART's Lemke method (dart::lcpsolver::Lemke), one QR factorization a pivot",
       .source = "DART, dart/lcpsolver/Lemke.cpp",
       .capabilities = kDartLemkeCapabilities});
}

}  // namespace lcpbench
