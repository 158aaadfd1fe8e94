#include "study/run/runner.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <exception>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "study/certificates/settle.h"
#include "study/run/one_by_one.h"
#include "study/run/result_exchange.h"
#include "study/store/vector_codec.h"
#include "study/run/work_queue.h"

namespace lcpbench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kHandOverAfter =
    std::chrono::milliseconds(500);  // what a kill can lose, but for the solve or sweep in flight
constexpr auto kProgressEvery = std::chrono::milliseconds(100);
constexpr std::size_t kCommitAnswers = 20'000;
/// The queue is filled up to this when it holds less than half: more than the threads take while the writer is busy, as
/// they wait for it after 256 results.
constexpr std::size_t kTasksAhead = 2048;
/// Problems looked up in the store before the results that have arrived are written.
constexpr int kLookedUpAtOnce = 1000;
constexpr double kFirstPartialS = 8.0;  // well inside the twenty seconds in which a user wants to see a first row
constexpr double kPartialGrowth = 3.0;  // ever rarer: each one reads the whole store

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Batch {
  std::size_t set = 0;
  ProblemResult result;
  std::optional<CertificateRow> certificate;  ///< found because an answer denied a solution
};

using Exchange = ResultExchange<Batch>;

/// Verifies the answers to one problem, equal ones once, and settles what one of them denies without a proof.
class ProblemJudge {
 public:
  ProblemJudge(const Problem& problem, Batch& batch, Settler& settler)
      : problem_(problem),
        evaluator_(problem),
        theory_(evaluator_.truth()),
        result_(batch.result),
        certificate_(batch.certificate),
        settler_(settler) {}

  Truth theory() const { return theory_; }

  AnswerRow judge(std::int64_t solver_id, const TimedAnswer& timed) {
    const Answer& answer = timed.answer;
    AnswerRow row;
    row.solver_id = solver_id;
    row.claim = answer.claim;
    row.counters = answer.counters;
    row.detail = answer.detail;
    row.times = timed.times;
    const Judged& judged = judged_like(answer);
    row.z = judged.z;
    row.velocity = judged.velocity;
    row.farkas = judged.farkas;
    row.errors = judged.errors;
    row.farkas_checked = judged.farkas_checked;
    row.verify_s = judged.verify_s;
    if (theory_ == Truth::kUnknown && Settler::asked_by(row.claim, row.farkas_checked)) settle();
    return row;
  }

 private:
  struct Judged {
    Vector z_bits, velocity_bits, farkas_bits;
    std::optional<std::int64_t> z, velocity, farkas;
    Errors errors;
    bool farkas_checked = false;
    double verify_s = 0;
  };

  void settle() {
    if (!settled_) certificate_ = settler_.settle_row(problem_);
    settled_ = true;
  }

  const Judged& judged_like(const Answer& answer) {
    for (const Judged& known : judged_) {
      if (same_bits(known.z_bits, answer.z) && same_bits(known.velocity_bits, answer.velocity) &&
          same_bits(known.farkas_bits, answer.farkas)) {
        return known;
      }
    }
    Judged& judged = judged_.emplace_back();
    judged.z_bits = answer.z;
    judged.velocity_bits = answer.velocity;
    judged.farkas_bits = answer.farkas;
    judged.z = keep(answer.z);
    judged.velocity = keep(answer.velocity);
    judged.farkas = keep(answer.farkas);
    const double start = thread_cpu_clock_s();
    judged.errors = evaluator_.errors(answer);
    judged.farkas_checked = answer.farkas.size() > 0 && evaluator_.check_farkas(answer.farkas);
    judged.verify_s = thread_cpu_clock_s() - start;
    return judged;
  }

  std::optional<std::int64_t> keep(const Vector& vector) {
    if (vector.size() == 0) return std::nullopt;
    std::string bytes = encode_vector(vector);
    const std::int64_t id = content_id(bytes);
    result_.vectors.emplace_back(id, std::move(bytes));
    return id;
  }

  const Problem& problem_;
  Evaluator evaluator_;
  Truth theory_;
  ProblemResult& result_;
  std::optional<CertificateRow>& certificate_;
  Settler& settler_;
  bool settled_ = false;
  std::deque<Judged> judged_;
};

ProblemRow problem_row(const std::string& set_name, std::uint64_t seed, std::int64_t trial, const Problem& problem,
                       Truth theory) {
  ProblemRow row;
  row.id = problem_id(set_name, seed, trial);
  row.set_id = set_id(set_name);
  row.seed = seed;
  row.trial = trial;
  row.kind = to_string(problem.kind());
  row.n = problem.size();
  if (const ContactProblem* contact = problem.contact()) {
    row.ngc = contact->ngc();
    row.nc = contact->nc();
  }
  row.hash = problem_hash(problem);
  row.theory = theory == Truth::kSolvable ? "solvable" : "";
  return row;
}

