// What every native solver must keep, whoever wrote it. A solver is tested as soon as CMake knows it: nothing is to be
// added here. What a solver does not claim to do is skipped, with the reason.

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <gtest/gtest.h>

#include "core/error.h"
#include "generators/sets.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/contacts.h"
#include "tests/support/solving.h"
#include "tests/support/textbook_lcps.h"

namespace lcpbench::conformance_test {
namespace {

using testing::frictionless;
using testing::Uniform;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A claim is believed down to the residual at which an answer still counts as solved; PD problems with condition number
// under 10 leave no excuse for more.
constexpr double kClaimedResidual = 1e-4;
constexpr double kPlantedError = 1e-5;

class ConformanceTest : public ::testing::TestWithParam<std::string> {
 protected:
  const SolverDefinition& definition() const { return find_solver(GetParam()).definition; }
  std::unique_ptr<Solver> make(const Options& options = {}) const { return definition().make(options); }
  /// Of the solver with its default settings.
  Capabilities capabilities() const { return make()->capabilities(); }
  Index size_up_to(Index n) const { return std::min(n, capabilities().max_size); }
  bool takes_asymmetric() const { return !capabilities().frictionless_only && capabilities().needs == Needs::kDense; }
  bool takes(const Problem& problem) const { return why_not(capabilities(), problem).empty(); }

  static Answer solve(Solver& solver, const Problem& problem, const SolveRequest& request = {}) {
    solver.load(problem);
    Answer answer;
    solver.solve(request, answer);
    return answer;
  }
  Answer solve(const Problem& problem, const SolveRequest& request = {}) const {
    return solve(*make(), problem, request);
  }
};

/// Symmetric, or with a skew part of the same size; eigenvalues of the symmetric part in [1, 5].
Matrix well_conditioned_matrix(Index n, bool symmetric, Uniform& uniform) {
  const Matrix A = uniform.matrix(n, n);
  Matrix M = A * A.transpose() / static_cast<double>(n) + Matrix::Identity(n, n);
  M = (0.5 * (M + M.transpose())).eval();
  if (!symmetric) M += (A - A.transpose()) / std::sqrt(static_cast<double>(n));
  return M;
}

/// The contact problem of unit inertia whose frictionless LCP is (q, M): N = the Cholesky factor of M, N'v = q.
ContactProblem contact_problem_of(const Lcp& lcp) {
  const Matrix L = lcp.M.llt().matrixL();
  return frictionless(L.triangularView<Eigen::Lower>().solve(lcp.q), L.transpose(),
                      DenseInertia{Matrix::Identity(lcp.size(), lcp.size())});
}

/// A problem with a known unique solution z, in the form that the solver takes; none when it takes scenes only.
std::optional<Problem> planted(const Capabilities& capabilities, Index n, std::uint64_t seed, Vector& z,
                               bool symmetric = true) {
  if (capabilities.needs == Needs::kScene) return std::nullopt;
  Uniform uniform(seed);
  const Matrix M = well_conditioned_matrix(n, symmetric, uniform);
  const Lcp lcp = testing::plant(M, uniform.vector(n), z);
  if (capabilities.needs == Needs::kDense) return Problem("planted", lcp);
  return Problem("planted", contact_problem_of(lcp));
}

#define PLANTED_OR_SKIP(problem, n, seed, z)                                     \
  const std::optional<Problem> problem##_ = planted(capabilities(), n, seed, z); \
  if (!problem##_) GTEST_SKIP() << "takes rigid-body scenes only";               \
  const Problem& problem = *problem##_

bool same_bits(const Vector& a, const Vector& b) {
  return a.size() == b.size() && std::equal(a.data(), a.data() + a.size(), b.data());
}

// --- settings ---

TEST_P(ConformanceTest, SettingsReadBackAsWritten) {
  const Options defaults = definition().all_settings({});
  EXPECT_EQ(definition().all_settings(defaults), defaults);
  EXPECT_TRUE(definition().changed_settings(defaults).empty());
  EXPECT_EQ(defaults.size(), definition().settings().size());
  EXPECT_NO_THROW(make(defaults));
}

std::vector<std::string> other_values(const SettingInfo& setting) {
  if (setting.type == "boolean") return {setting.default_value == "true" ? "false" : "true"};
  if (setting.type == "text") return {};
  if (setting.type == "choice") {
    std::vector<std::string> values;
    std::string rest = setting.range + "|";
    for (std::size_t bar = rest.find('|'); bar != std::string::npos; rest.erase(0, bar + 1), bar = rest.find('|')) {
      if (rest.substr(0, bar) != setting.default_value) values.push_back(rest.substr(0, bar));
    }
    return values;
  }
  const double value = std::stod(setting.default_value);
  if (setting.type == "integer") return {format_real(value + 1), format_real(value - 1)};
  return {format_real(value / 2 + 0x1p-10), format_real(value * 2)};
}

TEST_P(ConformanceTest, EverySettingCanBeChangedAndIsTheOnlyOneThatChanges) {
  for (const SettingInfo& setting : definition().settings()) {
    if (setting.type == "text") continue;  // free text has a meaning of its own: the solver's own test covers it
    int accepted = 0;
    for (const std::string& value : other_values(setting)) {
      if (value == setting.default_value) continue;
      const Options changed{{setting.name, value}};
      try {
        EXPECT_EQ(definition().changed_settings(changed), changed);
        EXPECT_EQ(definition().changed_settings(definition().all_settings(changed)), changed);
        EXPECT_NO_THROW(make(changed));
        ++accepted;
      } catch (const InputError&) {
        continue;  // one of the two neighbours may be out of range
      }
    }
    EXPECT_GT(accepted, 0) << setting.name << " takes no value but its default";
  }
}

TEST_P(ConformanceTest, UnknownAndSenselessSettingsAreRefused) {
  EXPECT_THROW(definition().all_settings({{"no_such_setting", "1"}}), InputError);
  EXPECT_THROW(definition().changed_settings({{"no_such_setting", "1"}}), InputError);
  EXPECT_THROW(make({{"no_such_setting", "1"}}), InputError);
  for (const SettingInfo& setting : definition().settings()) {
    for (const char* senseless : {"", "nan", "no such value", "1e400"}) {
      if (setting.type == "text") continue;
      EXPECT_THROW(definition().all_settings({{setting.name, senseless}}), InputError) << setting.name << senseless;
    }
  }
}

TEST_P(ConformanceTest, DescribesItself) {
  EXPECT_FALSE(definition().summary.empty());
  EXPECT_FALSE(definition().source.empty());
  EXPECT_EQ(definition().summary.find('\n'), std::string::npos);
  for (const SettingInfo& setting : definition().settings()) EXPECT_FALSE(setting.help.empty()) << setting.name;
}

// --- answers ---

TEST_P(ConformanceTest, FindsPlantedSolutions) {
  const auto solver = make();
  for (const Index n : {1, 2, 3, 5, 8, 12, 20, 40}) {
    if (n > capabilities().max_size) continue;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      Vector z;
      PLANTED_OR_SKIP(problem, n, seed, z);
      const Answer answer = solve(*solver, problem);
      ASSERT_EQ(answer.claim, Claim::kSolved) << "n = " << n << ", seed " << seed << ": " << answer.detail;
      ASSERT_EQ(answer.z.size(), n);
      EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), kPlantedError) << "n = " << n << ", seed " << seed;
    }
  }
}

