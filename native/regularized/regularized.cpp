#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/registry.h"
#include "core/settings.h"
#include "core/solver.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"

namespace lcpbench {
namespace {

/// Whose w the test takes; kResidual: as kOriginal, and then the test of all native solvers.
enum class RegularizedTest { kTried, kOriginal, kResidual };

struct RegularizedSettings {
  std::string solver = "lemke{test=none}";
  double first = 1e-20;
  double factor = 1e4;
  double last = 10.0;
  RegularizedTest test = RegularizedTest::kResidual;

  void visit(auto&& field) {
    field("solver", solver, "the native solver tried on each problem, with its settings in braces");
    field("first", first, RealRange{.min = 1e-300, .max = 1e300}, "first eps of the ladder");
    field("factor", factor, RealRange{.min = 1.5, .max = 1e300}, "each eps is the one before times this");
    field("last", last, RealRange{.min = 0, .max = 1e300}, "no eps is above this; 0: only M itself is tried");
    field("test", test,
          Choices<RegularizedTest>{{{"tried", RegularizedTest::kTried},
                                    {"original", RegularizedTest::kOriginal},
                                    {"residual", RegularizedTest::kResidual}}},
          "w of the test is that of M + eps I, as published (passes answers far from the truth), or of M; residual: of "
          "M, and the answer has to solve the problem as given, from its raw data");
  }
};

/// The native solver that `spec` names. @throws InputError for a solver that does not run in this process.
const SolverDefinition& inner_solver(const Spec& spec) {
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
    value = Spec{spec.name, inner_solver(spec).changed_settings(spec.options)}.text();
  }
  return options;
}

/// tau of the test on z, w and z'w, see Regularization.
constexpr double kTolerance = 1e-6;

constexpr std::string_view kFailureReport = "no try passed the test; the first: ";

/// Appends the shortest text that reads back to the same number.
template <class Number>
void append(Number value, std::string& text) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

void add_counter(std::int64_t& sum, std::int64_t count) { sum = sum < 0 || count < 0 ? -1 : sum + count; }

/// Adds counters up; unknown ones stay unknown.
void add_counters(Counters& sum, const Counters& counters) {
  add_counter(sum.iterations, counters.iterations);
  add_counter(sum.pivots, counters.pivots);
  add_counter(sum.factorizations, counters.factorizations);
}

/// How a try on M + eps I ended.
enum class TryOutcome { kPassed, kFailed, kOutOfTime };

/// The problem of one `regularized`, and the test that an answer has to pass.
///
/// With tau = kTolerance, an answer passes when its solver claims it solved and c_i z_i >= -tau max|q|, w_i >= -tau
/// s_i and |z'w| <= tau |z|'s. c_i is the largest |entry| of M's column i; s_i = max|q|, so that large inner forces
/// excuse nothing, but |q_i| + sum_j |M_ij| max(|z_j|, max|q| / c_j) on rows with M_ii = 0 (those of a friction cone,
/// whose w has other units than q; z_j below tau max|q| / c_j is rounding noise, as in the test on z). With test=tried,
/// as published, w belongs to the problem with the shift, so that a passed test says nothing about how far the shift
/// moved the solution, and problems without any solution pass; test=original takes w of the problem as given;
/// test=residual asks for that and for AnswerTest.
class Regularization {
 public:
  explicit Regularization(const RegularizedSettings& settings) : settings_(settings) {}

  /// Forms M. Nothing else allocates, but for the text of an answer that has no room for it.
  void load(const Problem& problem);

  Index size() const { return lcp_.size(); }

  /// LCP(q, M + eps I): one object for all eps, changed in place. What was loaded from it must be loaded again. O(n)
  const Problem& tried(double eps);

  /// The eps after this one, from 0 on; nothing where the ladder ends.
  std::optional<double> next(double eps) const;

  /// An answer that AnswerTest refuses loses its claim. @param deadline_s of AnswerTest
  TryOutcome judge(Answer& answer, double eps, double deadline_s);

  /// Says of an answer that passed which try it is from: the first has eps = 0.
  static void report_pass(double eps, int tries, Answer& answer);

  /// Turns the answer of the first try into that of the whole when none has passed: no claim of success.
  /// With test=residual, one that the problem is unsolvable only where AnswerTest proves it by that deadline.
  void report_failure(TryOutcome last, Answer& answer, double deadline_s);

