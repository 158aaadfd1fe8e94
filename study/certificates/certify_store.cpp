#include "study/certificates/certify_store.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/error.h"
#include "generators/problem_io.h"
#include "generators/sets.h"
#include "study/certificates/proof_document.h"

namespace lcpbench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kCommitAfter = std::chrono::milliseconds(800);
constexpr auto kProgressEvery = std::chrono::milliseconds(100);
constexpr std::size_t kQueuedResults = 256;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Sets = std::map<std::string, std::unique_ptr<const ProblemSet>>;

struct Result {
  std::int64_t problem_id = 0;
  std::optional<CertificateRow> certificate;
  std::vector<ForwardError> forward;
};

/// What the threads and the writer share.
class Exchange {
 public:
  explicit Exchange(int producers) : producers_(producers) {}

  /// Blocks while the writer is behind.
  void push(Result result) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return results_.size() < kQueuedResults || stop_; });
    results_.push_back(std::move(result));
    arrived_.notify_one();
  }
  std::vector<Result> take() {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, kProgressEvery, [this] { return !results_.empty() || producers_ == 0; });
    room_.notify_all();
    return std::exchange(results_, {});
  }
  void producer_ends(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    --producers_;
    if (error != nullptr) {
      if (error_ == nullptr) error_ = error;
      stop_ = true;
    }
    room_.notify_all();
    arrived_.notify_one();
  }
  bool drained() {
    const std::lock_guard lock(mutex_);
    return producers_ == 0 && results_.empty();
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    room_.notify_all();
  }
  bool stopped() const { return stop_; }
  std::exception_ptr error() {
    const std::lock_guard lock(mutex_);
    return error_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::condition_variable room_;
  std::vector<Result> results_;
  std::exception_ptr error_;
  int producers_;
  std::atomic<bool> stop_{false};
};

CertificateRow row_of(const Problem& problem, const Certificate& certificate, double time_limit_s) {
  CertificateRow row;
  row.kind = certificate.kind;
  row.proof = certificate.proof;
  row.velocity = certificate.velocity;
  row.velocity_unique = certificate.velocity_unique;
  row.least_violation_m_per_s = least_violation(problem, certificate);
  row.detail = certificate.detail;
  row.seconds = certificate.seconds;
  row.time_limit_s = time_limit_s;
  if (certificate.kind != CertificateKind::kOpen) row.document = deflate(proof_document(problem, certificate));
  return row;
}

/// One thread's part of the work. It reads through a connection of its own.
class Worker {
 public:
  Worker(const CertifyRun& run, const std::filesystem::path& store, const Sets& sets)
      : run_(run), sets_(sets), store_(Store::open_for_reading(store)), table_(store_), certify_(run.open()) {}

  Result work(const CertifyTask& task) {
    const Problem problem = sets_.at(task.set)->generate(task.seed, task.trial);
    if (problem_hash(problem) != task.hash) {
      throw InputError(
          fmt::format("{}: trial {} of seed {} of set '{}' is another problem than the one that was "
                      "solved: the set has changed, and its answers cannot be certified",
                      store_.file().string(), task.trial, task.seed, task.set));
    }
    Result result;
    result.problem_id = task.problem_id;
    std::optional<Vector> v_star;
    if (task.certify) {
      const Certificate certificate = certify_(problem);
      result.certificate = row_of(problem, certificate, run_.scope.time_limit_s);
      if (certificate.velocity_unique.value_or(false)) v_star = certificate.velocity;
    } else {
      v_star = table_.unique_velocity(task.problem_id);
    }
    if (v_star && v_star->size() > 0) result.forward = forward_errors(problem, task.problem_id, *v_star);
    return result;
  }

 private:
  std::vector<ForwardError> forward_errors(const Problem& problem, std::int64_t problem_id, const Vector& v_star) {
    std::vector<ForwardError> errors = table_.answers_without_forward_error(problem_id);
    if (errors.empty()) return errors;
    Evaluator evaluator(problem);
    evaluator.set_certified_velocity(v_star);
    for (ForwardError& error : errors) {
      const auto part = static_cast<std::uint32_t>(error.part);
      const std::optional<Answer> answer = store_.answer(problem_id, error.solver_id, part);
      if (answer) error.forward_velocity = evaluator.errors(*answer).forward_velocity;
    }
    return errors;
  }

