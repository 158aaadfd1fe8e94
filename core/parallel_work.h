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

namespace lcpbench {

/// Threads that produce results, and the calling thread, which alone writes them to the store. A transaction is
/// committed after about a second: that much a kill can lose. The runner and the certifier of stores share it.
/// @tparam Store  has begin() and commit()
template <class Result, class Store>
class ParallelWork {
 public:
  explicit ParallelWork(Store& store) : store_(store) {}
  ~ParallelWork() { stop(); }
  ParallelWork(const ParallelWork&) = delete;
  ParallelWork& operator=(const ParallelWork&) = delete;

  /// Runs `produce` in a thread of its own; it has to return soon once stopped() is true. An exception that leaves it
  /// stops the others, too.
  template <class Produce>
  void start(Produce produce) {
    {
      const std::lock_guard lock(mutex_);
      ++producers_;
    }
    threads_.emplace_back([this, produce] {
      std::exception_ptr error;
      try {
        produce();
      } catch (...) {
        error = std::current_exception();
      }
      if (error != nullptr) stop();
      const std::lock_guard lock(mutex_);
      --producers_;
      if (error_ == nullptr) error_ = error;
      arrived_.notify_one();
    });
  }

  /// Hands a result over; blocks while many wait to be written, unless stopped. For producers.
  void push(Result result) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [this] { return results_.size() < kQueued || stopped(); });
    results_.push_back(std::move(result));
    arrived_.notify_one();
  }
  /// True: producers finish the solve or certificate at hand and begin no other.
  bool stopped() const { return stop_; }
  /// True: producers finish the task at hand, one problem or consecutive steps, and begin no other.
  bool closed() const { return closed_ || stop_; }
  /// Makes closed() true.
  void close() { closed_ = true; }

  /// Writes what arrives until every producer has ended, and commits it. An exception of a producer is not thrown:
  /// error() has it.
  /// @param stop  non-zero, as a signal handler sets it, stops the producers; may be nullptr
  /// @param write  called with each result, inside a transaction
  /// @param look_around  called after each group of results, and every 100 ms while none arrives
  /// @returns whether `stop` was found non-zero before any producer failed
  template <class Write, class LookAround>
  bool run(const volatile std::sig_atomic_t* stop, Write write, LookAround look_around) {
    bool was_told_to_stop = false;
    for (bool working = !threads_.empty(); working;) {
      std::vector<Result> results;
      {
        std::unique_lock lock(mutex_);
        arrived_.wait_for(lock, kPatience, [this] { return !results_.empty() || producers_ == 0; });
        results.swap(results_);
        working = producers_ > 0;
        room_.notify_all();
      }
      for (const Result& result : results) {
        begin();
        write(result);
        commit_when_due();
      }
      commit_when_due();
      if (stop != nullptr && *stop != 0 && !stopped()) {
        this->stop();
        was_told_to_stop = true;
      }
      look_around();
    }
    threads_.clear();  // joins them
    commit();
    return was_told_to_stop;
  }
  void commit() {
    if (!std::exchange(open_, false)) return;
    store_.commit();
  }
  /// The first exception that ended a producer; nullptr for none. After run().
  std::exception_ptr error() const { return error_; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kQueued = 256;
  static constexpr auto kPatience = std::chrono::milliseconds(100);
  static constexpr auto kCommitAfter = std::chrono::milliseconds(800);

  void begin() {
    if (open_) return;
    store_.begin();
    open_ = true;
    began_ = Clock::now();
  }
  void commit_when_due() {
    if (open_ && Clock::now() - began_ >= kCommitAfter) commit();
  }
  void stop() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    room_.notify_all();
  }

  Store& store_;
  bool open_ = false;  ///< a transaction is open
  Clock::time_point began_{};
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::condition_variable room_;
  std::vector<Result> results_;
  std::exception_ptr error_;
  int producers_ = 0;
  std::atomic<bool> stop_{false};
  std::atomic<bool> closed_{false};
  std::vector<std::jthread> threads_;  ///< the last member, so that they are joined before the others are destroyed
};

}  // namespace lcpbench
