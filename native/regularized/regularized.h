#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/registry.h"
#include "core/settings.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"

namespace lcpbench {

/// Whose w the test takes; kResidual: as kOriginal, and then the test of all native solvers.
enum class RegularizedTest { kTried, kOriginal, kResidual };

struct RegularizedSettings {
  std::string solver = "lemke{test=none}";
  double first = 1e-20;
  double factor = 1e4;
  double last = 10.0;
  double tolerance = 1e-6;
  RegularizedTest test = RegularizedTest::kResidual;

  void visit(auto&& field) {
    field("solver", solver, "the native solver tried on each problem, with its settings in braces");
    field("first", first, RealRange{.min = 1e-300, .max = 1e300}, "first eps of the ladder");
    field("factor", factor, RealRange{.min = 1.5, .max = 1e300}, "each eps is the one before times this");
    field("last", last, RealRange{.min = 0, .max = 1e300}, "no eps is above this; 0: only M itself is tried");
    field("tolerance", tolerance, RealRange{.min = 0, .max = 1}, "relative tolerance of the test on z, w and z'w");
    field("test", test,
          Choices<RegularizedTest>{{{"tried", RegularizedTest::kTried},
                                    {"original", RegularizedTest::kOriginal},
                                    {"residual", RegularizedTest::kResidual}}},
          "w of the test is that of M + eps I, as published (passes answers far from the truth), or of M; residual: of "
          "M, and the answer has to solve the problem as given, from its raw data");
  }
};

/// The native solver that `spec` names. @throws InputError for a solver that does not run in this process.
const SolverDefinition& regularized_inner(const Spec& spec);

/// What `regularized` promises with this inner solver of that name.
Capabilities regularized_capabilities(const std::string& solver, const Capabilities& inner);

/// Adds counters up; unknown ones stay unknown.
void add_counters(Counters& sum, const Counters& counters);

/// How a try on M + eps I ended.
enum class TryOutcome { kPassed, kFailed, kOutOfTime };

/// The problem of one `regularized`, and the test that an answer has to pass.
///
/// With tau the tolerance, an answer passes when its solver claims it solved and c_i z_i >= -tau max|q|, w_i >= -tau
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

/// SolverDefinition::make_swept of `regularized`: null but for cells that differ in the tolerances of an inner `lemke`
/// alone, whose engine is kernel.
std::unique_ptr<SweptSolver> make_swept_regularized(const std::vector<Options>& cells);

}  // namespace lcpbench
