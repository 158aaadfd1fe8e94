#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/spec.h"
#include "core/timed_solve.h"
#include "study/certificates/judge.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {

/// How a solver fails on a problem.
enum class FailureKind {
  kWrong,    ///< its claim is false: solved and is not, or unsolvable and there is a solution
  kMissed,   ///< the problem has a solution and it returns none; or it crashes
  kDiffers,  ///< it solves the problem, and so does another, and the velocities differ
};

/// "wrong", "missed", "differs".
const char* to_string(FailureKind kind);

struct FailureOptions {
  Spec solver;
  std::optional<FailureKind> kind;     ///< none: the first that the problem shows
  std::optional<std::string> against;  ///< the other solver of kDiffers, or "certificate"; none: the first that differs
  double speed = 1e-3;                 ///< by which velocities must differ at least [m/s, rad/s]
  double time_limit_s = 10;            ///< of each solve; of each certificate as well, but at most 2 s
};

/// Whether a solver fails on a problem, and on smaller ones in the same way.
class FailureTest {
 public:
  /// Opens the solvers. @throws InputError for solvers that cannot run, and if they are the same
  explicit FailureTest(FailureOptions options);

  /// Finds out how the solver fails. fails() then asks for the same kind of failure, the same claim and the same other
  /// solver; and for a problem that is known to have a solution, where this one is. Call it once.
  /// @returns false when it does not fail
  /// @throws InputError where the solver, or the one to compare with, does not take the problem
  bool begin(const Problem& problem);
  bool fails(const Problem& problem);

  /// What happened, in one sentence. @pre the last call was begin(), or a fails() that was true
  const std::string& words() const { return words_; }
  FailureKind kind() const { return kind_; }
  const Spec& solver() const { return options_.solver; }
  /// The other solver of kDiffers, or "certificate"; "" for other kinds.
  const std::string& other() const { return other_; }

 private:
  /// An answer and what is known of it.
  struct Seen {
    Answer answer;
    Errors errors;
    FrictionModel model = FrictionModel::kPyramid;
  };

  /// Whether a problem has a solution, and how that is known.
  struct Settled {
    Truth truth = Truth::kUnknown;
    std::string because;
  };

  Seen see(const Problem& problem, const Spec& spec, Judge& judge);
  void require_taken(const Spec& spec, const Seen& seen) const;
  Settled truth(const Problem& problem, Judge& judge);
  Settled settle(const Problem& problem, Judge& judge);
  Settled certified(const Problem& problem);
  bool is_solvable(const Problem& problem, const Seen& seen, Judge& judge);
  bool is_wrong(const Problem& problem, const Seen& seen, Judge& judge);
  bool is_missed(const Problem& problem, const Seen& seen, Judge& judge);
  bool is_different(const Problem& problem, const Seen& seen, Judge& judge, const std::string& other);
  bool finds_other(const Problem& problem, const Seen& seen, Judge& judge);

  FailureOptions options_;
  FailureKind kind_ = FailureKind::kWrong;
  std::string other_;
  std::optional<Claim> claim_;                 ///< that every later answer must make
  bool solvable_ = false;                      ///< every later problem must be known to have a solution
  double accuracy_ = kSolvedVelocityResidual;  ///< most that both answers of kDiffers may leave
  double seen_accuracy_ = 0;
  std::string words_;
  std::optional<Settled> settled_;  ///< of the problem at hand, by more than what the judge knows
  std::map<std::string, std::unique_ptr<TimedSolver>> opened_;
  BoundedCertifier bounded_certifier_;
  Certifier certifier_;
};

}  // namespace lcpbench