TEST_P(ConformanceTest, FindsPlantedSolutionsOfAsymmetricProblems) {
  if (!takes_asymmetric()) GTEST_SKIP() << "takes symmetric M or factored contact problems only";
  for (const Index n : {2, 5, 12, 30}) {
    if (n > capabilities().max_size) continue;
    Vector z;
    const Problem problem = *planted(capabilities(), n, 17, z, false);
    const Answer answer = solve(problem);
    ASSERT_EQ(answer.claim, Claim::kSolved) << "n = " << n << ": " << answer.detail;
    EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), kPlantedError) << "n = " << n;
  }
}

TEST_P(ConformanceTest, SolvesAContactProblemAndItsNextTimeStep) {
  if (capabilities().needs == Needs::kScene) GTEST_SKIP() << "takes rigid-body scenes only";
  const Index n = size_up_to(8);
  Uniform uniform(23);
  const Matrix M = well_conditioned_matrix(n, true, uniform);
  Vector z;
  const ContactProblem first = contact_problem_of(testing::plant(M, uniform.vector(n), z));
  const auto solver = make();
  const Answer answer = solve(*solver, Problem("contacts", first));
  ASSERT_EQ(answer.claim, Claim::kSolved) << answer.detail;
  EXPECT_LE((answer.z - z).lpNorm<Eigen::Infinity>(), kPlantedError);

  const ContactProblem second = contact_problem_of(testing::plant(M, uniform.vector(n), z));
  solver->update(second.v);
  Answer next;
  solver->solve({}, next);
  ASSERT_EQ(next.claim, Claim::kSolved) << next.detail;
  EXPECT_LE((next.z - z).lpNorm<Eigen::Infinity>(), kPlantedError);
}

