#include "native/lemke/lemke.h"

#include <algorithm>
#include <cmath>

#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

void append_pivot(void* pivots, std::ptrdiff_t entering, std::ptrdiff_t leaving) {
  static_cast<std::vector<LemkePivot>*>(pivots)->push_back({entering, leaving});
}

/// Sets to zero what is negative by no more than rounding; larger negatives stay, to be seen.
void clip_rounding(Vector& z) {
  const double noise = 1e-12 * z.cwiseAbs().maxCoeff();
  for (double& value : z) {
    if (value < 0 && value >= -noise) value = 0;
  }
}

void report_ending(lemke::Ending ending, Answer& answer) {
  // Short enough for std::string to hold in place, so that solve() allocates nothing.
  switch (ending) {
    case lemke::Ending::kSolved: answer.claim = Claim::kSolved; return;
    case lemke::Ending::kRay:
      answer.claim = Claim::kUnsolvable;
      answer.detail = "ray";
      return;
    case lemke::Ending::kPivotLimit:
      answer.claim = Claim::kIterationLimit;
      answer.detail = "pivot limit";
      return;
    case lemke::Ending::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
    case lemke::Ending::kBreakdown:
      answer.claim = Claim::kNumericalFailure;
      answer.detail = "singular basis";
      return;
  }
}

/// As `test` says. Where it says nothing, other engines and tolerances than the defaults repeat published
/// programs, which test nothing.
bool tests_answers(const LemkeSettings& settings) {
  if (settings.test != LemkeAnswerTest::kAuto) return settings.test == LemkeAnswerTest::kResidual;
  const LemkeSettings defaults;
  return settings.engine == LemkeEngine::kKernel && settings.pivot_tolerance == defaults.pivot_tolerance &&
         settings.zero_tolerance == defaults.zero_tolerance;
}

std::unique_ptr<AnswerTest> test_of(const LemkeSettings& settings) {
  return tests_answers(settings) ? std::make_unique<AnswerTest>() : nullptr;
}

/// Claim, detail and counters of an engine's outcome. `answer` arrives cleared, with z as the engine left it.
/// Entries of a claimed z that are negative by rounding become 0.
void report(const lemke::Outcome& outcome, Answer& answer) {
  report_ending(outcome.ending, answer);
  if (answer.claim == Claim::kSolved && answer.z.size() > 0) clip_rounding(answer.z);
  answer.counters.iterations = outcome.pivots;
  answer.counters.pivots = outcome.pivots;
  answer.counters.factorizations = outcome.factorizations;
}

Capabilities capabilities_of(const LemkeSettings& settings) {
  Capabilities capabilities;
  capabilities.needs = Needs::kDense;
  capabilities.max_size = 10000;  // room for up to five n x n matrices, 4 GB
  capabilities.guarantees = "copositive-plus M without degeneracy";
  capabilities.obeys_time_limit = true;
  capabilities.allocation_free = settings.engine == LemkeEngine::kKernel;  // else Eigen takes memory
  return capabilities;
}

}  // namespace

std::ptrdiff_t lemke_pivot_limit(const LemkeSettings& settings, Index n) {
  if (settings.max_pivots > 0) return static_cast<std::ptrdiff_t>(settings.max_pivots);
  if (settings.cap == LemkeCap::kLemke) return std::min<Index>(1000, 50 * n);
  if (settings.cap == LemkeCap::k3n) return std::max<Index>(200, 3 * n);
  return std::max<Index>(1000, n * n);
}

Lemke::Lemke(const LemkeSettings& settings, IsaLevel level)
    : settings_(settings),
      capabilities_(capabilities_of(settings)),
      engine_(lemke::make_engine(settings.engine, level)),
      test_(test_of(settings)) {}

void Lemke::on_load(const Problem& problem) {
  lemke::load(problem, settings_.cover == LemkeCover::kAll, *engine_);
  if (test_ != nullptr) test_->load(problem);
}

void Lemke::on_solve(const SolveRequest& request, Answer& answer) {
  lemke::Rules rules;
  rules.pivot_tolerance = settings_.pivot_tolerance;
  rules.zero_tolerance = settings_.zero_tolerance;
  rules.max_pivots = lemke_pivot_limit(settings_, answer.z.size());
  rules.clock_s = wall_clock_s;
  rules.deadline_s = std::isinf(request.time_limit_s) ? request.time_limit_s : wall_clock_s() + request.time_limit_s;
  if (recorded_ != nullptr) {
    rules.on_pivot = append_pivot;
    rules.context = recorded_;
  }

  report(engine_->solve(rules, answer.z.data()), answer);
  if (test_ == nullptr) return;
  if (answer.claim == Claim::kUnsolvable) return test_->settle_ray(answer, rules.deadline_s);
  if (answer.claim == Claim::kSolved && !test_->settle(answer, rules.deadline_s)) {
    answer.velocity.resize(0);
    if (answer.detail != "unconfirmed") answer.z.setZero();
  }
}

SolverDefinition lcpbench_solver_lemke() {
  SolverDefinition definition;
  definition.name = "lemke";
  definition.summary = "Lemke's complementary pivoting by the rules of LEMKE, basis factored afresh at each pivot";
  definition.source =
      "Lemke 1965; LEMKE of Fackler, Miranda 1997, as used by Drumwright, Shell 2012; Cottle, Pang, Stone 1992, 4.4";
  definition.capabilities = capabilities_of({});
  return define_solver<Lemke, LemkeSettings>(std::move(definition));
}

}  // namespace lcpbench
