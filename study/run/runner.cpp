#include "study/run/runner.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "adapters/worker/worker_client.h"
#include "core/error.h"
#include "core/io/json_document.h"
#include "core/io/problem_io.h"
#include "core/parallel_work.h"
#include "core/warm_start.h"
#include "study/certificates/certify_store.h"
#include "study/certificates/judge.h"
#include "study/inspect/rigid_bodies.h"
#include "study/run/work_queue.h"
#include "study/store/vector_codec.h"

namespace lcpbench {
namespace {

using Clock = std::chrono::steady_clock;

// A kill can lose this much work, the transaction that is open, and the solve or sweep in flight.
constexpr auto kHandOverAfter = std::chrono::milliseconds(500);
constexpr double kFirstPartialS = 8.0;  // well inside the twenty seconds in which a user wants to see a first row
constexpr double kPartialGrowth = 3.0;  // ever rarer: each one reads the whole store

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Batch {
  std::size_t set = 0;
  ProblemResult result;
  std::optional<CertificateRow> certificate;  ///< found because an answer denied a solution
  std::string left_out;                       ///< why the problem cannot be read; then there is no result
  std::int64_t cells_left_out = 0;
};

using Work = ParallelWork<Batch, Store>;

/// Makes rows of the answers to one problem, with their vectors, and of the certificate that one of them led to.
class RowMaker {
 public:
  RowMaker(const Problem& problem, BoundedCertifier& certifier, std::optional<double> solved_at, Batch& batch)
      : problem_(problem), judge_(problem, certifier, solved_at), batch_(batch) {}

  bool solvable_by_theory() const { return judge_.findings().has(Evidence::kTheory); }

  AnswerRow row(std::int64_t solver_id, const TimedAnswer& timed, FrictionModel model) {
    const Answer& answer = timed.answer;
    const std::size_t number = judge_.judge(answer, model);
    const Judgement& judgement = judge_.judgement(number);
    if (number == kept_.size()) kept_.push_back({keep(answer.z), keep(answer.velocity), keep(answer.farkas)});
    if (!certificate_kept_ && judge_.certificate()) keep_certificate();
    const auto& [z, velocity, farkas] = kept_[number];
    return {.solver_id = solver_id,
            .claim = answer.claim,
            .z = z,
            .velocity = velocity,
            .farkas = farkas,
            .counters = answer.counters,
            .detail = answer.detail,
            .errors = judgement.errors,
            .farkas_checked = judgement.proof_holds,
            .times = timed.times,
            .verify_s = judgement.verify_s};
  }

 private:
  std::optional<std::int64_t> keep(const Vector& vector) {
    if (vector.size() == 0) return std::nullopt;
    std::string bytes = encode_vector(vector);
    const std::int64_t id = content_id(bytes);
    batch_.result.vectors.emplace_back(id, std::move(bytes));
    return id;
  }

  void keep_certificate() {
    certificate_kept_ = true;
    CertificateRow row = certificate_row(problem_, *judge_.certificate(), 0);
    if (row.kind != CertificateKind::kOpen) batch_.certificate = std::move(row);
  }

  const Problem& problem_;
  Judge judge_;
  Batch& batch_;
  std::vector<std::array<std::optional<std::int64_t>, 3>> kept_;  ///< ids of z, velocity, proof of each distinct answer
  bool certificate_kept_ = false;
};

ProblemRow problem_row(const std::string& set_name, std::uint64_t seed, std::int64_t trial, const TimeStep& step,
                       bool solvable_by_theory) {
  const Problem& problem = step.problem;
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
  row.free_bodies = has_free_bodies(problem);
  row.hash = problem_hash(problem);
  row.theory = solvable_by_theory ? "solvable" : "";
  row.notes = Json(step.notes).dump();
  return row;
}

/// One thread's solvers and its loop over the problems.
class Worker {
 public:
  Worker(const Study& study, PlanWalk& walk, Work& work, const volatile std::sig_atomic_t* stop)
      : study_(study),
        walk_(walk),
        work_(work),
        stop_(stop),
        solvers_(study.solvers.size()),
        sweeps_(study.solvers.size()),
        last_(study.solvers.size()) {
    for (const StudySolver& solver : study.solvers) ids_.push_back(solver.row.id());
  }

  void run() {
    const auto closed = [this] { return work_.closed(); };
    while (const std::optional<Task> task = walk_.next(closed)) run_task(*task);
  }

 private:
  /// A solver's answer to the step before.
  struct Last {
    TimeStep step;
    Vector z;  ///< empty: there is none to start from
  };

