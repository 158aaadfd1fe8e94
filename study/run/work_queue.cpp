#include "study/run/work_queue.h"

#include <algorithm>
#include <utility>

namespace lcpbench {

PlanWalk::PlanWalk(const Study& study, Store& store, std::int64_t shard, std::int64_t shards)
    : study_(study),
      deal_(deal_problems(study, shards)),
      shard_(shard),
      shards_(shards) {
  const bool has_answers = store.database().integer("SELECT EXISTS (SELECT 1 FROM answers)") != 0;
  if (has_answers) done_.emplace(Store::open_for_reading(store.file()));
  for (std::size_t i = 0; i < study.solvers.size(); ++i) {
    solver_of_.emplace(study.solvers[i].row.id(), i);
  }
  for (std::size_t set = 0; set < study.sets.size(); ++set) {
    sets_.push_back({study.sets[set].set->name(), 0});
    for (const DealtClass& each : deal_[set]) {
      for (const StudySolver& solver : study.solvers) {
        if (solver.takes(set, each.trial)) planned_ += solver.cell_count() * each.dealt_to(shard, shards);
      }
    }
    push_next(set);
  }
}

void PlanWalk::push_next(std::size_t set) {
  const std::int64_t trials = study_.sets[set].trials;
  while (sets_[set].next < trials) {
    const std::int64_t trial = sets_[set].next++;
    const auto of_trial = std::find_if(deal_[set].begin(), deal_[set].end(),
                                       [trial](const DealtClass& each) { return trial % each.multiple == 0; });
    if (of_trial == deal_[set].end()) continue;
    const bool mine = of_trial->first == shard_;
    if (!of_trial->whole) of_trial->first = (of_trial->first + 1) % shards_;
    if (!mine) continue;
    const StudySet& of = study_.sets[set];
    while (of.in_order && sets_[set].next < trials && of.set->follows(sets_[set].next)) ++sets_[set].next;
    const std::int64_t count = of.in_order ? sets_[set].next - trial : 1;
    heads_.push({(static_cast<double>(trial) + 0.5) / static_cast<double>(trials), set, trial, count});
    return;
  }
}

std::vector<std::int64_t> PlanWalk::answered(const Head& head) {
  std::vector<std::int64_t> done(study_.solvers.size());
  if (!done_) return done;
  for (std::int64_t trial = head.trial; trial < head.trial + head.count; ++trial) {
    for (const std::int64_t id : done_->done(problem_id(sets_[head.set].name, study_.seed, trial))) {
      const auto known = solver_of_.find(id);
      if (known != solver_of_.end() && study_.solvers[known->second].takes(head.set, trial)) ++done[known->second];
    }
  }
  return done;
}

std::int64_t PlanWalk::taken(std::size_t solver, const Head& head) const {
  std::int64_t count = 0;
  for (std::int64_t trial = head.trial; trial < head.trial + head.count; ++trial) {
    if (study_.solvers[solver].takes(head.set, trial)) ++count;
  }
  return count;
}

std::optional<Task> PlanWalk::next(const std::function<bool()>& closed) {
  while (!closed()) {
    const std::lock_guard lock(mutex_);
    ended_ = heads_.empty();
    if (ended_) break;
    if (std::optional<Task> task = step()) return task;
  }
  return std::nullopt;
}

std::optional<Task> PlanWalk::step() {
  const Head head = heads_.top();
  heads_.pop();
  push_next(head.set);
  const std::vector<std::int64_t> done = answered(head);
  Task task{head.set, head.trial, head.count, {}};
  for (std::size_t i = 0; i < done.size(); ++i) {
    const std::int64_t all = taken(i, head);
    if (done[i] < all) {
      task.solvers.push_back(i);
    } else {
      already_done_ += all * study_.solvers[i].cell_count();
    }
  }
  return task.solvers.empty() ? std::nullopt : std::optional(std::move(task));
}

}  // namespace lcpbench
