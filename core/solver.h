#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "core/problem.h"

namespace lcpbench {

class ContactsOfRows;
class LcpReduction;

/// The statement of a solver about its own answer. Our own statement is the verdict of the evaluation.
enum class Claim {
  kSolved,            ///< z is a solution
  kUnsolvable,        ///< there is no solution (a ray, an infeasible system)
  kIterationLimit,    ///< stopped by its own limit on iterations or pivots
  kTimeLimit,         ///< stopped by SolveRequest::time_limit_s, or ended from outside for it
  kNumericalFailure,  ///< gave up: no usable pivot, a breakdown, an error code
  kUnsupported,       ///< the problem is outside what the solver takes; `detail` says why, and there are no vectors
  kCrashed,           ///< died, or returned an invalid answer; only workers report it
};

/// "solved", "unsolvable", "iteration_limit", "time_limit", "numerical_failure", "unsupported", "crashed".
const char* to_string(Claim claim);

/// The inverse of to_string. @throws InputError for any other word.
Claim parse_claim(std::string_view text);

/// Which of the impulses that give its motion an answer to a contact problem has.
enum class Impulses {
  kUnstated,  ///< the solver does not tell
  kAny,       ///< those that its method reached
  kEven,      ///< those that equally stiff contacts would carry, see docs/reference/solvers/auto.md
};

/// "", "any", "even".
const char* to_string(Impulses impulses);

/// Work done by one solve; -1 where the solver does not tell.
struct Counters {
  std::int64_t iterations = -1;
  std::int64_t pivots = -1;
  std::int64_t factorizations = -1;

  bool operator==(const Counters&) const = default;
};

/// A vector that an answer may lack: it keeps its memory while it is empty.
class AnswerVector : public Vector {
 public:
  AnswerVector() = default;
  AnswerVector(const AnswerVector& other) : Vector(other) {}
  AnswerVector(AnswerVector&& other) = default;
  AnswerVector& operator=(const AnswerVector& other) { return *this = static_cast<const Vector&>(other); }
  AnswerVector& operator=(AnswerVector&& other) = default;
  template <class Values>
  AnswerVector& operator=(const Eigen::DenseBase<Values>& values) {
    resize(values.size());
    Vector::operator=(values.derived());
    return *this;
  }
  ~AnswerVector() = default;

  /// Allocates nothing where the vector had this length before, or it was reserved. The entries are undefined.
  void resize(Index size);
  /// Empties the vector and takes memory for `size` entries.
  void reserve(Index size);

  void swap(Vector& other) = delete;  // would leave memory_ behind

 private:
  Vector memory_;  // while the vector is empty
};

/// What a solver returns. It owns all memory that a solve writes to, so that it can be used again without allocating.
struct Answer {
  /// No solver of this project writes a longer `detail`.
  static constexpr std::size_t kLongestDetail = 240;

  Claim claim = Claim::kNumericalFailure;
  AnswerVector z;         ///< size(problem) entries, or empty when the solver has nothing to show
  AnswerVector velocity;  ///< ngc entries when the solver returns v+ itself, else empty
  AnswerVector farkas;  ///< of kUnsolvable a proof (core/answer/farkas.h); of a failure one but for rounding, or empty
  Counters counters;
  Impulses impulses = Impulses::kUnstated;
  std::string detail;  ///< one line, foreign status codes spelled out; may be empty

  /// Empties everything and takes the memory for any answer to a problem of these dimensions. Solver::solve() does so.
  void reserve(const Problem& problem);
  /// Empties everything and keeps the memory.
  void clear();
};

/// The input that a solver takes. The earlier forms can be derived from each later one.
enum class Needs { kDense, kFactored, kScene };

/// "dense", "factored", "scene".
const char* to_string(Needs needs);

/// Hard needs (a problem outside them is refused with a reason) and recorded properties.
struct Capabilities {
  Needs needs = Needs::kDense;
  /// Needs a symmetric positive semidefinite M: refuses friction and an asymmetric M, does not test definiteness.
  bool frictionless_only = false;
  /// "key=value" with which a `frictionless_only` solver takes friction too, by the round cone; "": there is none.
  const char* friction_setting = "";
  Index max_size = std::numeric_limits<Index>::max();  ///< largest n
  Index max_entries = 0;          ///< of hard contacts: a larger n, if their matrices hold no more numbers
  bool compliance = false;        ///< takes soft contacts as they are; others get their rigid equivalent
  bool boxed = false;             ///< takes mixed LCPs as they are; others get their reduction to z >= 0
  bool rows = false;              ///< takes bounded rows as they are; others get contacts, or a mixed LCP, in their place
  bool captured_only = false;     ///< needs the impulses of the engine that the problem was captured from
  const char* guarantees = "";    ///< class on which an answer is guaranteed in exact arithmetic, in words
  bool warm_start = false;        ///< SolveRequest::start is used
  bool obeys_time_limit = false;  ///< returns kTimeLimit by itself
  /// solve() allocates nothing after load(), given an answer with memory and a problem without bounded rows
  bool allocation_free = false;
};

struct SolveRequest {
  /// n: a guess at z (the last step's answer); ignored without `warm_start`, and of a mixed LCP without `boxed`
  const Vector* start = nullptr;
  double time_limit_s = std::numeric_limits<double>::infinity();  ///< wall clock
};

/// A solver of contact problems or LCPs. One object per thread; objects share nothing.
///
/// Life: load(problem), then solve() as often as wished; between time steps update(v) with the same contacts, or
/// update(problem) with others.
class Solver {
 public:
  virtual ~Solver() = default;
  Solver() = default;
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  /// Takes the problem in and sizes the workspace; everything that depends on the matrix alone happens here. Timed as
  /// set-up. A problem that is refused (see why_not) is remembered: solve() then answers kUnsupported.
  void load(const Problem& problem);

