#pragma once

#include <array>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include "core/answer/limits.h"
#include "core/solver.h"

namespace lcpbench {

/// The paper's criterion: bounds on the work gain [J] and on the normal violation [m/s].
inline constexpr double kCriterionWork = 1e-3;
inline constexpr double kCriterionViolation = 1e-3;

/// The row of the LCP where the verdict's measure is largest, with the numbers that give it there.
struct WorstRow {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  Index row = -1;  ///< -1: the answer has no measure, or no row is violated
  double z = kNone;
  double w = kNone;
  double residual = kNone;  ///< [m/s]; contact problems only
  double scale = kNone;     ///< of the row's island [m/s]; contact problems only
  // Of a cone row: how its contact moves, and what it carries. But for the slip, of the cone and the convex model only.
  double slip = kNone;        ///< sliding speed, with offsets and compliance [m/s]
  double separation = kNone;  ///< w_N [m/s]
  double normal = kNone;      ///< f_N [N s]
  double friction = kNone;    ///< |f_t| [N s]
  double opposing = kNone;    ///< cosine between friction and the opposite of the slip
};

/// Where a returned velocity is furthest from the one that z implies.
struct WorstCoordinate {
  Index coordinate = -1;  ///< -1: no velocity came back, or it is of another length or not finite
  double returned = 0;
  double implied = 0;
};

/// The error measures of one answer, all from the raw data in 113-bit arithmetic, by code that knows no solver.
///
/// v+ = v + G* (N f_N + D f_D) is recomputed from z. w is the complement of z: N'v+ + b [m/s], D'v+ + lambda [m/s], and
/// mu f_N less the sum of the contact's f_D [N s]. Quotients follow 0/0 = 0 and x/0 = infinity.
/// NaN: the measure does not apply (no contact data), or z is no answer (empty, wrong length, not finite), or the
/// problem's data are not finite. Infinity: the measure exceeds the largest double.
struct Errors {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  /// r: the largest |min(M_ii z_i, w_i)| of the normal and friction rows and |min(lambda_i, M_nn,ii w_i)| of the cone
  /// rows, M_nn,ii being the diagonal entry of the contact's normal row. Where M_ii = 0 the impulse moves nothing, and
  /// only w_i >= 0 is asked for.
  double velocity_residual_m_per_s = kNone;
  /// rho, the verdict's measure of contact problems: the largest of the islands' quotients r_I / scale_I. r_I is the
  /// largest entry of r among the island's rows; scale_I = max(max|q_i|, floor / 1e-4) over the same rows, floor being
  /// the largest error of forming a q_i in double, (k_i + 1) (2^-53 (|J_i|'|v| + |b_i|) + 2^-1074) with k_i nonzero
  /// entries in J_i and b_i.
  double velocity_residual_relative = kNone;
  /// The largest residual of the round Coulomb cone's conditions, whatever model was solved: the error of model and
  /// solver together, see measure_friction(). NaN without friction, and where the friction directions name no cone.
  double model_error_m_per_s = kNone;
  double natural_residual = kNone;        ///< max |min(z_i, w_i)|: mixes units; for comparison with other studies
  /// The verdict's measure of bare LCPs, see lcp_error(): the largest |min(c_i z_i, w_i)| / (|q_i| + c_i max|z|);
  /// of mixed ones mid(c_i (z_i - lower_i), c_i (z_i - upper_i), w_i) in place of the minimum, see lcp_error().
  double backward_row_norm = kNone;
  double forward_velocity = kNone;        ///< ||v+ - v*||_G / ||v||_G; NaN where no v*, or no G, is known
  /// How far the returned velocity u is from what z implies: the largest |G (u - v) - J f|_i relative to
  /// (|G| (|u| + |v|) + |J| f)_i, the scale of rounding in it. 1e-16 is rounding; above 1e-9 u and z are two answers.
  /// Singular G: G (v+ - v) stands for J f, and the part of u - v outside the range of G, relative to max|u| + max|v|,
  /// counts too. Only G* known: |u - v - G* J f|_i relative to (|u| + |v| + |G*| |J| f)_i.
  /// NaN where no velocity came back; infinity for a velocity of another length or not finite.
  double velocity_mismatch = kNone;
  /// The part of the verdict that a returned velocity u decides: the largest |u - v+|_i / scale_i of the coordinates.
  /// scale_i is |v|_i + |v+ - v|_i, or where the quotient then exceeds 1e-4,
  /// (|v| + |G*| |J| |f|)_i + rounding_i / 1e-4, with
  /// rounding_i = (k + 1) (2^-53 sqrt(G*_ii) (sqrt(v'G v) + sum_j sqrt(M_jj) |f_j|) + 2^-1074) + solving_i,
  /// solving_i = min(m 2^-53 (|G*| |G| |c|)_i, 1e-4 max_j(sqrt(G_jj) |c_j|) / sqrt(G_ii)), c = v+ - v,
  /// over the coordinate's island, m its coordinates, k its impulses f_j that are not zero; without the terms in v and
  /// G where only G* is known. NaN where no velocity came back; infinity for one of another length or not finite.
  double returned_velocity_error = kNone;
  double violation_m_per_s = kNone;  ///< max(0, -min(N'v+ + b))
  /// 1/2 (v+ - v)'G (v+ + v), with G itself: for a singular G this is not z'q + 1/2 z'M z.
  /// Where only G* is known, G (v+ - v) is replaced by J f, which is the same unless G* is singular.
  double work_gain_j = kNone;
  double complementarity_j = kNone;  ///< z'w
  double cone_violation = kNone;     ///< max over contacts of max(0, sum f_D - mu f_N) [N s]
  double min_z = kNone;              ///< 0 for n = 0
  /// Of the convex model about |v+ - v*|_G / |v+ - v|_G or more, v* the only optimum's: see measure_friction().
  double optimum_distance = kNone;
  /// Of a valid proof u that came with an answer to a contact problem, -u'(N'v + b) / sum(u): no impulses violate all
  /// contacts by less. Rounded down.
  double least_violation_m_per_s = kNone;
  WorstRow worst;  ///< of rho; of the backward error for bare LCPs
  WorstCoordinate worst_coordinate;
  bool usable = false;  ///< z is finite and of the right length
  /// Not measured: 113 bits do not tell what G* is (see QuadInertia), or the friction directions name no round cone, by
  /// which the answer is to be measured.
  bool unresolved = false;
  double limit = kSolvedVelocityResidual;  ///< on measure(), by which `solved` was decided
  /// measure() <= limit, r is no overflow, and velocity_passes().
  bool solved = false;
  /// Passes the paper's criterion: no test of sign, cone, complementarity (contact only). Of an offset the work that a
  /// solution may gain by it, -b'f_N, is allowed.
  bool criterion = false;