  /// Solves the trials of a task in their order. No solver starts from a step of another task.
  void run_task(const Task& task) {
    std::fill(last_.begin(), last_.end(), Last{});
    for (std::int64_t trial = task.trial; trial < task.trial + task.count && !work_.stopped(); ++trial) {
      const std::vector<std::size_t> solvers = order(task, trial);
      if (!solvers.empty()) run_trial(task.set, trial, solvers);
    }
  }

  void run_trial(std::size_t set_number, std::int64_t trial, const std::vector<std::size_t>& solvers) {
    const ProblemSet& set = *study_.sets[set_number].set;
    TimeStep step;
    try {
      step = set.step(study_.seed, trial);
    } catch (const InputError& error) {
      leave_out(set_number, solvers, error.what());
      return;
    }
    const Problem& problem = step.problem;
    Batch batch{.set = set_number};
    RowMaker rows(problem, certifier_, study_.solved_at, batch);
    batch.result.problem = problem_row(set.name(), study_.seed, trial, step, rows.solvable_by_theory());
    Clock::time_point handed_over = Clock::now();
    for (const std::size_t solver : solvers) {
      if (work_.stopped()) break;
      solve(step, solver, rows, batch.result.answers);
      if (Clock::now() - handed_over < kHandOverAfter) continue;
      work_.push(batch);
      batch.result.vectors.clear();
      batch.result.answers.clear();
      batch.certificate.reset();
      handed_over = Clock::now();
    }
    if (!batch.result.answers.empty()) work_.push(std::move(batch));
  }

  void leave_out(std::size_t set, const std::vector<std::size_t>& solvers, const std::string& why) {
    Batch batch{.set = set, .left_out = why};
    for (const std::size_t solver : solvers) batch.cells_left_out += study_.solvers[solver].cell_count();
    work_.push(std::move(batch));
    std::fill(last_.begin(), last_.end(), Last{});  // the next step does not follow the one before
  }

  /// The task's solvers that take the trial, in an order rotated by a hash of the trial, so that each is first about as
  /// often, whatever k of "every k trials" shares with the number of solvers: see run_study().
  std::vector<std::size_t> order(const Task& task, std::int64_t trial) const {
    std::vector<std::size_t> solvers = task.solvers;
    std::erase_if(solvers, [&](std::size_t i) { return !study_.solvers[i].takes(task.set, trial); });
    if (solvers.empty()) return solvers;
    constexpr std::uint64_t kMix = 0xBF58476D1CE4E5B9U;
    std::uint64_t mixed = static_cast<std::uint64_t>(trial) * kMix;
    mixed = (mixed ^ mixed >> 32) * kMix;
    const auto turn = static_cast<std::ptrdiff_t>((mixed >> 32) % solvers.size());
    std::rotate(solvers.begin(), solvers.begin() + turn, solvers.end());
    return solvers;
  }

  /// Runs one solver, or one whole sweep, and appends what it answered.
  void solve(const TimeStep& step, std::size_t solver, RowMaker& rows, std::vector<AnswerRow>& answers) {
    const Problem& problem = step.problem;
    const StudySolver& planned = study_.solvers[solver];
    // The signal that ends this run may reach a worker first. That is no crash: no row, and the next run asks again.
    const auto was_ended = [this](const TimedAnswer& timed) {
      return timed.answer.claim == Claim::kCrashed && stop_ != nullptr && *stop_ != 0;
    };
    TimedRequest request;
    request.time_limit_s = study_.time_limit_s;
    if (planned.swept()) {
      if (sweeps_[solver] == nullptr) sweeps_[solver] = planned.open_swept();
      sweeps_[solver]->run(problem, request, swept_);
      if (std::ranges::any_of(swept_, was_ended, &SweptAnswer::timed)) return;
      for (const SweptAnswer& answer : swept_) add_rows(answer, solver, problem, rows, answers);
      return;
    }
    request.repeat_until_s = study_.repeat_until_s;
    if (solvers_[solver] == nullptr) solvers_[solver] = planned.open();
    if (planned.from_last) start_from(last_[solver], step, request);
    solvers_[solver]->run(problem, request, timed_);
    if (was_ended(timed_)) return;
    if (planned.from_last) keep_last(step, request, last_[solver]);
    answers.push_back(rows.row(ids_[solver], timed_, friction_model(planned.row.friction, problem)));
  }

  /// Cells that solve different models of friction get rows of their own, also for equal bits: a verdict is taken by
  /// the model of the row's cells.
  void add_rows(const SweptAnswer& answer, std::size_t solver, const Problem& problem, RowMaker& rows,
                std::vector<AnswerRow>& answers) const {
    std::map<FrictionModel, std::vector<std::uint32_t>> cells_of;
    for (const std::uint32_t cell : answer.cells) {
      cells_of[friction_model(study_.solvers[solver].cells[cell].friction, problem)].push_back(cell);
    }
    for (auto& [model, cells] : cells_of) {
      answers.push_back(rows.row(ids_[solver], answer.timed, model));
      answers.back().cells = std::move(cells);
    }
  }