/// A cell that is left out or answered twice would be a row lost, or counted twice, in silence.
void check_complete(const std::vector<SweptAnswer>& answers, const StudySolver& solver) {
  bool complete = true;
  std::vector<std::uint32_t> answered;
  for (const SweptAnswer& answer : answers) {
    complete = complete && !answer.cells.empty() && std::is_sorted(answer.cells.begin(), answer.cells.end());
    answered.insert(answered.end(), answer.cells.begin(), answer.cells.end());
  }
  std::sort(answered.begin(), answered.end());
  std::vector<std::uint32_t> all(solver.cells.size());
  std::iota(all.begin(), all.end(), 0U);
  if (complete && answered == all) return;
  throw std::logic_error(
      fmt::format("the sweep {} of {} answered not every cell once", solver.row.sweep, solver.row.text()));
}

/// One thread's solvers and its loop over the queue.
class Worker {
 public:
  Worker(const Study& study, TaskQueue& tasks, Exchange& exchange)
      : study_(study),
        tasks_(tasks),
        exchange_(exchange),
        solvers_(study.solvers.size()),
        sweeps_(study.solvers.size()) {
    for (const StudySolver& solver : study.solvers) ids_.push_back(solver.row.id());
  }

  void run() {
    while (!exchange_.queue_closed()) {
      const std::optional<Task> task = tasks_.pop();
      if (!task) break;
      run_task(*task);
    }
  }

 private:
  void run_task(const Task& task) {
    const ProblemSet& set = *study_.sets[task.set].set;
    const Problem problem = set.generate(study_.seed, task.trial);
    Batch batch{task.set, {}, {}};
    ProblemJudge judge(problem, batch, settler_);
    batch.result.problem = problem_row(set.name(), study_.seed, task.trial, problem, judge.theory());
    Clock::time_point handed_over = Clock::now();
    for (const std::size_t solver : order(task)) {
      if (exchange_.stopped()) break;
      solve(problem, solver, judge, batch.result.answers);
      if (Clock::now() - handed_over < kHandOverAfter) continue;
      exchange_.push(batch);
      batch.result.vectors.clear();
      batch.result.answers.clear();
      batch.certificate.reset();
      handed_over = Clock::now();
    }
    if (!batch.result.answers.empty()) exchange_.push(std::move(batch));
  }

  std::vector<std::size_t> order(const Task& task) const {
    std::vector<std::size_t> solvers(task.solvers.begin(), task.solvers.end());
    if (task.solvers.empty()) {
      for (std::size_t i = 0; i < study_.solvers.size(); ++i) {
        if (study_.solvers[i].takes(task.set, task.trial)) solvers.push_back(i);
      }
    }
    const auto turn = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(task.trial) % solvers.size());
    std::rotate(solvers.begin(), solvers.begin() + turn, solvers.end());
    return solvers;
  }

  /// Runs one solver, or one whole sweep, and appends what it answered.
  void solve(const Problem& problem, std::size_t solver, ProblemJudge& judge, std::vector<AnswerRow>& rows) {
    const StudySolver& planned = study_.solvers[solver];
    TimedRequest request;
    request.time_limit_s = study_.time_limit_s;
    if (planned.swept()) {
      if (sweeps_[solver] == nullptr) sweeps_[solver] = planned.open_swept();
      sweeps_[solver]->run(problem, request, swept_);
      check_complete(swept_, planned);
      for (SweptAnswer& answer : swept_) {
        rows.push_back(judge.judge(ids_[solver], answer.timed));
        rows.back().cells = std::move(answer.cells);
      }
      return;
    }
    request.repeat_until_s = study_.repeat_until_s;
    if (solvers_[solver] == nullptr) solvers_[solver] = planned.open();
    solvers_[solver]->run(problem, request, timed_);
    rows.push_back(judge.judge(ids_[solver], timed_));
  }

  const Study& study_;
  TaskQueue& tasks_;
  Exchange& exchange_;
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
  std::vector<std::unique_ptr<SweptSolver>> sweeps_;
  std::vector<std::int64_t> ids_;
  Settler settler_;
  TimedAnswer timed_;
  std::vector<SweptAnswer> swept_;
};

/// Groups what arrives into transactions.
class BatchWriter {
 public:
  explicit BatchWriter(Store& store) : store_(store), certificates_(store), transactions_(store) {}

  void add(const Batch& batch) {
    if (transactions_.begin()) answers_ = 0;
    store_.add(batch.result);
    const std::int64_t problem = batch.result.problem.id;
    if (batch.certificate && !certificates_.has_proof(problem)) certificates_.add(problem, *batch.certificate);
    answers_ += batch.result.answers.size();
    if (answers_ >= kCommitAnswers) commit();
  }
  void commit_when_due() { transactions_.commit_when_due(); }
  void commit() { transactions_.commit(); }