  /// rho, or the backward error of a bare LCP.
  double measure() const {
    return std::isnan(velocity_residual_relative) ? backward_row_norm : velocity_residual_relative;
  }
  /// Decides `solved` by this bound.
  void decide(double bound) {
    limit = bound;
    solved = measure() <= limit && !std::isinf(velocity_residual_m_per_s) && velocity_passes();
  }

  /// Also where no velocity came back.
  bool velocity_passes() const { return !(returned_velocity_error > kSolvedReturnedVelocity); }
};

/// One measure of an answer.
struct Metric {
  const char* name;  ///< key of `errors` in `solve --format json`, and column of `verdicts`
  double Errors::*value;
  bool stored = true;  ///< it has a column
};

/// The version of the store's format. It rises when the meaning of a verdict, the stored measures below or the store's
/// schema change, so that answers judged by two definitions do not meet in one store.
inline constexpr std::int64_t kVerdictVersion = 11;

/// Every measure, in the order of the columns. All code that writes, reads, merges or prints all measures uses this
/// table.
inline constexpr std::array kMetrics{
    Metric{"velocity_residual_m_per_s", &Errors::velocity_residual_m_per_s},
    Metric{"velocity_residual_relative", &Errors::velocity_residual_relative},
    Metric{"model_error_m_per_s", &Errors::model_error_m_per_s},
    Metric{"natural_residual", &Errors::natural_residual},
    Metric{"backward_row_norm", &Errors::backward_row_norm},
    Metric{"forward_velocity", &Errors::forward_velocity},
    Metric{"violation_m_per_s", &Errors::violation_m_per_s},
    Metric{"work_gain_j", &Errors::work_gain_j},
    Metric{"complementarity_j", &Errors::complementarity_j},
    Metric{"cone_violation", &Errors::cone_violation},
    Metric{"min_z", &Errors::min_z},
    Metric{"returned_velocity_error", &Errors::returned_velocity_error},
    Metric{"least_violation_m_per_s", &Errors::least_violation_m_per_s},
    Metric{"velocity_mismatch", &Errors::velocity_mismatch, false},
    Metric{"optimum_distance", &Errors::optimum_distance, false},
};

/// What one answer shows about itself and its problem, without other answers.
struct Judgement {
  Errors errors;
  bool proof_holds = false;  ///< it came with a proof that the problem has no solution, and the proof is valid
  double verify_s = 0;       ///< thread CPU time that finding this out took; set by a Judge
};

/// Whether a problem is proven to have a solution. An answer within the tolerance proves none.
enum class Truth {
  kUnknown,
  kSolvable,
  kUnsolvable,
  kNearly,    ///< it is proven to have no exact solution, and a passing answer is known
  kAnswered,  ///< nothing is proven, and a passing answer is known: "unknown" to all readers
};

/// "unknown", "solvable", "unsolvable", "nearly"; of kAnswered "unknown".
const char* to_string(Truth truth);

/// The kinds of evidence for a problem's truth.
enum class Evidence {
  kCertifiedUnsolvable,
  kValidProof,  ///< that came with an answer
  kTheory,      ///< see Evaluator::truth
  kCertifiedSolution,
  kSolvedAnswer,
};

/// The rule of truth: the first line that there is evidence of decides. The view `truths` of a store is made of it.
struct TruthRule {
  Evidence evidence;
  Truth truth;
  std::optional<Evidence> also = std::nullopt;  ///< asked for as well
};

inline constexpr std::array kTruthRules{
    TruthRule{Evidence::kCertifiedUnsolvable, Truth::kNearly, Evidence::kSolvedAnswer},
    TruthRule{Evidence::kValidProof, Truth::kNearly, Evidence::kSolvedAnswer},
    TruthRule{Evidence::kCertifiedUnsolvable, Truth::kUnsolvable},
    TruthRule{Evidence::kValidProof, Truth::kUnsolvable},
    TruthRule{Evidence::kTheory, Truth::kSolvable},
    TruthRule{Evidence::kCertifiedSolution, Truth::kSolvable},
    TruthRule{Evidence::kSolvedAnswer, Truth::kAnswered}};

/// The evidence about one problem.
class Findings {
 public:
  void add(Evidence evidence) { found_.set(static_cast<std::size_t>(evidence)); }
  /// What the answer adds.
  void add(const Judgement& judgement);
  bool has(Evidence evidence) const { return found_.test(static_cast<std::size_t>(evidence)); }
  /// By the rule.
  Truth truth() const;

