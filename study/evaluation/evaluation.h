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
  double in_own_unit = kNone;  ///< of a bounded row: the residual in m/s or rad/s
  double scale = kNone;     ///< what the residual is relative to: of the island [m/s]; of a bare LCP of the row
  // Of a cone row: how its contact moves, and what it carries. But for the slip, of the cone and the convex model only.
  double slip = kNone;        ///< sliding speed, with offsets and compliance [m/s]
  double separation = kNone;  ///< w_N [m/s]
  double normal = kNone;      ///< f_N [N s]
  double friction = kNone;    ///< |f_t| [N s]
  double opposing = kNone;    ///< cosine between friction and the opposite of the slip
};

/// The bounded row whose residual is largest, angles turned into m/s, and that residual.
struct WorstBoundedRow {
  Index row = -1;       ///< among the bounded rows; -1: there is none, or none is violated
  double residual = 0;  ///< in its own unit [m/s, rad/s]
};

/// Where a returned velocity is furthest from the one that z implies.
struct WorstCoordinate {
  Index coordinate = -1;  ///< -1: no velocity came back, or it is of another length or not finite
  double returned = 0;
  double implied = 0;
  double scale = 0;  ///< what their difference is relative to
};

/// The error measures of one answer, all from the raw data in 113-bit arithmetic, by code that knows no solver.
/// docs/explanation/verdicts.md defines them all.
///
/// NaN: the measure does not apply (no contact data), or z is no answer (empty, wrong length, not finite), or the
/// problem's data are not finite. Infinity: the measure exceeds the largest double.
struct Errors {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double velocity_residual_m_per_s = kNone;   ///< r, the largest residual of all rows
  double velocity_residual_relative = kNone;  ///< rho, the verdict's measure of contact problems
  /// The largest residual of the round Coulomb cone's conditions, whatever model was solved. NaN without friction, and
  /// where the friction directions name no cone.
  double model_error_m_per_s = kNone;
  double natural_residual = kNone;   ///< max |min(z_i, w_i)|: mixes units; for comparison with other studies
  double backward_row_norm = kNone;  ///< eta, the verdict's measure of bare LCPs, see lcp_error()
  double forward_velocity = kNone;   ///< ||v+ - v*||_G / ||v||_G; NaN where no v*, or no G, is known
  /// How far the returned velocity u is from what z implies: the largest |G (u - v) - J f|_i relative to
  /// (|G| (|u| + |v|) + |J| f)_i, the scale of rounding in it. 1e-16 is rounding; above 1e-9 u and z are two answers.
  /// Singular G: G (v+ - v) stands for J f, and the part of u - v outside the range of G, relative to max|u| + max|v|,
  /// counts too. Only G* known: |u - v - G* J f|_i relative to (|u| + |v| + |G*| |J| f)_i.
  /// NaN where no velocity came back; infinity for a velocity of another length or not finite.
  double velocity_mismatch = kNone;
  /// The part of the verdict that a returned velocity decides. NaN and infinity as of velocity_mismatch.
  double returned_velocity_error = kNone;
  double violation_m_per_s = kNone;  ///< max(0, -min(N'v+ + b))
  /// 1/2 (v+ - v)'G (v+ + v), with G itself: for a singular G this is not z'q + 1/2 z'M z.
  /// Where only G* is known, G (v+ - v) is replaced by J f, which is the same unless G* is singular.
  double work_gain_j = kNone;
  double complementarity_j = kNone;  ///< z'w
  double cone_violation = kNone;     ///< max over contacts of max(0, sum f_D - mu f_N) [N s]
  double min_z = kNone;              ///< 0 for n = 0
  double optimum_distance = kNone;   ///< of the convex model about |v+ - v*|_G / |v+ - v|_G or more
  /// Of a valid proof u that came with an answer to a contact problem, -u'(N'v + b) / sum(u): no impulses violate all
  /// contacts by less. Rounded down.
  double least_violation_m_per_s = kNone;
  /// Of a valid proof that came with an answer to a bare LCP: see lcpbench::proof_margin().
  double proof_margin = kNone;
  WorstRow worst;  ///< of rho; of the backward error for bare LCPs
  double contact_residual_m_per_s = kNone;  ///< the largest residual of the contacts' rows; NaN as r
  WorstBoundedRow worst_bounded_row;
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
inline constexpr std::int64_t kVerdictVersion = 12;

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
    Metric{"proof_margin", &Errors::proof_margin},
    Metric{"velocity_mismatch", &Errors::velocity_mismatch, false},
    Metric{"optimum_distance", &Errors::optimum_distance, false},
    Metric{"contact_residual_m_per_s", &Errors::contact_residual_m_per_s, false},
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
  kNearly,    ///< it is proven to have no exact solution, and a passing answer is known; of a bare LCP: by little
  kAnswered,  ///< nothing is proven, and a passing answer is known: "unknown" to all readers
};

/// "unknown", "solvable", "unsolvable", "nearly"; of kAnswered "unknown".
const char* to_string(Truth truth);

/// The kinds of evidence for a problem's truth.
enum class Evidence {
  kClearProof,  ///< that a bare LCP has no solution: valid, and its margin is above the verdict's bound
  kCloseProof,  ///< the same with a smaller margin
  kCertifiedUnsolvable,
  kValidProof,  ///< that came with an answer to contacts
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
    TruthRule{Evidence::kClearProof, Truth::kUnsolvable},
    TruthRule{Evidence::kCloseProof, Truth::kNearly},
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
  /// A valid proof. @param evidence  what it is for contacts @param margin  of a bare LCP; else NaN
  void add_proof(Evidence evidence, double margin);
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

  /// kSolvable when theory proves it from the data, else kUnknown; kUnsolvable needs a proof, see check_farkas().
  /// docs/explanation/verdicts.md names the theorems. A positive definite G is proven so here, and so is M + M' of a
  /// bare LCP of at most 64 rows.
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
