#include "native/auto/lanes.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

namespace lcpbench {
namespace {

/// What a solve of an island may cost, in proportion: contacts times coordinates.
std::size_t weight(const Island& island) { return island.contacts.size() * island.coordinates.size(); }

/// The weight from which a further lane is worth its thread: one takes 50 to 150 us, this 100 to 300.
constexpr std::size_t kWeightPerLane = 500;

}  // namespace

IslandLanes::Lane::Lane(SharedMethods* given)
    : own(given == nullptr ? std::make_unique<SharedMethods>() : nullptr), shared(given == nullptr ? *own : *given) {}

IslandSolver& IslandLanes::Lane::island(std::size_t k, const AutoSettings& settings) {
  while (solvers.size() <= k) solvers.push_back(std::make_unique<IslandSolver>(settings, shared));
  return *solvers[k];
}

void IslandLanes::load(const Problem& problem, std::vector<Island> islands, const Vector& v, bool to_hold) {
  deal_out(islands);
  carries_.assign(problem.contact()->edges.size(), 0);
  islands_.assign(islands.size(), nullptr);
  lane_of_.assign(islands.size(), nullptr);
  results_.assign(used_ > 1 ? islands.size() : 0, {});
  const bool take_turns = std::all_of(islands.begin(), islands.end(), IslandSolver::may_take_turns);
  const auto load_lane = [&](std::size_t number) {
    Lane& lane = *lanes_[number];
    lane.cutter = std::make_unique<ProblemCutter>(problem);
    lane.u.resize(v.size());
    for (std::size_t place = 0; place < lane.islands.size(); ++place) {
      const std::size_t k = lane.islands[place];
      lane_of_[k] = &lane;
      islands_[k] = &lane.island(place, settings_);
      islands_[k]->load(*lane.cutter, std::move(islands[k]), v, carries_, islands.size() > 1, to_hold);
    }
  };
  if (!take_turns) return run_lanes(used_, load_lane);
  for (std::size_t number = 0; number < used_; ++number) load_lane(number);
}

/// The heaviest first, each to the lane that has least.
void IslandLanes::deal_out(const std::vector<Island>& islands) {
  std::size_t total = 0;
  for (const Island& island : islands) total += weight(island);
  const std::size_t most = std::min(static_cast<std::size_t>(settings_.threads), islands.size());
  used_ = std::clamp<std::size_t>(total / kWeightPerLane, 1, std::max<std::size_t>(most, 1));
  while (lanes_.size() < used_) {
    lanes_.push_back(std::make_unique<Lane>(lanes_.empty() ? &shared_ : nullptr));
  }
  for (const std::unique_ptr<Lane>& lane : lanes_) lane->islands.clear();
  std::vector<std::size_t> order(islands.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (used_ > 1) {
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return weight(islands[a]) > weight(islands[b]); });
  }
  std::vector<std::size_t> load(used_, 0);
  for (const std::size_t k : order) {
    const auto lightest = std::min_element(load.begin(), load.end());
    *lightest += weight(islands[k]);
    lanes_[static_cast<std::size_t>(lightest - load.begin())]->islands.push_back(k);
  }
  for (const std::unique_ptr<Lane>& lane : lanes_) std::sort(lane->islands.begin(), lane->islands.end());
}

void IslandLanes::update(const Vector& v) {
  for (IslandSolver* island : islands_) island->update(v);
}

Claim IslandLanes::solve(const Vector& v, const Vector* start, const AutoLimits& limits, Vector& z,
                         AutoReport& report) {
  for (std::size_t number = 0; number < used_; ++number) lanes_[number]->u = v;
  const bool in_order = used_ == 1 || limits.max_pivots > 0;
  const Claim claim =
      in_order ? solve_one_by_one(start, limits, z, report) : solve_side_by_side(start, limits, z, report);
  gather_velocity();
  return claim;
}

Claim IslandLanes::solve_one_by_one(const Vector* start, const AutoLimits& limits, Vector& z, AutoReport& report) {
  for (failed_ = 0; failed_ < islands_.size(); ++failed_) {
    const Claim claim = islands_[failed_]->solve(start, limits, z, lane_of_[failed_]->u, report);
    if (claim != Claim::kSolved) return claim;
  }
  return Claim::kSolved;
}

/// Solves no island after one that is known to have failed, and counts in only what one by one would have.
Claim IslandLanes::solve_side_by_side(const Vector* start, const AutoLimits& limits, Vector& z, AutoReport& report) {
  std::atomic<std::size_t> first_failed = islands_.size();
  run_lanes(used_, [&](std::size_t number) {
    Lane& lane = *lanes_[number];
    for (const std::size_t k : lane.islands) {
      if (k > first_failed.load()) return;
      Result& result = results_[k];
      result.report = {};
      result.claim = islands_[k]->solve(start, limits, z, lane.u, result.report);
      if (result.claim == Claim::kSolved) continue;
      std::size_t known = first_failed.load();
      while (k < known && !first_failed.compare_exchange_weak(known, k)) {
      }
    }
  });
  failed_ = first_failed.load();
  const bool has_failed = failed_ < islands_.size();
  for (std::size_t k = 0; k < failed_ + (has_failed ? 1 : 0); ++k) report.add(results_[k].report);
  return has_failed ? results_[failed_].claim : Claim::kSolved;
}

void IslandLanes::gather_velocity() {
  Vector& u = lanes_.front()->u;
  for (std::size_t number = 1; number < used_; ++number) {
    const Lane& lane = *lanes_[number];
    for (const std::size_t k : lane.islands) {
      for (const Index i : islands_[k]->coordinates()) u(i) = lane.u(i);
    }
  }
}

bool IslandLanes::all_gave_velocity() const {
  return std::all_of(islands_.begin(), islands_.end(), [](const IslandSolver* each) { return each->gave_velocity(); });
}

}  // namespace lcpbench
