// DART's Lemke method, dart::lcpsolver::Lemke, for LCP(q, M).
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <iterator>

#include <dart/lcpsolver/Lemke.hpp>
#endif

namespace lcpbench {
namespace {

/// DART's Lemke has no settings: its tolerances and its limit of 1000 pivots are constants in its code.
struct DartLemkeSettings {
  static constexpr Capabilities capabilities{.guarantees = "copositive-plus M without degeneracy, up to 1000 pivots"};

  void visit(auto&&) {}
};

class DartLemke;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// By the return value, 0 to 4, whose meanings DART's header does not state.
constexpr std::pair<Claim, const char*> kOutcomes[] = {
    {Claim::kSolved, ""},
    {Claim::kIterationLimit, "Lemke returned 1: 1000 pivots"},
    {Claim::kUnsolvable, "Lemke returned 2: a ray"},
    {Claim::kNumericalFailure, "Lemke returned 3: its own test of the answer (1e-4, absolute) failed"},
    {Claim::kNumericalFailure, "Lemke returned 4: no ratio to choose from"}};

class DartLemke final : public MatrixAdapter<DartLemkeSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  void call(const SolveRequest&, Answer& answer) override {
    const int code = dart::lcpsolver::Lemke(lcp_.M, lcp_.q, &answer.z);
    if (code >= 0 && code < static_cast<int>(std::size(kOutcomes))) {
      answer.claim = kOutcomes[code].first;
      answer.detail = kOutcomes[code].second;
    } else {
      answer.detail = "Lemke returned " + std::to_string(code);
    }
  }
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_dart_lemke() {
  return define_adapter<DartLemke, DartLemkeSettings>(
      {.name = "dart_lemke",
       .summary = "DART's Lemke method (dart::lcpsolver::Lemke), one QR factorization a pivot",
       .source = "DART, dart/lcpsolver/Lemke.cpp"});
}

}  // namespace lcpbench