  /// load() of a problem that is, or is a part of, one that another solver has taken in: that its numbers are finite is
  /// known.
  void load_finite(const Problem& problem);

  /// Same contacts, offsets and inertia, another velocity v (ngc).
  /// The default reloads the whole problem; solvers that can do better override on_update.
  /// @pre a contact problem is loaded. @throws std::invalid_argument otherwise, or when v has another length.
  void update(const Vector& v);

  /// The contacts of the next time step, with other N, D, G or another number of them. What is loaded then is what
  /// load(problem) would load, and a solve() is as right; it may be faster where SolveRequest::start is the last
  /// answer, brought to these contacts by matched_start() of core/warm_start.h. The default loads the problem; solvers
  /// that can do better override on_change.
  void update(const Problem& problem);

  /// Solves what is loaded. Numerical trouble is a claim; exceptions are defects or lack of memory.
  /// `answer` is overwritten. Its memory is reused: a solver that is `allocation_free` allocates nothing when the
  /// answer was reserved for the problem, or served a problem of the same dimensions before.
  void solve(const SolveRequest& request, Answer& answer);

  virtual const Capabilities& capabilities() const = 0;

  /// From now on a claim of kUnsolvable whose `farkas` does not prove it exactly becomes a failure. The vector stays: the
  /// problem has hardly a solution, which `certify` settles.
  void require_proofs() { requires_proofs_ = true; }

 protected:
  virtual void on_load(const Problem& problem) = 0;
  virtual void on_update(const Vector& v);
  virtual void on_change(const Problem& problem) { on_load(problem); }
  /// `answer` arrives cleared: claim kNumericalFailure, counters -1, `z` of the right size and zero, the rest empty.
  virtual void on_solve(const SolveRequest& request, Answer& answer) = 0;
  const Problem& problem() const { return problem_; }

 private:
  void take(const Problem& problem, bool is_finite);
  void take_without_rows(const Problem& problem, bool is_finite);
  void return_to_given(Answer& answer);
  void return_to_rows(Answer& answer);
  void return_to_mixed(Answer& answer) const;
  void withdraw_unproven(Answer& answer) const;

  Problem problem_;  ///< what this solver sees of the one that was given
  Problem given_;    ///< the one that was given, where problem_ is its rigid equivalent or its reduction
  bool is_equivalent_ = false;
  bool requires_proofs_ = false;
  Vector v_;                                       ///< of contacts, the velocity before the impact now
  std::shared_ptr<const LcpReduction> reduction_;  ///< of a mixed LCP
  bool has_rows_ = false;  ///< with_rows_ is the problem that was given
  Problem with_rows_;
  std::shared_ptr<const ContactsOfRows> contacts_of_rows_;  ///< in their place; nullptr: a mixed LCP is
  AnswerVector other_velocity_;  ///< room for the velocity of problem_ or given_, whichever the answer does not hold
  std::string refusal_ = "nothing was loaded";
};

/// Why a solver with these capabilities refuses the problem, in one clause; "" when it does not.
/// NaN and infinite data are always refused.
std::string why_not(const Capabilities& capabilities, const Problem& problem);

/// A fresh copy of (q, M), with bounds if it is mixed, formed from the factors if there are any. Solvers on matrices
/// call it in on_load, so that their set-up time always contains the forming of M.
Lcp make_lcp(const Problem& problem);

}  // namespace lcpbench