// With friction where the solver takes it, as one of its settings or by itself.
TEST_P(ConformanceTest, AnUpdateGivesBitForBitWhatALoadGives) {
  const bool cone = GetParam() == "cone_ipm";
  for (const char* set : {"paper/monotone/exp1", "paper/copositive/exp1{nc_max=4}", "scene/uneven-table/ode"}) {
    ContactProblem contact = *open_set(set)->generate(5, 2).contact();
    const auto solver = make(cone ? Options{{"cone", "true"}} : Options{});
    if (!why_not(solver->capabilities(), Problem("first", contact)).empty()) continue;
    solve(*solver, Problem("first", contact));
    contact.v *= -0.5;
    contact.v(0) += 0.25;
    solver->update(contact.v);
    Answer updated;
    solver->solve({}, updated);
    const Answer loaded = solve(*make(cone ? Options{{"cone", "true"}} : Options{}), Problem("second", contact));
    EXPECT_EQ(updated.claim, loaded.claim) << set;
    EXPECT_TRUE(same_bits(updated.z, loaded.z)) << set;
    EXPECT_TRUE(same_bits(updated.velocity, loaded.velocity)) << set;
  }
}

TEST_P(ConformanceTest, HandlesNoAndOneUnknown) {
  const Capabilities needs = capabilities();
  if (needs.needs == Needs::kScene) GTEST_SKIP() << "takes rigid-body scenes only";
  const auto problem = [&](Matrix M, Vector q) {
    const Lcp lcp{std::move(M), std::move(q)};
    return needs.needs == Needs::kDense ? Problem("edge", lcp) : Problem("edge", contact_problem_of(lcp));
  };
  const Answer none = solve(problem(Matrix(0, 0), Vector(0)));
  EXPECT_EQ(none.claim, Claim::kSolved) << none.detail;
  EXPECT_EQ(none.z.size(), 0);
  const Answer pushed = solve(problem(testing::matrix_of(1, {4}), testing::vector_of({-6})));
  EXPECT_EQ(pushed.claim, Claim::kSolved) << pushed.detail;
  EXPECT_NEAR(pushed.z(0), 1.5, kPlantedError);
  const Answer parting = solve(problem(testing::matrix_of(1, {4}), testing::vector_of({6})));
  EXPECT_EQ(parting.claim, Claim::kSolved) << parting.detail;
  EXPECT_NEAR(parting.z(0), 0, kPlantedError);
  const Answer resting = solve(problem(testing::matrix_of(1, {4}), testing::vector_of({0})));
  EXPECT_EQ(resting.claim, Claim::kSolved) << resting.detail;
  EXPECT_NEAR(resting.z(0), 0, kPlantedError);
}

TEST_P(ConformanceTest, SameInputSameAnswer) {
  const Index n = size_up_to(20);
  Vector z, other_z;
  PLANTED_OR_SKIP(problem, n, 3, z);
  PLANTED_OR_SKIP(another, n, 4, other_z);
  const auto solver = make();
  const Answer first = solve(*solver, problem);
  Answer again;
  solver->solve({}, again);
  solve(*solver, another);  // nothing of it may stay behind
  for (const Answer& answer : {again, solve(*solver, problem), solve(problem)}) {
    EXPECT_EQ(answer.claim, first.claim);
    EXPECT_EQ(answer.detail, first.detail);
    EXPECT_TRUE(same_bits(answer.z, first.z));
    EXPECT_EQ(answer.counters.iterations, first.counters.iterations);
    EXPECT_EQ(answer.counters.pivots, first.counters.pivots);
    EXPECT_EQ(answer.counters.factorizations, first.counters.factorizations);
  }
}

TEST_P(ConformanceTest, ClaimsNothingUntrueOnTextbookProblems) {
  int taken = 0;
  for (const testing::TextbookLcp& textbook : testing::textbook_lcps()) {
    const Problem problem(textbook.name, textbook.lcp);
    if (!takes(problem)) continue;
    ++taken;
    const Answer answer = solve(problem);
    EXPECT_TRUE(answer.z.size() == 0 || answer.z.size() == problem.size()) << textbook.name;
    if (answer.claim == Claim::kSolved) {
      EXPECT_TRUE(textbook.solvable) << textbook.name << ": claims solved, but nothing solves it";
      EXPECT_LE(testing::relative_residual(textbook.lcp, answer.z), kClaimedResidual) << textbook.name;
    }
    if (GetParam() == "auto" && textbook.monotone && textbook.solvable) {
      EXPECT_EQ(answer.claim, Claim::kSolved) << textbook.name;
    }
    if (answer.claim == Claim::kUnsolvable && textbook.monotone) {
      EXPECT_FALSE(textbook.solvable) << textbook.name << ": monotone and solvable, yet claims unsolvable";
    }
  }
  if (taken == 0) GTEST_SKIP() << "takes no bare LCP";
}