 private:
  std::bitset<static_cast<std::size_t>(Evidence::kSolvedAnswer) + 1> found_;
};

/// The verdict on an answer, from its claim, its measures and the problem's truth.
enum class Verdict {
  kSolved,      ///< passes, and the problem is not unsolvable
  kWrong,       ///< claimed solved and is not: a false claim
  kUnsolvable,  ///< the problem is proven to have no solution; where it is nearly solvable, the claim says so
  kRefused,     ///< the problem is outside what the solver takes, and is not proven to have no solution
  kMissed,      ///< neither passes nor is claimed solved, though the problem is solvable or another answer passes
  kOpen,        ///< no passing answer and no truth, or an answer that is not measured
};

/// The rule of verdicts: the first line whose conditions all hold decides. docs/explanation/verdicts.md spells out
/// every combination of claim, truth and errors; the view `judged` of a store is made of these lines.
struct VerdictRule {
  Verdict verdict;
  bool passes = false;  ///< asks for Errors::solved
  std::optional<Claim> claim = std::nullopt;
  std::optional<Truth> truth = std::nullopt;
  std::optional<Truth> truth_is_not = std::nullopt;
  bool unresolved = false;  ///< asks for Errors::unresolved
};

inline constexpr std::array kVerdictRules{
    VerdictRule{.verdict = Verdict::kUnsolvable, .claim = Claim::kUnsolvable, .truth = Truth::kNearly},
    VerdictRule{.verdict = Verdict::kSolved, .passes = true, .truth_is_not = Truth::kUnsolvable},
    VerdictRule{.verdict = Verdict::kOpen,
                .claim = Claim::kSolved,
                .truth_is_not = Truth::kUnsolvable,
                .unresolved = true},
    VerdictRule{.verdict = Verdict::kWrong, .claim = Claim::kSolved},
    VerdictRule{.verdict = Verdict::kUnsolvable, .truth = Truth::kUnsolvable},
    VerdictRule{.verdict = Verdict::kRefused, .claim = Claim::kUnsupported},
    VerdictRule{.verdict = Verdict::kMissed, .truth = Truth::kSolvable},
    VerdictRule{.verdict = Verdict::kMissed, .truth = Truth::kNearly},
    VerdictRule{.verdict = Verdict::kOpen, .claim = Claim::kUnsolvable, .truth = Truth::kAnswered},
    VerdictRule{.verdict = Verdict::kMissed, .truth = Truth::kAnswered},
    VerdictRule{.verdict = Verdict::kOpen}};

inline constexpr std::size_t kVerdicts = 6;

/// Every verdict, in the order of the enum.
inline constexpr std::array<Verdict, kVerdicts> kAllVerdicts{Verdict::kSolved,  Verdict::kWrong,  Verdict::kUnsolvable,
                                                             Verdict::kRefused, Verdict::kMissed, Verdict::kOpen};

/// "solved", "wrong", "unsolvable", "refused", "missed", "open".
const char* to_string(Verdict verdict);

/// The verdict on an answer, by the rule.
Verdict verdict(Claim claim, const Errors& errors, Truth truth);

/// Evaluates answers to one problem. Parts of M are formed when an answer first needs them; M as a whole never is for a
/// contact problem. One object per thread.
///
/// Velocities and rows of the LCP are computed in 113 bits. Sums of magnitudes and diagonal entries of M are right to
/// 2^-30 of them, in practice to the last digits of a double.
class Evaluator {
 public:
  explicit Evaluator(const Problem& problem);
  ~Evaluator();

