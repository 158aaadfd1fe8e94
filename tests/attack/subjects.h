#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/solver.h"
#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "tests/attack/judge.h"
#include "tests/attack/truth.h"

namespace lcpbench::attack {

/// What became of one answer. The first ones are right or honest; from kFalseSolved on they are contradictions.
enum class Outcome {
  kSolved,             ///< claimed solved, and the exact measure agrees
  kNearlySolved,       ///< as kSolved, and no solution exists without a tolerance
  kUnsolvable,         ///< claimed unsolvable, truly, with a vector that proves it exactly (certify: with any proof)
  kNearlyUnsolvable,   ///< claimed unsolvable, truly, and some subject's answer passes
  kUnsolvableNoProof,  ///< claimed unsolvable, truly or for all we know, without a vector that proves it exactly
  kMissed,             ///< no claim, although there is a solution
  kOpen,               ///< no claim, and there is no solution, or none that is known
  kRefused,            ///< the solver does not take such problems
  kUnresolved,         ///< contacts, and the evaluation says that it cannot resolve the inertia
  kFalseSolved,        ///< claimed solved, and rho > 1e-4 or eta > 1e-6, or z is no answer
  kFalseVelocity,      ///< claimed solved, and the returned velocity is not that of the impulses
  kFalseUnsolvable,    ///< claimed unsolvable, and there is a solution
  kFalseProven,        ///< the answer says "proven", and its vector proves nothing exactly
  kFalseCertificate,   ///< certify: the proof is wrong, or contradicts the truth
  kFalseRefusal,       ///< the reader of problem files refuses a valid problem, or reads another one
  kOtherVerdict,       ///< study/evaluation judges the same answer otherwise, or knows another truth
  kDiffersAgain,       ///< a fresh solver, to which this is the first problem, claims something else
  kCrashed,            ///< threw
};

inline constexpr std::size_t kOutcomes = 18;
const char* to_string(Outcome outcome);
constexpr bool contradiction(Outcome outcome) { return outcome >= Outcome::kFalseSolved; }

/// How a solver gets to a problem.
enum class Approach {
  kLoad,    ///< load(), solve()
  kUpdate,  ///< load() with another velocity, solve(), update(): contact problems; of an LCP as kLoad
  kStart,   ///< load(), solve() from a start that has nothing to do with the problem
};

/// "load", "update", "start".
const char* to_string(Approach approach);

/// One generated problem and all that is exactly true of it.
struct Target {
  explicit Target(Problem the_problem, Approach the_approach = Approach::kLoad)
      : problem(std::move(the_problem)),
        approach(the_approach),
        truth(exact_truth(problem)),
        judge(problem),
        evaluator(problem) {}

  Problem problem;
  Approach approach;
  ExactTruth truth;
  Judge judge;
  Evaluator evaluator;
  bool passes = false;      ///< some answer so far has rho <= 1e-4, or eta <= 1e-6
  bool unresolved = false;  ///< the evaluation could not judge some answer so far that claims to solve
};

/// What is under test at every problem: every native solver that is registered, with cone=true too where it has that
/// setting, "certify" and "reader", which writes the problem as a file and reads it.
std::vector<std::string> subject_names();

/// What meets one problem in kSampled only: "embedded:<solver>", ContactSolver with its velocity(), and every native
/// solver with its tolerances (accept_residual, tolerance) at their largest values, and in each of its other
/// precisions, and the forgers.
std::vector<std::string> sampled_subject_names();
inline constexpr std::uint64_t kSampled = 7;

/// What is under test. It lives through many problems, as a program that embeds it would let it.
class Subject {
 public:
  virtual ~Subject() = default;
  /// @param detail  one line about a contradiction
  virtual Outcome meet(Target& target, double time_limit_s, std::string& detail) = 0;
};

std::unique_ptr<Subject> make_subject(const std::string& name);

}  // namespace lcpbench::attack