 private:
  bool passes(const Answer& answer, double eps);
  bool tests_residual() const { return settings_.test == RegularizedTest::kResidual; }

  RegularizedSettings settings_;
  bool contact_ = false;
  Lcp lcp_;
  Problem tried_;
  Vector column_scale_;           // n: largest |entry| of each column of M
  Vector resolved_;               // n: the z_i that moves some w by max|q|, 0 where none does
  Vector w_, magnitude_, scale_;  // n, of the test
  AnswerTest answer_test_;
};

void Regularization::load(const Problem& problem) {
  contact_ = problem.contact() != nullptr;
  lcp_ = make_lcp(problem);
  tried_ = Problem(problem.name(), lcp_);
  if (tests_residual()) answer_test_.load(problem);
  for (Vector* vector : {&w_, &magnitude_, &scale_}) vector->resize(lcp_.size());
  if (lcp_.size() == 0) return;
  column_scale_ = lcp_.M.cwiseAbs().colwise().maxCoeff();
  const double largest_q = lcp_.q.cwiseAbs().maxCoeff();
  resolved_ = (column_scale_.array() > 0).select(largest_q / column_scale_.array(), 0.0);
}

const Problem& Regularization::tried(double eps) {
  // Problems are immutable to those who share them; this one is shared with solvers that load it anew.
  Matrix& M = const_cast<Lcp&>(tried_.lcp()).M;
  M.diagonal() = lcp_.M.diagonal();
  if (eps > 0) M.diagonal().array() += eps;
  return tried_;
}

std::optional<double> Regularization::next(double eps) const {
  const double larger = eps > 0 ? eps * settings_.factor : settings_.first;
  return larger <= settings_.last ? std::optional(larger) : std::nullopt;
}

TryOutcome Regularization::judge(Answer& answer, double eps, double deadline_s) {
  if (answer.claim == Claim::kTimeLimit) return TryOutcome::kOutOfTime;
  if (!passes(answer, eps)) return TryOutcome::kFailed;
  if (!tests_residual() || answer_test_.settle(answer, deadline_s)) return TryOutcome::kPassed;
  return answer.claim == Claim::kTimeLimit ? TryOutcome::kOutOfTime : TryOutcome::kFailed;
}

bool Regularization::passes(const Answer& answer, double eps) {
  const Vector& z = answer.z;
  if (answer.claim != Claim::kSolved || z.size() != lcp_.size() || !z.allFinite()) return false;
  if (z.size() == 0) return true;
  const double shift = settings_.test == RegularizedTest::kTried ? eps : 0.0;
  w_.noalias() = lcp_.M * z;
  w_ += lcp_.q;
  w_ += shift * z;
  const double largest_q = lcp_.q.cwiseAbs().maxCoeff();
  magnitude_ = z.cwiseAbs().cwiseMax(resolved_);
  scale_.noalias() = lcp_.M.cwiseAbs() * magnitude_;
  scale_ += lcp_.q.cwiseAbs();
  for (Index i = 0; i < scale_.size(); ++i) {
    if (lcp_.M(i, i) != 0) scale_(i) = largest_q;
  }
  return column_scale_.cwiseProduct(z).minCoeff() >= -kTolerance * largest_q &&
         (w_ + kTolerance * scale_).minCoeff() >= 0 && std::abs(z.dot(w_)) <= kTolerance * z.cwiseAbs().dot(scale_);
}

void Regularization::report_pass(double eps, int tries, Answer& answer) {
  if (!(eps > 0)) {
    answer.detail = "passed without regularization";
    return;
  }
  answer.detail = "passed with eps = ";
  append(eps, answer.detail);
  answer.detail += ", try ";
  append(tries, answer.detail);
}

void Regularization::report_failure(TryOutcome last, Answer& answer, double deadline_s) {
  if (answer.claim == Claim::kUnsupported) return;
  // What an inner solver says of a ray, or of M as rounded, is its word; here it has to be proven.
  const bool proves = tests_residual() && last != TryOutcome::kOutOfTime && answer.claim == Claim::kUnsolvable;
  if (proves) {
    answer.farkas.resize(0);
    answer_test_.settle_ray(answer, deadline_s);
  }
  if (answer.detail.empty()) answer.detail = to_string(answer.claim);
  answer.detail.insert(0, kFailureReport);
  if (last == TryOutcome::kOutOfTime) {
    answer.claim = Claim::kTimeLimit;
  } else if (answer.claim == Claim::kSolved) {
    answer.claim = Claim::kNumericalFailure;
  }
  // A proof of the inner solver speaks of (q, M), which for contacts is rounded.
  if (!proves && contact_) answer.farkas.resize(0);
}

/// What `regularized` promises with this inner solver of that name.
Capabilities capabilities_of(const std::string& solver, const Capabilities& inner) {
  return {.needs = inner.needs,
          .frictionless_only = inner.frictionless_only,
          .max_size = inner.max_size,
          .max_entries = inner.max_entries,
          .guarantees = "none",
          .warm_start = inner.warm_start,
          .obeys_time_limit = inner.obeys_time_limit,
          // A solve loads the inner solver again for each eps. Most solvers allocate in load(), lemke does not by then.
          .allocation_free = inner.allocation_free && solver == "lemke"};
}

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
  void hold(double eps);
  TryOutcome attempt(double eps, const SolveRequest& request, double deadline_s, Answer& answer);
  void take(const Answer& found, Answer& answer) const;