  /// Every measure of the answer's z and of its velocity.
  Errors errors(const Answer& answer);
  /// The measures and the check of the answer's proof. Leaves verify_s at 0, since reading a clock would take a tenth
  /// of the time of a small step.
  Judgement judge(const Answer& answer);

  /// Makes known the certified post-impact velocity v* (ngc): errors() then gives the forward errors too. It is for the
  /// caller to know that v* is the only one (frictionless, positive definite G).
  /// @throws std::invalid_argument for a bare LCP, or v* of another length or not finite.
  void set_certified_velocity(const Vector& v_star);

  /// errors(answer).forward_velocity at a small part of its cost.
  double forward_velocity(const Answer& answer);

  /// kSolvable when theory proves it from the data, else kUnknown; kUnsolvable needs a proof, see check_farkas.
  ///
  /// Contact problem with mu >= 0, b >= 0 and G (or the given G*) proven positive definite here: solvable
  /// for any rank of N and D. M is copositive, z'M z = 0 forces J f = 0 and so q'z = b'f_N >= 0, and a copositive LCP
  /// whose q is nonnegative on the solutions of LCP(0, M) is solvable. [Anitescu, Potra 1997; Cottle, Pang, Stone 1992,
  /// Thm 3.8.6]
  /// Contact problem with mu >= 0 whose contacts all yield, r_n > 0: solvable, whatever G and b are; a given G* has to
  /// be positive semidefinite in exact arithmetic.
  /// Bare LCP of at most 64 rows: M + M' proven positive definite in the same way. [ibid., Thm 3.1.6] A
  /// mixed one, too, unless it has rows of friction: it is a variational inequality on a box. [Facchinei, Pang 2003,
  /// Thm 2.3.3]
  Truth truth() const;

  /// True when u (nc entries, >= 0) proves in exact dyadic arithmetic that the contact problem has no solution:
  /// N u in null(G) and (N'v + b)'u < 0; for a bare LCP: u >= 0, M'u <= 0, q'u < 0. See core/answer/farkas.h. A u
  /// that holds only to rounding, as floating-point solvers return it for real data, is no proof: false.
  bool check_farkas(const Vector& u) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace lcpbench
