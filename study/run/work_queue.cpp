#include "study/run/work_queue.h"

#include <algorithm>
#include <utility>

namespace lcpbench {
namespace {

bool has_answers(Store& store) { return store.database().integer("SELECT EXISTS (SELECT 1 FROM answers)") != 0; }

}  // namespace

PlanWalk::PlanWalk(const Study& study, Store& store, std::int64_t shard, std::int64_t shards)
    : study_(study),
      store_(store),
      deal_(deal_problems(study, shards)),
      shard_(shard),
      shards_(shards),
      resuming_(has_answers(store)),
      is_done_(study.solvers.size()) {
  for (std::size_t i = 0; i < study.solvers.size(); ++i) {
    solver_of_.emplace(study.solvers[i].row.id(), static_cast<std::uint32_t>(i));
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
    of_trial->first = (of_trial->first + 1) % shards_;
    if (!mine) continue;
    heads_.push({(static_cast<double>(trial) + 0.5) / static_cast<double>(trials), set, trial});
    return;
  }
}

std::int64_t PlanWalk::look_up(std::size_t set, std::int64_t trial) {
  std::fill(is_done_.begin(), is_done_.end(), false);
  std::int64_t cells = 0;
  if (!resuming_) return cells;
  for (const std::int64_t id : store_.done(problem_id(sets_[set].name, study_.seed, trial))) {
    const auto known = solver_of_.find(id);
    if (known == solver_of_.end() || !study_.solvers[known->second].takes(set, trial)) continue;
    is_done_[known->second] = true;
    cells += study_.solvers[known->second].cell_count();
  }
  return cells;
}

std::optional<Task> PlanWalk::step() {
  const Head head = heads_.top();
  heads_.pop();
  push_next(head.set);
  const std::int64_t done = look_up(head.set, head.trial);
  already_done_ += done;
  Task task{head.set, head.trial, {}};
  bool complete = true;
  for (std::uint32_t i = 0; i < study_.solvers.size(); ++i) {
    if (is_done_[i] || !study_.solvers[i].takes(head.set, head.trial)) continue;
    complete = false;
    if (done > 0) task.solvers.push_back(i);
  }
  return complete ? std::nullopt : std::optional(std::move(task));
}

void TaskQueue::push(Task task) {
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  tasks_.push_back(std::move(task));
  changed_.notify_one();
}

std::optional<Task> TaskQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return ended_ || !tasks_.empty(); });
  if (tasks_.empty()) return std::nullopt;
  std::optional<Task> task = std::move(tasks_.front());
  tasks_.pop_front();
  return task;
}

void TaskQueue::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

void TaskQueue::close() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  tasks_.clear();
  changed_.notify_all();
}

std::size_t TaskQueue::size() {
  const std::lock_guard lock(mutex_);
  return tasks_.size();
}

}  // namespace lcpbench
