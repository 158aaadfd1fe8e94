#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "native/contacts/resumable_solver.h"

namespace lcpbench {

/// A method in a race, and what it is predicted to take, in work that is weighted alike for all: about nanoseconds.
struct Entrant {
  double cost = 0;         ///< to its end, load included: the median
  double shape = 1;        ///< of the distribution of the cost: the larger, the more certain
  double load_cost = 0;    ///< of its load, which cannot be stopped
  double least_cost = 0;   ///< it cannot end with less; its load counts in any case
  double weight = 1;       ///< of a unit of ResumableSolver::work()
  bool converges = false;  ///< its residual tells how far it has come
  bool falls_late = false;  ///< its residual counts only where it promises less work than the prediction
  bool learns = false;     ///< without a start it begins from the best iterate of the others; one at most does
  bool is_reserve = false;  ///< it enters once the entrant before it, which converges, stalls or gives up
};

/// The methods of a race: solvers that hold the problem.
class Stable {
 public:
  virtual ~Stable() = default;
  Stable() = default;
  Stable(const Stable&) = delete;
  Stable& operator=(const Stable&) = delete;

  /// The one that may have a head start: its load and weight alone count.
  virtual Entrant first() = 0;
  /// All, that one at the first place; at most Race::kMostEntrants. Asked for once, and only after the head start.
  virtual std::span<const Entrant> entrants() = 0;
  /// The entrant's solver with the problem loaded.
  virtual ResumableSolver& loaded(std::size_t entrant) = 0;
  /// Whether an iterate at the aim, which no entrant claims, is an answer, or leads to a proof that there is none.
  /// Writes that.
  virtual bool passes(const Vector& best, Answer& answer) = 0;
  /// Whether a proof is found that there is no answer. Writes that.
  virtual bool disproves(Answer& /*answer*/) { return false; }
};

/// Lets several methods take turns at one problem until one of them has an answer. In its next turn a method goes on
/// where its last one ended. Work, not time, ends a turn: the same data give the same answer, unless the deadline ends
/// the race.
///
/// 1. If the load of the first entrant costs at most kHeadStart, it begins, and does that much with its load.
/// 2. Then the entrant has the next turn whose index is the largest. What an entrant takes in all is not known. It has a
///    log-logistic distribution: the probability that it takes more than t is 1 / (1 + (t / m)^shape). The index of an
///    entrant that has done w (at least kLeastTurn) is
///
///        the probability that it ends by t, as it has not ended by w,
///        over the work that is to be expected until then, with the load if it has not begun, [Gittins 1979]
///
///    for t = kStretch w or, if its shape is at least kCertain, kHorizon m, whichever gives more. Its turn ends at t.
///    Median m and shape are at first what was predicted. After a turn of an entrant that converges, and has come to a
///    residual r, m is w (r / aim)^kSlowness times w over the work when r last fell: what it took so far, and twice that
///    if r is 32 times the aim; kStalled w if r was at the aim before this turn and it still claims nothing. The shape
///    is then kShapeByResidual. A prediction with a larger shape stays until w is twice the predicted work. Of an
///    entrant whose residual falls late, the prediction stays as long as it is at most m, and its shape until w is twice
///    the predicted work. Of the others that converge, turns after the first end at kLook times their work, because each
///    turn gives a new residual. While ResumableSolver::residual_tells() says no, m and the longer turns stay as
///    predicted; once w is twice the predicted work, the shape is at most kShapeByResidual.
/// 3. An entrant that has done more than kLead times the least that one still in the race has done, waits. Of one that
///    has not begun, the load counts as done; for the least, its least cost if that is more. No turn ends above 2 kLead
///    times the least.
/// An entrant stalls when its work is kStalled times what it was when its residual last fell. If it had learned, it
/// then begins anew from nothing. Else its reserve enters, as it does if the entrant gives up. An iterate at the aim
/// ends the race if it passes the test of an answer; if not, the next one is tested that has at most half its residual.
///
/// Bound. Of M entrants let b be the one that ends the race, and w its work with its load. It has not ended before, so
/// that the least work is at most w. By 3, no turn ends above 2 kLead w, and all together do at most
///
///     (1 + 2 kLead (M - 1)) w,
///
/// and beside it the head start, and for each entrant kLeastTurn, up to which every turn may go, and one indivisible
/// step. If b has learned, w is its work from that start, which may be more than from nothing. A reserve may be one of
/// the M, but not b: the others have done what they have when it enters.
class Race {
 public:
  static constexpr std::size_t kMostEntrants = 5;
  static constexpr double kHeadStart = 16'000;
  static constexpr double kLead = 9;
  static constexpr double kStretch = 4;
  static constexpr double kCertain = 2;
  static constexpr double kHorizon = 2;
  static constexpr double kLook = 1.5;
  static constexpr double kSlowness = 0.2;
  static constexpr double kStalled = 4;
  static constexpr double kShapeByResidual = 1.3;
  /// Every turn may go up to this work: to end it earlier would cost more, since the next method would be loaded.
  static constexpr double kLeastTurn = 10'000;
  /// Where Terms::ends_early, the race ends once all have done kPatience W (r / aim)^kSlowness, r the least residual,
  /// and W the work when it first was at most Terms::accepted.
  static constexpr double kPatience = 4;

