#include <cmath>
#include <string>
#include <utility>

#include "core/error.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

enum class Tested { kTried, kOriginal };

struct RegularizedSettings {
  std::string solver = "lemke";
  double first = 1e-20;
  double factor = 1e4;
  double last = 10.0;
  double tolerance = 1e-6;
  Tested test = Tested::kOriginal;

  void visit(auto&& field) {
    field("solver", solver, "the native solver tried on each problem, with its settings in braces");
    field("first", first, RealRange{.min = 1e-300, .max = 1e300}, "first eps of the ladder");
    field("factor", factor, RealRange{.min = 1.5, .max = 1e300}, "each eps is the one before times this");
    field("last", last, RealRange{.min = 0, .max = 1e300}, "no eps is above this; 0: only M itself is tried");
    field("tolerance", tolerance, RealRange{.min = 0, .max = 1}, "relative tolerance of the test on z, w and z'w");
    field("test", test, Choices<Tested>{{{"tried", Tested::kTried}, {"original", Tested::kOriginal}}},
          "w of the test is that of M + eps I, as published (passes answers far from the truth), or of M");
  }
};

/// The native solver that `text` names, described. @throws InputError for a solver that does not run in this process.
const SolverDefinition& inner_definition(const Spec& spec) {
  const SolverDefinition& definition = find_solver(spec.name).definition;
  if (definition.make == nullptr) {
    throw InputError("regularized: solver = '" + spec.name + "': only native solvers can be regularized");
  }
  return definition;
}

/// The settings with the inner solver's spec checked and in canonical form.
Options with_canonical_inner_solver(Options options) {
  for (auto& [key, value] : options) {
    if (key != "solver") continue;
    const Spec spec = parse_spec(value);
    value = Spec{spec.name, inner_definition(spec).changed_settings(spec.options)}.text();
  }
  return options;
}

void add_counter(std::int64_t& sum, std::int64_t count) { sum = sum < 0 || count < 0 ? -1 : sum + count; }

void add_counters(Counters& sum, const Counters& counters) {
  add_counter(sum.iterations, counters.iterations);
  add_counter(sum.pivots, counters.pivots);
  add_counter(sum.factorizations, counters.factorizations);
}

/// Gives LCP(q, M) to another solver and, while its answer fails a test, LCP(q, M + eps I) for growing eps.
///
/// An answer passes when its solver claims it solved and, with tau the tolerance, c_i z_i >= -tau max|q|,
/// w_i >= -tau s_i and |z'w| <= tau |z|'s. c_i is the largest |entry| of M's column i; s_i = max|q|, so that large
/// inner forces excuse nothing, but |q_i| + sum_j |M_ij| max(|z_j|, max|q| / c_j) on rows with M_ii = 0 (those of a
/// friction cone, whose w has other units than q; z_j below tau max|q| / c_j is rounding noise, as in the test on z).
/// With test=tried, as published, w belongs to the problem with the shift, so that a passed
/// test says nothing about how far the shift moved the solution, and problems without any solution pass; test=original
/// takes w of the problem as given. Contact problems are tried as bare (q, M). When nothing passes, the first answer is
/// returned, never as solved. Every try counts into the time of the solve. [Drumwright, Shell 2012, experiment 6; the
/// ladder is that of the Moby simulator]
class Regularized final : public Solver {
 public:
  explicit Regularized(const RegularizedSettings& settings);
  const Capabilities& capabilities() const override { return capabilities_; }

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  enum class Outcome { kPassed, kFailed, kOutOfTime };
  Outcome attempt(Solver& solver, double eps, const SolveRequest& request, double deadline_s);
  bool passes(double eps) const;
  Problem shifted(double eps) const;
  void report_failure(Outcome outcome, Answer& answer) const;

  RegularizedSettings settings_;
  std::unique_ptr<Solver> plain_;    // holds M
  std::unique_ptr<Solver> shifted_;  // holds M + eps I, loaded anew for each eps
  Capabilities capabilities_;
  Lcp lcp_;
  Vector column_scale_;  // n: largest |entry| of each column of M
  Vector resolved_;      // n: the z_i that moves some w by max|q|, 0 where none does
  Answer attempt_;       // the last one
  Counters total_;
};

Regularized::Regularized(const RegularizedSettings& settings) : settings_(settings) {
  const Spec spec = parse_spec(settings_.solver);
  inner_definition(spec);
  plain_ = make_solver(spec);
  shifted_ = make_solver(spec);
  const Capabilities& inner = plain_->capabilities();
  capabilities_ = {.needs = inner.needs,
                   .frictionless_only = inner.frictionless_only,
                   .max_size = inner.max_size,
                   .guarantees = "none",
                   .warm_start = inner.warm_start,
                   .obeys_time_limit = inner.obeys_time_limit,
                   .allocation_free = false};
}