// u >= 0 with N u = 0 and v'N u < 0: the contacts push against each other, and no impulse parts them.
TEST_P(ConformanceTest, NeverClaimsToSolveInfeasibleMonotoneProblems) {
  const Capabilities needs = capabilities();
  if (needs.needs == Needs::kScene) GTEST_SKIP() << "takes rigid-body scenes only";
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Uniform uniform(seed);
    const Index n = std::min<Index>(6, needs.max_size);
    Matrix N(n + 1, n);  // the last coordinate is immovable: its velocity counts, no impulse changes it
    for (Index j = 0; j < n; ++j) {
      for (Index i = 0; i < n; ++i) N(i, j) = static_cast<double>(uniform.integer(-4, 4));
      N(n, j) = 1;
    }
    N.col(n - 1).head(n) = -N.leftCols(n - 1).topRows(n).rowwise().sum();
    Matrix Ginv = Matrix::Identity(n + 1, n + 1);
    Ginv(n, n) = 0;
    const Vector v = -Vector::Unit(n + 1, n);
    const Answer answer = solve(Problem("infeasible", frictionless(v, N, InverseInertia{Ginv})));
    EXPECT_NE(answer.claim, Claim::kSolved) << "seed " << seed << ": " << answer.detail;
  }
}

// --- refusals and limits ---

TEST_P(ConformanceTest, RefusesDataThatAreNotNumbers) {
  const auto expect_refused = [](const Answer& answer) {
    EXPECT_EQ(answer.claim, Claim::kUnsupported);
    EXPECT_FALSE(answer.detail.empty());
    EXPECT_EQ(answer.z.size(), 0);
  };
  const Lcp lcp{Matrix::Identity(2, 2), -testing::ones(2)};
  const ContactProblem contact = contact_problem_of(lcp);
  for (const double bad : {std::nan(""), kInfinity, -kInfinity}) {
    Lcp in_matrix = lcp, in_vector = lcp;
    in_matrix.M(0, 0) = in_vector.q(1) = bad;
    expect_refused(solve(Problem("bad", in_matrix)));
    expect_refused(solve(Problem("bad", in_vector)));
    ContactProblem changed = contact;
    for (double* entry : {&changed.v(0), &changed.mu(1), &std::get<Matrix>(changed.N)(1, 0),
                          &std::get<DenseInertia>(changed.inertia).G(1, 1)}) {
      const double good = std::exchange(*entry, bad);
      expect_refused(solve(Problem("bad", changed)));
      *entry = good;
    }
    const auto solver = make();
    solve(*solver, Problem("good", contact));
    solver->update(Vector(Vector::Constant(2, bad)));
    Answer updated;
    solver->solve({}, updated);
    EXPECT_EQ(updated.claim, Claim::kUnsupported);
  }
}

TEST_P(ConformanceTest, RecoversFromARefusedProblem) {
  Vector z;
  PLANTED_OR_SKIP(problem, 1, 5, z);
  const auto solver = make();
  solve(*solver, Problem("bad", Lcp{Matrix::Identity(1, 1), testing::vector_of({kInfinity})}));
  EXPECT_EQ(solve(*solver, problem).claim, Claim::kSolved);
}

TEST_P(ConformanceTest, ObeysItsIterationLimit) {
  const Index n = size_up_to(12);
  Vector z;
  PLANTED_OR_SKIP(problem, n, 6, z);
  bool has_limit = false;
  for (const SettingInfo& setting : definition().settings()) {
    if (setting.name != "max_iterations" && setting.name != "max_pivots") continue;
    has_limit = true;
    const Answer answer = solve(*make({{setting.name, "1"}}), problem);
    EXPECT_EQ(answer.claim, Claim::kIterationLimit) << setting.name;
    EXPECT_LE(std::max(answer.counters.iterations, answer.counters.pivots), 1) << setting.name;
  }
  if (!has_limit) GTEST_SKIP() << "has no max_iterations or max_pivots";
}

TEST_P(ConformanceTest, ObeysItsTimeLimit) {
  if (!capabilities().obeys_time_limit) GTEST_SKIP() << "does not declare obeys_time_limit";
  Vector z;
  PLANTED_OR_SKIP(problem, size_up_to(150), 8, z);
  SolveRequest request;
  request.time_limit_s = 0;
  EXPECT_EQ(solve(problem, request).claim, Claim::kTimeLimit);
  request.time_limit_s = 1e6;
  EXPECT_EQ(solve(problem, request).claim, Claim::kSolved);
}