  struct Terms {
    Index size = 0;                 ///< entries of z
    const Vector* start = nullptr;  ///< a guess at z
    double error = 0;               ///< see ResumableSolver::begin
    double aim = 1e-9;              ///< residual at which methods that converge end
    double accepted = 0;            ///< residual of an iterate that is an answer, if nothing better is found
    double proof_at = std::numeric_limits<double>::infinity();  ///< work() from which Stable::disproves() is asked, once
    bool ends_early = false;        ///< such an iterate ends the race some work later, see kPatience
    double deadline_s = std::numeric_limits<double>::infinity();  ///< on wall_clock_s()
  };

  /// How a race ended: not yet (run() never returns that); an entrant claims an answer, or a proof that there is none;
  /// all have given up; an iterate is good enough; the deadline.
  enum class End { kNone, kClaimed, kAllGaveUp, kGoodEnough, kTimeLimit };

  /// Memory for iterates of `size` entries. Without it run() allocates.
  void reserve(Index size) {
    iterate_.resize(size);
    best_.resize(size);
    start_.resize(size);
  }

  /// @param answer of winner(), as it wrote it, if that claims something
  End run(Stable& stable, const Terms& terms, Answer& answer);

  /// Which of them would have the first turn, without a head start. @pre there is one that is no reserve
  std::size_t first(std::span<const Entrant> entrants);

  /// Which entrant gave the answer of kClaimed, or else best().
  std::size_t winner() const { return winner_; }
  /// The iterate of the least residual, if no answer is claimed, and that residual; infinity: there is none.
  const Vector& best() const { return best_; }
  double best_residual() const { return best_residual_; }
  /// Weighted, of all entrants that have begun, their loads included.
  double work() const;
  /// Whether the entrant was given a turn.
  bool has_run(std::size_t entrant) const { return runs_[entrant].solver != nullptr; }
  /// Whether it was, and its solve has ended.
  bool has_ended(std::size_t entrant) const { return has_run(entrant) && runs_[entrant].has_ended; }

 private:
  struct Run {
    ResumableSolver* solver = nullptr;
    double work = 0;      ///< weighted, with the load
    double expected = 0;  ///< work to its end, the median
    double shape = 1;     ///< of its distribution
    double residual = 1;  ///< the least so far; that of z = 0
    double begun_at = 0;  ///< work when its solve began
    double noted_at = 0;  ///< work when the residual was found
    bool has_learned = false;
    bool has_ended = false;
  };

  End turn(std::size_t entrant, double work);
  void enter(std::size_t entrant, const Entrant& now);
  double note(std::size_t entrant);
  double slowness(double residual) const;
  void expect(std::size_t entrant, double residual);
  struct Turn {
    std::size_t entrant = kMostEntrants;  ///< that: all have ended
    double end = 0;                       ///< its work then
    double index = -std::numeric_limits<double>::infinity();
  };
  Turn best_turn(std::size_t entrant) const;
  Turn next() const;
  double level() const;  ///< the least work of those that have not ended

  std::array<Entrant, kMostEntrants> entrants_;
  std::size_t count_ = 0;
  Stable* stable_ = nullptr;
  Terms terms_;
  Answer* answer_ = nullptr;

  std::array<Run, kMostEntrants> runs_;
  std::size_t winner_ = 0;
  Vector iterate_, best_, start_;
  double best_residual_ = 0;
  double failed_residual_ = 0;  ///< of the last iterate that failed the test of an answer; infinity: none
  double accepted_at_ = 0;  ///< work that was done when an iterate was first accepted
  bool is_out_of_time_ = false;  ///< a load would have outlasted the deadline
};

}  // namespace lcpbench
