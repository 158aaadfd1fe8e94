#pragma once

#include <limits>
#include <memory>

#include "core/solver.h"

namespace lcpbench {

/// The error measures of one answer, all from the raw data in 113-bit arithmetic, by code that knows no solver.
/// NaN: the measure does not apply (no contact data) or z is no answer (empty, wrong length, not finite).
struct Errors {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  double velocity_residual_m_per_s = kNone;
  double velocity_residual_relative = kNone;  ///< the verdict's measure, rho
  double natural_residual = kNone;            ///< max |min(z_i, w_i)|: mixes units; for comparison with other studies
  double backward_componentwise = kNone;      ///< eta_mix, componentwise scale
  double backward_row_norm = kNone;           ///< eta_mix, row-norm scale
  double forward_velocity = kNone;            ///< against a certified v*; NaN where none is known
  double violation_m_per_s = kNone;           ///< max(0, -min N'v+)
  double work_gain_j = kNone;                 ///< 1/2 (v+ - v)' G (v+ + v)
  double complementarity_j = kNone;           ///< z'w
  double cone_violation = kNone;              ///< [N s]
  double min_z = kNone;
  bool usable = false;     ///< z is finite and of the right length
  bool solved = false;     ///< rho <= 1e-4 (bare LCP: backward_row_norm <= 1e-9)
  bool criterion = false;  ///< passes the paper's criterion (contact problems only)
};

/// What is known of a problem whoever solved it.
enum class Truth { kUnknown, kSolvable, kUnsolvable };

enum class Verdict { kSolved, kCriterionOnly, kWrong, kUnsolvable, kMissed, kOpen };

/// "solved", "criterion_only", "wrong", "unsolvable", "missed", "open".
const char* to_string(Verdict verdict);

/// The verdict on an answer. Every combination of claim, truth and errors is fixed by the table in docs/verdicts.md.
Verdict verdict(Claim claim, const Errors& errors, Truth truth);

/// Claimed solved, and the verdict is wrong or unsolvable.
bool false_claim(Claim claim, Verdict verdict);

/// Evaluates answers to one problem. Keeps the problem's data in 113-bit arithmetic; columns of M are formed once, when
/// an answer first uses them. One object per thread.
class Evaluator {
 public:
  explicit Evaluator(const Problem& problem);
  ~Evaluator();

  /// Every measure of the answer's z (and, for forward errors, its velocity).
  Errors errors(const Answer& answer);

  /// kSolvable when theory proves it from the data (contact problem, G positive definite, checked here in 113 bits);
  /// else kUnknown. kUnsolvable needs a proof: see check_farkas.
  Truth truth() const;

  /// True when u (nc entries, >= 0) proves in exact dyadic arithmetic that the contact problem has no solution:
  /// N u in null(G) and v'N u < 0; for a bare LCP: u >= 0, M'u <= 0, q'u < 0.
  bool check_farkas(const Vector& u) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace lcpbench
