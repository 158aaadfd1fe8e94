#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/isa.h"
#include "core/settings.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/lemke/lemke_engine.h"
#include "native/lemke/lemke_loaded.h"

namespace lcpbench {

enum class LemkeCover { kNegative, kAll };
enum class LemkeCap { kPaper, kLemke, k3n };
/// kAuto: kResidual with the kernel engine and both tolerances at their defaults, else kNone.
enum class LemkeAnswerTest { kAuto, kNone, kResidual };

struct LemkeSettings {
  LemkeEngine engine = LemkeEngine::kKernel;
  LemkeCover cover = LemkeCover::kNegative;
  double pivot_tolerance = 1e-10;
  double zero_tolerance = 1e-6;
  LemkeCap cap = LemkeCap::kPaper;
  std::int64_t max_pivots = 0;
  LemkeAnswerTest test = LemkeAnswerTest::kAuto;

  void visit(auto&& field) {
    field("engine", engine, Choices<LemkeEngine>{{{"dense", LemkeEngine::kDense}, {"kernel", LemkeEngine::kKernel}}},
          "what is factored afresh at each pivot: the whole basis, or only its kernel, the rows whose w is nonbasic");
    field("cover", cover, Choices<LemkeCover>{{{"negative", LemkeCover::kNegative}, {"all", LemkeCover::kAll}}},
          "covering vector: 1 where q < 0 and 0 elsewhere, as in LEMKE; all: different numbers from 1 to 2, but 0 in "
          "rows of friction cones");
    field("pivot_tolerance", pivot_tolerance, RealRange{.min = 0}, "a row may leave only if its pivot is larger");
    field("zero_tolerance", zero_tolerance, RealRange{.min = 0},
          "slack of the ratio test, and of q >= 0 in the test for z = 0");
    field("cap", cap,
          Choices<LemkeCap>{{{"paper", LemkeCap::kPaper}, {"lemke", LemkeCap::kLemke}, {"3n", LemkeCap::k3n}}},
          "limit on pivots: max(1000, n^2) as in the paper, min(1000, 50 n) as in LEMKE, or max(200, 3 n)");
    field("max_pivots", max_pivots, IntegerRange{.min = 0, .max = std::int64_t{1} << 40},
          "another limit on pivots; 0: the one that `cap` names");
    field("test", test,
          Choices<LemkeAnswerTest>{{{"auto", LemkeAnswerTest::kAuto},
                                    {"none", LemkeAnswerTest::kNone},
                                    {"residual", LemkeAnswerTest::kResidual}}},
          "how an answer is tested from the raw data before it is claimed: not at all, as in LEMKE; by its residual; "
          "auto: by its residual with engine=kernel and both tolerances at their defaults, else not at all");
  }
};

/// One exchange. Variables are numbered w_i = i, z_i = n + i, artificial = 2 n.
struct LemkePivot {
  Index entering = 0;
  Index leaving = 0;
  bool operator==(const LemkePivot&) const = default;
};

/// Solves LCP(q, M) by Lemke's complementary pivoting with the rules of LEMKE, the program behind the study of
/// Drumwright and Shell (2012).
///
/// Covering vector 1 where q_i < 0 and 0 elsewhere, unless cover=all; ratio test with a zero tolerance, ties to the
/// largest pivot, the artificial variable preferred. Processes any copositive-plus M in exact arithmetic without
/// degeneracy [Cottle, Pang, Stone 1992, 4.4]; ties are not broken lexicographically, so that degenerate problems may
/// cycle up to the limit on pivots. Cost per pivot: engine=dense 2/3 n^3; engine=kernel O(k^3 + n k) with k the number
/// of nonbasic w, and the first time that a z enters O(ngc^2 + ngc n) for its column of M. load(): O(ngc^3) for
/// contacts, O(n^2) for a bare LCP. See docs/reference/solvers/lemke.md.
///
/// kSolved: the artificial variable left the basis, and, with test=residual, the answer passes AnswerTest. kUnsolvable,
/// with test=residual: AnswerTest found a proof; with test=none: no row blocks the entering variable (a ray: proof of
/// nothing but for copositive-plus M). kIterationLimit, kTimeLimit; kNumericalFailure: singular or overflowing basis,
/// an answer that does not pass, or, with test=residual, a ray without a proof. z is zero unless the claim is
/// kSolved or `detail` is "unconfirmed".
class Lemke final : public Solver {
 public:
  /// @param level instruction-set level of the engine; must not exceed best_isa_level().
  explicit Lemke(const LemkeSettings& settings, IsaLevel level = isa_level());

  const Capabilities& capabilities() const override { return capabilities_; }

  /// LemkeSettings::max_pivots of later solves.
  void limit_pivots(std::int64_t max_pivots) { settings_.max_pivots = max_pivots; }

  /// Appends every pivot of later solves to `pivots`, but for the first exchange, which brings in the artificial
  /// variable. For tests; nullptr ends it. Not owned.
  void record_pivots(std::vector<LemkePivot>* pivots) { recorded_ = pivots; }

 private:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  LemkeSettings settings_;
  Capabilities capabilities_;
  std::unique_ptr<lemke::Engine> engine_;
  std::unique_ptr<AnswerTest> test_;
  std::vector<LemkePivot>* recorded_ = nullptr;
};

/// The limit on pivots for problems of order n.
std::ptrdiff_t lemke_pivot_limit(const LemkeSettings& settings, Index n);

}  // namespace lcpbench