  /// Requests a start from the answer to the step before, matched by the names of the contacts. Requests none where
  /// that answer or the names of either step are missing. @pre the steps are contact problems
  void start_from(const Last& last, const TimeStep& step, TimedRequest& request) {
    const auto named = [](const TimeStep& one) { return std::ssize(one.contact_ids) == one.problem.contact()->nc(); };
    if (last.z.size() == 0 || !named(last.step) || !named(step)) return;
    match_.find(last.step.contact_ids, step.contact_ids);
    matched_start(last.z, contact_layout(*last.step.problem.contact()), match_, contact_layout(*step.problem.contact()),
                  start_);
    request.start = &start_;
  }

  /// Keeps any finite z for the next step, whatever was claimed, as an engine does. A crash leaves none.
  /// @param last  until then the answer to the step before
  void keep_last(const TimeStep& step, const TimedRequest& request, Last& last) {
    if (request.start == nullptr) {
      const char* const missing = last.z.size() > 0 ? "names of the contacts" : "answer to the step before";
      timed_.answer.detail.insert(0, fmt::format("from nothing: no {}; ", missing));
    }
    last = {};
    if (timed_.answer.z.size() == step.problem.size() && timed_.answer.z.allFinite()) last = {step, timed_.answer.z};
  }

  const Study& study_;
  PlanWalk& walk_;
  Work& work_;
  const volatile std::sig_atomic_t* stop_;  ///< of RunOptions
  std::vector<std::unique_ptr<TimedSolver>> solvers_;
  std::vector<std::unique_ptr<SweptSolver>> sweeps_;
  std::vector<Last> last_;  ///< for each solver that starts from it
  ContactMatch match_;
  Vector start_;
  std::vector<std::int64_t> ids_;
  BoundedCertifier certifier_;
  TimedAnswer timed_;
  std::vector<SweptAnswer> swept_;
};

void add_names(const Study& study, Store& store) {
  store.begin();
  for (const StudySet& set : study.sets) store.add_set(set.set->name());
  for (const StudySolver& solver : study.solvers) store.add_solver(solver.row, solver.cells);
  store.commit();
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
  RunOutcome outcome;
  const auto count = [&] {
    outcome.already_done = walk.already_done();
    outcome.counted = walk.counted();
    outcome.progress.total = walk.planned() - walk.already_done();
  };
  count();

  std::vector<std::string> set_names;
  for (const StudySet& set : study.sets) set_names.push_back(set.set->name());
  Work work(store);
  for (int i = 0; i < options.jobs; ++i) {
    work.start([&] { Worker(study, walk, work, options.stop).run(); });
  }
  CertificateTable certificates(store);
  std::int64_t cells_left_out = 0;
  const auto write = [&](const Batch& batch) {
    if (!batch.left_out.empty()) {
      outcome.left_out.push_back(batch.left_out);
      cells_left_out += batch.cells_left_out;
      return;
    }
    store.add(batch.result);
    const std::int64_t problem = batch.result.problem.id;
    if (batch.certificate && !certificates.has_proof(problem)) certificates.add(problem, *batch.certificate);
    outcome.progress.done += batch.result.cells();
    outcome.progress.set = &set_names[batch.set];
  };
  double next_partial_s = kFirstPartialS;
  const auto look_around = [&] {
    count();
    outcome.progress.elapsed_s = seconds_since(start);
    if (options.on_progress) options.on_progress(outcome.progress);
    if (options.on_partial_results && outcome.progress.elapsed_s >= next_partial_s && outcome.progress.done > 0) {
      work.commit();
      options.on_partial_results(store);
      next_partial_s = kPartialGrowth * seconds_since(start);
    }
    if (study.budget_s && outcome.progress.elapsed_s >= *study.budget_s) work.close();
  };
  if (work.run(options.stop, write, look_around)) outcome.end = RunEnd::kStopped;
  count();
  outcome.progress.elapsed_s = seconds_since(start);
  outcome.progress.set = nullptr;
  if (const std::exception_ptr error = work.error()) rethrow(error, store, options.store_is_kept);
  std::ranges::sort(outcome.left_out);
  const std::int64_t seen = outcome.progress.done + cells_left_out;
  if (seen > 0 && seen == cells_left_out && outcome.already_done == 0) throw InputError(outcome.left_out.front());
  if (outcome.end == RunEnd::kComplete && seen < outcome.progress.total) outcome.end = RunEnd::kOutOfBudget;
  if (seen == outcome.progress.total) outcome.end = RunEnd::kComplete;
  return outcome;
}

}  // namespace lcpbench
