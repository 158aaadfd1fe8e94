#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "study/store/store.h"

// Many threads that produce, and one that writes to the store: what the runner and the certifier of stores share.

namespace lcpbench {

/// What producing threads and the writing thread share: results on their way, who is still at work, what went wrong.
template <class Result>
class ResultExchange {
 public:
  explicit ResultExchange(int producers) : producers_(producers) {}

  /// Blocks while the writer is behind.
  void push(Result result) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return results_.size() < kQueued || stopped(); });
    results_.push_back(std::move(result));
    arrived_.notify_one();
  }
  /// All that has arrived; waits up to `patience` for the first.
  std::vector<Result> take(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, patience, [this] { return !results_.empty() || producers_ == 0; });
    room_.notify_all();
    return std::exchange(results_, {});
  }
  /// @param error  what ended the producer, if not its work: stops the others too
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
  /// No producer is left, and nothing of theirs.
  bool drained() {
    const std::lock_guard lock(mutex_);
    return producers_ == 0 && results_.empty();
  }
  /// The first that a producer ended with; nullptr for none.
  std::exception_ptr error() {
    const std::lock_guard lock(mutex_);
    return error_;
  }
  /// After the solve in flight, nothing more is begun.
  void stop() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    room_.notify_all();
  }
  bool stopped() const { return stop_; }
  /// After the problem in flight, nothing more is begun.
  void close_queue() { closed_ = true; }
  bool queue_closed() const { return closed_ || stop_; }

 private:
  static constexpr std::size_t kQueued = 256;

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::condition_variable room_;
  std::vector<Result> results_;
  std::exception_ptr error_;
  int producers_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> closed_{false};
};

/// Transactions of at most about a second: what a kill can lose.
class PacedTransactions {
 public:
  explicit PacedTransactions(Store& store) : store_(store) {}

  /// Begins a transaction unless one is open.
  void begin() {
    if (open_) return;
    store_.begin();
    open_ = true;
    began_ = Clock::now();
  }
  void commit_when_due() {
    if (open_ && Clock::now() - began_ >= kCommitAfter) commit();
  }
  void commit() {
    if (!open_) return;
    open_ = false;
    store_.commit();
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kCommitAfter = std::chrono::milliseconds(800);

  Store& store_;
  bool open_ = false;
  Clock::time_point began_{};
};

/// Threads that produce results, and the calling thread, which alone writes them.
template <class Result>
class ParallelWork {
 public:
  ParallelWork(Store& store, int producers) : transactions_(store), exchange_(producers) {}
  ~ParallelWork() { exchange_.stop(); }
  ParallelWork(const ParallelWork&) = delete;
  ParallelWork& operator=(const ParallelWork&) = delete;

  /// Runs `produce` in a thread of its own; what it throws ends the others too.
  template <class Produce>
  void start(Produce produce) {
    threads_.emplace_back([this, produce] {
      std::exception_ptr error;
      try {
        produce();
      } catch (...) {
        error = std::current_exception();
      }
      exchange_.producer_ends(error);
    });
  }
  ResultExchange<Result>& exchange() { return exchange_; }

  /// Writes what arrives until every producer has ended, and commits it. What ended a producer is not thrown:
  /// exchange().error() has it.
  /// @param stop  set to non-zero from outside to end in good order; may be nullptr
  /// @param write  called with each result, inside a transaction
  /// @param look_around  called some ten times a second
  /// @returns whether `stop` ended it
  template <class Write, class LookAround>
  bool run(const volatile std::sig_atomic_t* stop, Write write, LookAround look_around) {
    bool stopped = false;
    while (!exchange_.drained()) {
      for (const Result& result : exchange_.take(std::chrono::milliseconds(100))) {
        transactions_.begin();
        write(result);
      }
      transactions_.commit_when_due();
      if (stop != nullptr && *stop != 0 && !exchange_.stopped()) {
        exchange_.stop();
        stopped = true;
      }
      look_around();
    }
    threads_.clear();  // joins them
    commit();
    return stopped;
  }
  void commit() { transactions_.commit(); }

 private:
  PacedTransactions transactions_;
  ResultExchange<Result> exchange_;
  std::vector<std::jthread> threads_;  ///< first out: they use the exchange
};

}  // namespace lcpbench