  Regularization regularization_;
  std::unique_ptr<Solver> solver_;
  double held_eps_ = 0;  // solver_ holds M + held_eps_ I
  Capabilities capabilities_;
  Answer inner_;    // of solver_, to (q, M + eps I)
  Answer attempt_;  // the last one with eps > 0
  Counters total_;
};

Regularized::Regularized(const RegularizedSettings& settings) : regularization_(settings) {
  const Spec spec = parse_spec(settings.solver);
  solver_ = inner_solver(spec).make(spec.options);  // what it cannot prove is not withdrawn before the ladder ends
  capabilities_ = capabilities_of(spec.name, solver_->capabilities());
}

void Regularized::on_load(const Problem& problem) {
  regularization_.load(problem);
  solver_->load(regularization_.tried(0));
  held_eps_ = 0;
  inner_.reserve(regularization_.tried(0));
  attempt_.reserve(problem);
}

void Regularized::hold(double eps) {
  if (eps != held_eps_) solver_->load(regularization_.tried(eps));
  held_eps_ = eps;
}

TryOutcome Regularized::attempt(double eps, const SolveRequest& request, double deadline_s, Answer& answer) {
  hold(eps);
  SolveRequest inner_request = request;
  inner_request.time_limit_s = deadline_s - wall_clock_s();
  if (!(inner_request.time_limit_s > 0)) return TryOutcome::kOutOfTime;
  solver_->solve(inner_request, inner_);
  add_counters(total_, inner_.counters);
  take(inner_, answer);
  return regularization_.judge(answer, eps, deadline_s);
}

/// `answer` = `found`. A proof about M is none about the contacts that it was formed from.
void Regularized::take(const Answer& found, Answer& answer) const {
  answer.claim = found.claim;
  answer.z = found.z;
  answer.farkas.resize(0);
  if (problem().contact() == nullptr) answer.farkas = found.farkas;
  answer.detail = found.detail;
}

void Regularized::on_solve(const SolveRequest& request, Answer& answer) {
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  total_ = {.iterations = 0, .pivots = 0, .factorizations = 0};

  TryOutcome outcome = attempt(0.0, request, deadline_s, answer);
  int tries = 1;
  double eps = 0;
  if (answer.claim != Claim::kUnsupported) {
    for (auto next = regularization_.next(eps); outcome == TryOutcome::kFailed && next;
         next = regularization_.next(eps)) {
      eps = *next;
      outcome = attempt(eps, request, deadline_s, attempt_);
      ++tries;
    }
  }

  if (outcome == TryOutcome::kPassed) {
    if (eps > 0) take(attempt_, answer);
    Regularization::report_pass(eps, tries, answer);
  } else {
    regularization_.report_failure(outcome, answer, deadline_s);
  }
  answer.counters = total_;
}

}  // namespace

SolverDefinition lcpbench_solver_regularized() {
  SolverDefinition definition = define_solver<Regularized, RegularizedSettings>(
      {.name = "regularized",
       .summary = "another solver on M, then on M + eps I for growing eps until its own test passes",
       .source = "Drumwright, Shell 2012, experiment 6; Moby (lcp_lemke_regularized)",
       .capabilities = {.guarantees = "none", .obeys_time_limit = true, .allocation_free = true}});
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
