#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// A method in a race, and what it is predicted to take, in work that is weighted alike for all: about nanoseconds.
struct Entrant {
  double cost = 0;       ///< to its end, load included
  double load_cost = 0;  ///< of its load, which cannot be stopped
  double weight = 1;     ///< of a unit of ResumableSolver::work()
  bool learns = false;   ///< it starts from the best iterate of the others
};

/// The methods of a race: solvers that hold the problem.
class Stable {
 public:
  virtual ~Stable() = default;
  Stable() = default;
  Stable(const Stable&) = delete;
  Stable& operator=(const Stable&) = delete;

  /// The entrant's solver with the problem loaded.
  virtual ResumableSolver& loaded(std::size_t entrant) = 0;
};

/// Lets several methods take turns at one problem until one of them has an answer. Nothing that a method has done is
/// lost when the next one gets its turn, and work, not time, ends a turn: the same data give the same answer.
///
/// The entrants run in the order of their predicted cost. In round r = 0, 1, 2, ... an entrant goes on until it has
/// done kFirstShare 2^r times its budget, which is its predicted cost, but at most kLargestBudget times the least of
/// all, and no turn is shorter than kLeastTurn. An entrant whose load alone would take more waits for a later round.
///
/// Bound. Let B_k be the budgets of M entrants, and let entrant b need the work w, load included. It ends in the first
/// round with kFirstShare 2^r B_b >= w. No entrant has done more than kFirstShare 2^r B_k then, and if r > 0,
/// kFirstShare 2^r B_b < 2 w. So all together have done at most 2 w (B_1 + ... + B_M) / B_b, where no budget is more
/// than kLargestBudget times another: at most 2 (1 + kLargestBudget (M - 1)) w, whatever was predicted. If r = 0, b
/// needed less than predicted, and w is to be read as kFirstShare B_b. A budget of less than kLeastTurn counts as
/// that much, which adds at most M kLeastTurn.
class Race {
 public:
  static constexpr std::size_t kMostEntrants = 4;
  static constexpr double kFirstShare = 2;
  static constexpr double kLargestBudget = 2;
  /// A shorter turn costs more to end than to go on: the next method would have to be loaded.
  static constexpr double kLeastTurn = 10'000;
  /// Once an iterate passes what the verdict allows, the race for a better one may take so many times the work that was
  /// done until then.
  static constexpr double kPatience = 32;

  struct Terms {
    Index size = 0;                 ///< entries of z
    const Vector* start = nullptr;  ///< a guess at z
    double error = 0;               ///< see ResumableSolver::begin
    double accepted = 0;            ///< residual of an iterate that is an answer, if nothing better is found
    bool ends_early = false;        ///< such an iterate ends the race after kPatience times the work until then
    double deadline_s = std::numeric_limits<double>::infinity();  ///< on wall_clock_s()
  };

  /// How a race ended: an entrant claims an answer, or a proof that there is none; all have given up; an iterate is
  /// good enough; the deadline.
  enum class End { kClaimed, kAllGaveUp, kGoodEnough, kTimeLimit };

  /// @param entrants at most kMostEntrants @param answer of winner(), as it wrote it, if that claims something
  End run(std::span<const Entrant> entrants, Stable& stable, const Terms& terms, Answer& answer);

  /// Which entrant gave the answer of kClaimed, or else best().
  std::size_t winner() const { return winner_; }
  /// The iterate of the least residual, if no answer is claimed, and that residual; infinity: there is none.
  const Vector& best() const { return best_; }
  double best_residual() const { return best_residual_; }
  /// Of all entrants, weighted.
  double work() const;
  /// Whether the entrant was given a turn.
  bool has_run(std::size_t entrant) const { return runs_[entrant].solver != nullptr; }

 private:
  struct Run {
    ResumableSolver* solver = nullptr;
    double work = 0;  ///< weighted
    bool has_ended = false;
  };

  void note_best(std::size_t entrant, Index size);
  bool turn(std::size_t entrant, Stable& stable, const Entrant& now, double budget, const Terms& terms, Answer& answer);

  std::array<Run, kMostEntrants> runs_;
  std::size_t winner_ = 0;
  Vector iterate_, best_, start_;
  double best_residual_ = 0;
  double accepted_at_ = 0;  ///< work that was done when an iterate was first accepted
};

}  // namespace lcpbench