 private:
  Store& store_;
  CertificateTable certificates_;
  PacedTransactions transactions_;
  std::size_t answers_ = 0;
};

void add_names(const Study& study, Store& store) {
  store.begin();
  for (const StudySet& set : study.sets) store.add_set(set.set->name());
  for (const StudySolver& solver : study.solvers) store.add_solver(solver.row, solver.cells);
  store.commit();
}

/// Finds tasks for a queue that runs low, for about 10 ms. @returns whether it is low still, and there may be more
bool fill(TaskQueue& tasks, PlanWalk& walk) {
  std::size_t waiting = tasks.size();
  if (waiting >= kTasksAhead / 2) return false;
  for (int passed = 0; passed < kLookedUpAtOnce && waiting < kTasksAhead && !walk.ended(); ++passed) {
    std::optional<Task> task = walk.step();
    if (!task) continue;
    tasks.push(std::move(*task));
    ++waiting;
  }
  if (walk.ended()) tasks.end();
  return waiting < kTasksAhead / 2 && !walk.ended();
}

/// Throws what ended a thread; where a user can go on once the cause is mended, the message says how.
[[noreturn]] void rethrow(const std::exception_ptr& error, const Store& store, bool kept) {
  const auto resumable = [&store, kept](const std::exception& cause) {
    if (!kept) return std::string(cause.what());
    return fmt::format("{}; what was done is kept in {}: run the same command again to go on", cause.what(),
                       store.file().string());
  };
  try {
    std::rethrow_exception(error);
  } catch (const InputError& cause) {
    throw InputError(resumable(cause));
  } catch (const WorkerError& cause) {
    throw WorkerError(resumable(cause));
  }
}

}  // namespace

RunOutcome run_study(const Study& study, Store& store, const RunOptions& options) {
  add_names(study, store);
  const Clock::time_point start = Clock::now();
  PlanWalk walk(study, store, options.shard, options.shards);
  TaskQueue tasks;
  bool searching = fill(tasks, walk);
  RunOutcome outcome;
  const auto count = [&] {
    outcome.already_done = walk.already_done();
    outcome.counted = walk.counted();
    outcome.progress.total = walk.planned() - walk.already_done();
  };
  count();

  const std::size_t most_jobs = walk.ended() ? tasks.size() : std::numeric_limits<std::size_t>::max();
  const int jobs = static_cast<int>(std::min(static_cast<std::size_t>(options.jobs), most_jobs));
  Exchange exchange(jobs);
  BatchWriter writer(store);
  ProducerThreads<Batch> threads(exchange);
  const ClosedAtTheEnd closed(tasks);
  std::vector<std::string> set_names;
  for (const StudySet& set : study.sets) set_names.push_back(set.set->name());

  for (int i = 0; i < jobs; ++i) {
    threads.start([&] { Worker(study, tasks, exchange).run(); });
  }
  double next_partial_s = kFirstPartialS;
  while (!exchange.drained()) {
    for (const Batch& batch : exchange.take(searching ? std::chrono::milliseconds(0) : kProgressEvery)) {
      writer.add(batch);
      outcome.progress.done += batch.result.cells();
      outcome.progress.set = &set_names[batch.set];
    }
    writer.commit_when_due();
    searching = !exchange.queue_closed() && fill(tasks, walk);
    count();
    outcome.progress.elapsed_s = seconds_since(start);
    if (options.on_progress) options.on_progress(outcome.progress);
    if (options.on_partial_results && outcome.progress.elapsed_s >= next_partial_s && outcome.progress.done > 0) {
      writer.commit();
      options.on_partial_results(store);
      next_partial_s = kPartialGrowth * seconds_since(start);
    }
    if (options.stop != nullptr && *options.stop != 0 && !exchange.stopped()) {
      exchange.stop();
      outcome.end = RunEnd::kStopped;
    }
    if (study.budget_s && outcome.progress.elapsed_s >= *study.budget_s) exchange.close_queue();
    if (exchange.queue_closed()) tasks.close();
  }
  threads.join();
  writer.commit();
  outcome.progress.elapsed_s = seconds_since(start);
  outcome.progress.set = nullptr;
  if (const std::exception_ptr error = exchange.error()) rethrow(error, store, options.store_is_kept);
  if (outcome.end == RunEnd::kComplete && outcome.progress.done < outcome.progress.total) {
    outcome.end = RunEnd::kOutOfBudget;
  }
  if (outcome.progress.done == outcome.progress.total) outcome.end = RunEnd::kComplete;
  return outcome;
}

}  // namespace lcpbench