void Regularized::on_load(const Problem& problem) {
  lcp_ = make_lcp(problem);
  if (lcp_.size() > 0) {
    column_scale_ = lcp_.M.cwiseAbs().colwise().maxCoeff();
    const double largest_q = lcp_.q.cwiseAbs().maxCoeff();
    resolved_ = (column_scale_.array() > 0).select(largest_q / column_scale_.array(), 0.0);
  }
  plain_->load(Problem(problem.name(), lcp_));
}

Problem Regularized::shifted(double eps) const {
  Lcp lcp = lcp_;
  lcp.M.diagonal().array() += eps;
  return {problem().name(), std::move(lcp)};
}

bool Regularized::passes(double eps) const {
  const Vector& z = attempt_.z;
  if (attempt_.claim != Claim::kSolved || z.size() != lcp_.size() || !z.allFinite()) return false;
  if (z.size() == 0) return true;
  const double shift = settings_.test == Tested::kTried ? eps : 0.0;
  const Vector w = lcp_.M * z + lcp_.q + shift * z;
  const double tolerance = settings_.tolerance;
  const double largest_q = lcp_.q.cwiseAbs().maxCoeff();
  const Vector own_sum = lcp_.M.cwiseAbs() * z.cwiseAbs().cwiseMax(resolved_) + lcp_.q.cwiseAbs();
  const Vector scale = (lcp_.M.diagonal().array() != 0).select(Vector::Constant(z.size(), largest_q), own_sum);
  return column_scale_.cwiseProduct(z).minCoeff() >= -tolerance * largest_q &&
         (w + tolerance * scale).minCoeff() >= 0 && std::abs(z.dot(w)) <= tolerance * z.cwiseAbs().dot(scale);
}

Regularized::Outcome Regularized::attempt(Solver& solver, double eps, const SolveRequest& request, double deadline_s) {
  SolveRequest inner_request = request;
  inner_request.time_limit_s = deadline_s - wall_clock_s();
  if (!(inner_request.time_limit_s > 0)) return Outcome::kOutOfTime;
  solver.solve(inner_request, attempt_);
  add_counters(total_, attempt_.counters);
  if (attempt_.claim == Claim::kTimeLimit) return Outcome::kOutOfTime;
  return passes(eps) ? Outcome::kPassed : Outcome::kFailed;
}

/// Turns the answer of the first try into one that claims no success.
void Regularized::report_failure(Outcome outcome, Answer& answer) const {
  const std::string first = answer.detail.empty() ? to_string(answer.claim) : answer.detail;
  if (outcome == Outcome::kOutOfTime) {
    answer.claim = Claim::kTimeLimit;
  } else if (answer.claim == Claim::kSolved) {
    answer.claim = Claim::kNumericalFailure;
  }
  // A proof of the inner solver speaks of (q, M), which for contacts is rounded.
  if (problem().contact() != nullptr) answer.farkas.resize(0);
  answer.detail = "no try passed the test; the first: " + first;
}

void Regularized::on_solve(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  total_ = {.iterations = 0, .pivots = 0, .factorizations = 0};
  attempt_ = Answer{};
  attempt_.z.setZero(lcp_.size());

  Outcome outcome = attempt(*plain_, 0.0, request, deadline_s);
  answer = attempt_;
  int tries = 1;
  double eps = 0;
  if (answer.claim != Claim::kUnsupported) {
    for (double next = settings_.first; outcome == Outcome::kFailed && next <= settings_.last;
         next *= settings_.factor) {
      eps = next;
      shifted_->load(shifted(eps));
      outcome = attempt(*shifted_, eps, request, deadline_s);
      ++tries;
    }
  }

  if (outcome == Outcome::kPassed) {
    std::swap(answer, attempt_);
    answer.detail = eps > 0 ? "passed with eps = " + format_real(eps) + ", try " + std::to_string(tries)
                            : "passed without regularization";
  } else if (answer.claim != Claim::kUnsupported) {
    report_failure(outcome, answer);
  }
  answer.counters = total_;
}

}  // namespace

SolverDefinition lcpbench_solver_regularized() {
  SolverDefinition definition = define_solver<Regularized, RegularizedSettings>(
      {.name = "regularized",
       .summary = "another solver on M, then on M + eps I for growing eps until its own test passes",
       .source = "Drumwright, Shell 2012, experiment 6; Moby (lcp_lemke_regularized)",
       .capabilities = {.guarantees = "none", .obeys_time_limit = true}});
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
