#include "native/regularized.h"

#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// The settings with the inner solver's spec checked and in canonical form.
Options with_canonical_inner_solver(Options options) {
  for (auto& [key, value] : options) {
    if (key != "solver") continue;
    const Spec spec = parse_spec(value);
    value = Spec{spec.name, regularized_inner(spec).changed_settings(spec.options)}.text();
  }
  return options;
}

void add_counter(std::int64_t& sum, std::int64_t count) { sum = sum < 0 || count < 0 ? -1 : sum + count; }

/// Gives LCP(q, M) to another solver and, while its answer fails the test of Regularization, LCP(q, M + eps I) for
/// growing eps.
///
/// Contact problems are tried as bare (q, M). When nothing passes, the first answer is returned, never as solved. Every
/// try counts into the time of the solve. [Drumwright, Shell 2012, experiment 6; the ladder is that of the Moby
/// simulator]
class Regularized final : public Solver {
 public:
  explicit Regularized(const RegularizedSettings& settings);
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  TryOutcome attempt(Solver& solver, double eps, const SolveRequest& request, double deadline_s);

  Regularization regularization_;
  std::unique_ptr<Solver> plain_;    // holds M
  std::unique_ptr<Solver> shifted_;  // holds M + eps I, loaded anew for each eps
  Capabilities capabilities_;
  Answer attempt_;  // the last one
  Counters total_;
};

Regularized::Regularized(const RegularizedSettings& settings) : regularization_(settings) {
  const Spec spec = parse_spec(settings.solver);
  regularized_inner(spec);
  plain_ = make_solver(spec);
  shifted_ = make_solver(spec);
  capabilities_ = regularized_capabilities(plain_->capabilities());
}

void Regularized::on_load(const Problem& problem) {
  regularization_.load(problem);
  plain_->load(regularization_.plain());
}

TryOutcome Regularized::attempt(Solver& solver, double eps, const SolveRequest& request, double deadline_s) {
  SolveRequest inner_request = request;
  inner_request.time_limit_s = deadline_s - wall_clock_s();
  if (!(inner_request.time_limit_s > 0)) return TryOutcome::kOutOfTime;
  solver.solve(inner_request, attempt_);
  add_counters(total_, attempt_.counters);
  return regularization_.judge(attempt_, eps);
}

void Regularized::on_solve(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  total_ = {.iterations = 0, .pivots = 0, .factorizations = 0};
  attempt_ = Answer{};
  attempt_.z.setZero(regularization_.size());

  TryOutcome outcome = attempt(*plain_, 0.0, request, deadline_s);
  answer = attempt_;
  int tries = 1;
  double eps = 0;
  if (answer.claim != Claim::kUnsupported) {
    for (auto next = regularization_.next(eps); outcome == TryOutcome::kFailed && next;
         next = regularization_.next(eps)) {
      eps = *next;
      shifted_->load(regularization_.shifted(eps));
      outcome = attempt(*shifted_, eps, request, deadline_s);
      ++tries;
    }
  }

  if (outcome == TryOutcome::kPassed) {
    std::swap(answer, attempt_);
    Regularization::report_pass(eps, tries, answer);
  } else {
    regularization_.report_failure(outcome, answer);
  }
  answer.counters = total_;
}

}  // namespace

const SolverDefinition& regularized_inner(const Spec& spec) {
  const SolverDefinition& definition = find_solver(spec.name).definition;
  if (definition.make == nullptr) {
    throw InputError("regularized: solver = '" + spec.name + "': only native solvers can be regularized");
  }
  return definition;
}

Capabilities regularized_capabilities(const Capabilities& inner) {
  return {.needs = inner.needs,
          .frictionless_only = inner.frictionless_only,
          .max_size = inner.max_size,
          .guarantees = "none",
          .warm_start = inner.warm_start,
          .obeys_time_limit = inner.obeys_time_limit,
          .allocation_free = false};
}

void add_counters(Counters& sum, const Counters& counters) {
  add_counter(sum.iterations, counters.iterations);
  add_counter(sum.pivots, counters.pivots);
  add_counter(sum.factorizations, counters.factorizations);
}