// Data at the ends of the range of doubles, singular, indefinite, degenerate: any claim, but no exception, and an
// answer of the right length.
TEST_P(ConformanceTest, SurvivesExtremeData) {
  Uniform uniform(9);
  const auto solver = make();
  for (const Index n : {1, 3, 6}) {
    const Matrix random = uniform.matrix(n, n);
    for (const double scale : {0x1p-1070, 1e-300, 1e-150, 1.0, 1e150, 1e300}) {
      for (const Matrix& M :
           {Matrix(scale * random), Matrix(scale * random * random.transpose()), Matrix(Matrix::Constant(n, n, scale)),
            Matrix(Matrix::Zero(n, n)), Matrix(-scale * Matrix::Identity(n, n))}) {
        for (const double size : {0x1p-1070, 1.0, 1e300}) {
          Answer answer;
          const Problem problem("extreme", Lcp{M, size * uniform.vector(n)});
          ASSERT_NO_THROW(answer = solve(*solver, problem, {.time_limit_s = 5})) << M << "\n" << problem.lcp().q;
          EXPECT_TRUE(answer.z.size() == 0 || answer.z.size() == n);
          EXPECT_FALSE(answer.claim == Claim::kSolved && !answer.z.allFinite()) << M << "\n" << problem.lcp().q;
        }
      }
    }
  }
}

TEST_P(ConformanceTest, AllocatesNothingInASolve) {
  const bool may_allocate = GetParam() == "auto" || GetParam() == "psor";  // a solve may load other methods
  EXPECT_EQ(capabilities().allocation_free, !may_allocate);
  for (const Index n : {5, 40, 200}) {
    if (n > capabilities().max_size) continue;
    Vector z;
    PLANTED_OR_SKIP(problem, n, 10, z);
    const auto solver = make();
    Answer answer = solve(*solver, problem);  // its storage is reused below
    EXPECT_EQ(testing::count_allocations([&] { solver->solve({}, answer); }), 0) << "n = " << n;
  }
}

/// The problem beside itself as often as it takes for more than 12 rows: up to these, exact arithmetic may decide,
/// which allocates. Each is coupled to the next, for of separate blocks `auto` loads one after the other.
Lcp repeated(const Lcp& lcp) {
  const Index n = lcp.size();
  const Index copies = 12 / n + 1;
  Lcp all{Matrix::Zero(copies * n, copies * n), lcp.q.replicate(copies, 1)};
  for (Index k = 0; k < copies; ++k) all.M.block(k * n, k * n, n, n) = lcp.M;
  for (Index k = 0; k + 1 < copies; ++k) all.M.block(k * n, (k + 1) * n, n, n).setOnes();
  return all;
}

TEST_P(ConformanceTest, AllocatesNothingWhereItFailsAndSaysWhy) {
  for (const testing::TextbookLcp& textbook : testing::textbook_lcps()) {
    if (textbook.lcp.size() == 0) continue;
    const Problem problem("case", repeated(textbook.lcp));
    const auto solver = make();
    solver->load(problem);
    Answer answer;
    answer.reserve(problem);
    const auto allocations = testing::count_allocations([&] { solver->solve({}, answer); });
    if (answer.claim == Claim::kUnsupported) continue;  // nothing was solved
    if (GetParam() == "auto" && answer.detail != "lemke") continue;  // loads other methods
    EXPECT_EQ(allocations, 0) << textbook.name << ": " << answer.detail;
  }
}

TEST(AllocationCounterTest, SeesEveryForm) {
  if (!testing::allocations_are_counted()) GTEST_SKIP() << "allocations cannot be counted in this build";
  Vector grown(2);
  EXPECT_EQ(testing::count_allocations([&] { grown.resize(1000); }), 1);
  std::vector<double> values;
  EXPECT_EQ(testing::count_allocations([&] { values.resize(1000); }), 1);
  struct alignas(64) Aligned {
    double value[8];
  };
  std::unique_ptr<Aligned> aligned;
  EXPECT_EQ(testing::count_allocations([&] { aligned = std::make_unique<Aligned>(); }), 1);
  EXPECT_EQ(testing::count_allocations([] {}), 0);
}

INSTANTIATE_TEST_SUITE_P(Native, ConformanceTest, ::testing::ValuesIn(testing::native_solvers()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace lcpbench::conformance_test