  const CertifyRun& run_;
  const Sets& sets_;
  Store store_;
  CertificateTable table_;
  CertifyProblem certify_;
};

class Writer {
 public:
  explicit Writer(Store& store) : store_(store), table_(store) {}

  void add(const Result& result) {
    if (!open_) {
      store_.begin();
      open_ = true;
      began_ = Clock::now();
    }
    if (result.certificate) table_.add(result.problem_id, *result.certificate);
    table_.add(result.problem_id, result.forward);
  }
  void commit_when_due() {
    if (open_ && Clock::now() - began_ >= kCommitAfter) commit();
  }
  void commit() {
    if (open_) store_.commit();
    open_ = false;
  }

 private:
  Store& store_;
  CertificateTable table_;
  bool open_ = false;
  Clock::time_point began_{};
};

class Threads {
 public:
  explicit Threads(Exchange& exchange) : exchange_(exchange) {}
  ~Threads() {
    exchange_.stop();
    join();
  }
  template <class Function>
  void start(Function function) {
    threads_.emplace_back(std::move(function));
  }
  void join() {
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

 private:
  Exchange& exchange_;
  std::vector<std::thread> threads_;
};

Sets open_sets(const std::vector<CertifyTask>& tasks) {
  Sets sets;
  for (const CertifyTask& task : tasks) {
    std::unique_ptr<const ProblemSet>& set = sets[task.set];
    if (set == nullptr) set = open_set(task.set);
  }
  return sets;
}

}  // namespace

double least_violation(const Problem& problem, const Certificate& certificate) {
  const ContactProblem* contact = problem.contact();
  if (certificate.proof != ProofKind::kFarkas || contact == nullptr) return kNone;
  if (certificate.farkas.size() < contact->nc() || contact->nc() == 0) return kNone;
  // u is the exact one rounded: what that and these sums can be off is taken away.
  constexpr double kRounding = 1e-13;
  const Matrix N = to_dense(contact->N);
  const Vector u = certificate.farkas.head(contact->nc());
  const double gain = contact->v.dot(N * u);
  const double magnitude = contact->v.cwiseAbs().dot(N.cwiseAbs() * u);
  return std::max(0.0, (-gain - kRounding * magnitude) / u.sum());
}

CertifyOutcome certify_store(Store& store, const CertifyRun& run) {
  const std::vector<CertifyTask> tasks = CertificateTable(store).pending(run.scope);
  const Sets sets = open_sets(tasks);
  CertifyOutcome outcome;
  outcome.total = static_cast<std::int64_t>(tasks.size());

  const int jobs = static_cast<int>(std::min(static_cast<std::size_t>(run.jobs), tasks.size()));
  Exchange exchange(jobs);
  std::atomic<std::size_t> next{0};
  Writer writer(store);
  Threads threads(exchange);
  for (int i = 0; i < jobs; ++i) {
    threads.start([&] {
      std::exception_ptr error;
      try {
        Worker worker(run, store.file(), sets);
        while (!exchange.stopped()) {
          const std::size_t task = next.fetch_add(1);
          if (task >= tasks.size()) break;
          exchange.push(worker.work(tasks[task]));
        }
      } catch (...) {
        error = std::current_exception();
      }
      exchange.producer_ends(error);
    });
  }
  while (!exchange.drained()) {
    for (const Result& result : exchange.take()) {
      writer.add(result);
      ++outcome.done;
    }
    writer.commit_when_due();
    if (run.on_progress) run.on_progress(outcome.done, outcome.total);
    if (run.stop != nullptr && *run.stop != 0) exchange.stop();
  }
  threads.join();
  writer.commit();
  if (const std::exception_ptr error = exchange.error()) std::rethrow_exception(error);
  return outcome;
}

}  // namespace lcpbench