void Regularization::load(const Problem& problem) {
  name_ = problem.name();
  contact_ = problem.contact() != nullptr;
  lcp_ = make_lcp(problem);
  if (tests_residual()) answer_test_.load(problem);
  if (lcp_.size() == 0) return;
  column_scale_ = lcp_.M.cwiseAbs().colwise().maxCoeff();
  const double largest_q = lcp_.q.cwiseAbs().maxCoeff();
  resolved_ = (column_scale_.array() > 0).select(largest_q / column_scale_.array(), 0.0);
}

Problem Regularization::plain() const { return {name_, lcp_}; }

Problem Regularization::shifted(double eps) const {
  Lcp lcp = lcp_;
  lcp.M.diagonal().array() += eps;
  return {name_, std::move(lcp)};
}

std::optional<double> Regularization::next(double eps) const {
  const double larger = eps > 0 ? eps * settings_.factor : settings_.first;
  return larger <= settings_.last ? std::optional(larger) : std::nullopt;
}

TryOutcome Regularization::judge(Answer& answer, double eps) {
  if (answer.claim == Claim::kTimeLimit) return TryOutcome::kOutOfTime;
  if (!passes(answer, eps)) return TryOutcome::kFailed;
  return !tests_residual() || answer_test_.settle(answer) ? TryOutcome::kPassed : TryOutcome::kFailed;
}

bool Regularization::passes(const Answer& answer, double eps) const {
  const Vector& z = answer.z;
  if (answer.claim != Claim::kSolved || z.size() != lcp_.size() || !z.allFinite()) return false;
  if (z.size() == 0) return true;
  const double shift = settings_.test == RegularizedTest::kTried ? eps : 0.0;
  const Vector w = lcp_.M * z + lcp_.q + shift * z;
  const double tolerance = settings_.tolerance;
  const double largest_q = lcp_.q.cwiseAbs().maxCoeff();
  const Vector own_sum = lcp_.M.cwiseAbs() * z.cwiseAbs().cwiseMax(resolved_) + lcp_.q.cwiseAbs();
  const Vector scale = (lcp_.M.diagonal().array() != 0).select(Vector::Constant(z.size(), largest_q), own_sum);
  return column_scale_.cwiseProduct(z).minCoeff() >= -tolerance * largest_q &&
         (w + tolerance * scale).minCoeff() >= 0 && std::abs(z.dot(w)) <= tolerance * z.cwiseAbs().dot(scale);
}

void Regularization::report_pass(double eps, int tries, Answer& answer) {
  answer.detail = eps > 0 ? "passed with eps = " + format_real(eps) + ", try " + std::to_string(tries)
                          : "passed without regularization";
}

void Regularization::report_failure(TryOutcome last, Answer& answer) const {
  if (answer.claim == Claim::kUnsupported) return;
  const std::string first = answer.detail.empty() ? to_string(answer.claim) : answer.detail;
  if (last == TryOutcome::kOutOfTime) {
    answer.claim = Claim::kTimeLimit;
  } else if (answer.claim == Claim::kSolved) {
    answer.claim = Claim::kNumericalFailure;
  }
  // A proof of the inner solver speaks of (q, M), which for contacts is rounded.
  if (contact_) answer.farkas.resize(0);
  answer.detail = "no try passed the test; the first: " + first;
}

SolverDefinition lcpbench_solver_regularized() {
  SolverDefinition definition = define_solver<Regularized, RegularizedSettings>(
      {.name = "regularized",
       .summary = "another solver on M, then on M + eps I for growing eps until its own test passes",
       .source = "Drumwright, Shell 2012, experiment 6; Moby (lcp_lemke_regularized)",
       .capabilities = {.guarantees = "none", .obeys_time_limit = true}});
  definition.make_swept = make_swept_regularized;
  definition.all_settings = [](const Options& options) {
    const auto settings = parse_settings<RegularizedSettings>("regularized", options);
    return with_canonical_inner_solver(all_settings(settings));
  };
  definition.changed_settings = [](const Options& options) {
    const auto written = all_settings(parse_settings<RegularizedSettings>("regularized", options));
    return changed_settings(parse_settings<RegularizedSettings>("regularized", with_canonical_inner_solver(written)));
  };
  return definition;
}

}  // namespace lcpbench
