#pragma once

#include <cstddef>
#include <exception>
#include <memory>
#include <system_error>
#include <thread>
#include <vector>

#include "core/islands.h"
#include "native/auto/attempts.h"
#include "native/auto/island_solver.h"
#include "native/auto/islands.h"
#include "native/auto/report.h"
#include "native/auto/settings.h"

namespace lcpbench {

/// Calls work(lane) for each lane and waits: for the first one on this thread, for each other on a thread of its own,
/// or on this one where the system gives no thread. Then throws what the first lane that failed has thrown. Makes no
/// thread and allocates nothing for one lane.
template <class Work>
void run_lanes(std::size_t lanes, const Work& work) {
  if (lanes <= 1) return lanes == 1 ? work(std::size_t{0}) : void();
  std::vector<std::exception_ptr> failures(lanes);
  const auto guarded = [&](std::size_t lane) noexcept {
    try {
      work(lane);
    } catch (...) {
      failures[lane] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads;  // joined at the end of the block
    threads.reserve(lanes - 1);
    for (std::size_t lane = 1; lane < lanes; ++lane) {
      try {
        threads.emplace_back(guarded, lane);
      } catch (const std::system_error&) {
        guarded(lane);
      }
    }
    guarded(0);
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure != nullptr) std::rethrow_exception(failure);
  }
}

/// The islands of a problem, dealt out to lanes that share nothing they write to: each has its methods, its scratch
/// memory and its copy of the velocity. What is computed of an island depends on no other one, so that the answer is
/// the same bit for bit for any number of lanes.
class IslandLanes {
 public:
  /// @param shared of the first lane; may be in use between the calls
  IslandLanes(const AutoSettings& settings, SharedMethods& shared) : settings_(settings), shared_(shared) {}

  /// Objects that have served another problem are used again. Makes no threads where all islands put off their work to
  /// solve(). @param v velocity of the whole problem
  /// @param to_hold see Attempts::load_to_hold
  void load(const Problem& problem, std::vector<Island> islands, const Vector& v, bool to_hold);
  void update(const Vector& v);

  /// Solves all islands, or up to the first that is not solved, and adds their impulses to z. A limit on pivots has
  /// the islands solved one after the other on this thread: each gets what those before it have left.
  /// @param v velocity of the whole problem @param start, limits as of IslandSolver::solve
  /// @returns kSolved, or the claim of failed()
  Claim solve(const Vector& v, const Vector* start, const AutoLimits& limits, Vector& z, AutoReport& report);

  std::size_t count() const { return islands_.size(); }
  /// Of the last solve: the first island that was not solved.
  const IslandSolver& failed() const { return *islands_[failed_]; }
  /// The velocity, if all islands were solved.
  const Vector& velocity() const { return lanes_.front()->u; }
  bool all_gave_velocity() const;
  /// Whether an answer includes the lambda of this contact.
  bool carries(std::size_t contact) const { return carries_[contact] != 0; }
  const ContactLayout& layout() const { return lanes_.front()->cutter->layout(); }

 private:
  struct Lane {
    explicit Lane(SharedMethods* given);
    IslandSolver& island(std::size_t k, const AutoSettings& settings);

    std::unique_ptr<SharedMethods> own;  ///< of all but the first lane
    SharedMethods& shared;
    std::unique_ptr<ProblemCutter> cutter;
    std::vector<std::unique_ptr<IslandSolver>> solvers;  ///< kept for the next problem
    std::vector<std::size_t> islands;                    ///< numbers of the islands, ascending
    Vector u;
  };
  struct Result {
    Claim claim = Claim::kSolved;
    AutoReport report;
  };

  void deal_out(const std::vector<Island>& islands);
  Claim solve_one_by_one(const Vector* start, const AutoLimits& limits, Vector& z, AutoReport& report);
  Claim solve_side_by_side(const Vector* start, const AutoLimits& limits, Vector& z, AutoReport& report);
  void gather_velocity();

  const AutoSettings& settings_;
  SharedMethods& shared_;
  std::vector<std::unique_ptr<Lane>> lanes_;  ///< kept for the next problem
  std::size_t used_ = 1;                      ///< lanes of this one
  std::vector<IslandSolver*> islands_;        ///< in the order of the problem
  std::vector<Lane*> lane_of_;                ///< of each
  std::vector<Result> results_;               ///< of each, with several lanes
  std::vector<char> carries_;                 ///< per contact: its lambda is in its island's answer
  std::size_t failed_ = 0;
};

}  // namespace lcpbench
