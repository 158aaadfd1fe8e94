#include "tests/attack/campaign.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>
#include <thread>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/problem_io.h"

namespace lcpbench::attack {
namespace {

// Problems that one process meets before another takes over; the counts do not depend on it.
constexpr std::uint64_t kChunk = 64;
constexpr auto kNap = std::chrono::milliseconds(2);
constexpr std::size_t kLargestSubjects = 64;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// What parent and children share. A child says what it is about to do before it does it.
struct Job {
  std::atomic<std::uint64_t> index;    ///< of the problem
  std::atomic<std::uint64_t> subject;  ///< the number of subjects: none, the truth is being found
  std::atomic<double> since_s;
};

static_assert(std::atomic<double>::is_always_lock_free && std::atomic<std::uint64_t>::is_always_lock_free);

struct Slowest {
  std::atomic<double> seconds;
  std::atomic<std::uint64_t> index;
};

/// An array of zeros that children may write.
template <class T>
T* shared(std::size_t count) {
  void* memory = mmap(nullptr, std::max<std::size_t>(1, count) * sizeof(T), PROT_READ | PROT_WRITE,
                      MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return static_cast<T*>(memory);
}

/// A part of the work of one process.
struct Chunk {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
  std::uint64_t first_subject = 0;  ///< of problem `begin`; the others start with the first
  pid_t process = -1;               ///< -1: nobody
  bool waiting = false;             ///< for a process
};

class Campaign {
 public:
  explicit Campaign(const CampaignOptions& options)
      : options_(options),
        kinds_(kinds(options.family)),
        counts_(shared<std::atomic<std::uint64_t>>(kinds_.size() * options.subjects.size() * kOutcomes)),
        truths_(shared<std::atomic<std::uint64_t>>(kinds_.size() * kTruths)),
        files_(shared<std::atomic<int>>(options.subjects.size() * kOutcomes)),
        slowest_(shared<Slowest>(options.subjects.size())),
        jobs_(shared<Job>(static_cast<std::size_t>(options.jobs))),
        chunks_(static_cast<std::size_t>(options.jobs)) {}

  Tally run();

 private:
  void work(std::size_t job, const Chunk& chunk);
  Outcome meet(std::size_t job, Target& target, std::uint64_t index, Subject& subject, std::uint64_t number);
  bool takes_part(std::uint64_t subject, std::uint64_t index) const;
  void count_findings(std::uint64_t index, const Target& target, const std::vector<Outcome>& outcomes);
  std::atomic<std::uint64_t>& cell(std::uint64_t index, std::uint64_t subject, Outcome outcome);
  void count(std::uint64_t index, std::uint64_t subject, Outcome outcome, const std::string& detail);
  void keep(std::uint64_t index, std::uint64_t subject, Outcome outcome, const std::string& detail);
  void count_truth(std::size_t kind, const ExactTruth& truth);
  void start(std::size_t job);
  void look_after(std::size_t job);
  void pass_over(std::size_t job, Outcome outcome, const std::string& detail);
  bool take_chunk(Chunk& chunk);
  Tally tally() const;

  std::size_t kind_of(std::uint64_t index) const { return static_cast<std::size_t>(index % kinds_.size()); }

  /// Of each kind in turn: half are loaded, a quarter updated, a quarter started anywhere.
  Approach approach_of(std::uint64_t index) const {
    const std::uint64_t turn = index / kinds_.size() % 4;
    return turn == 1 ? Approach::kUpdate : turn == 3 ? Approach::kStart : Approach::kLoad;
  }

  const CampaignOptions& options_;
  const std::vector<std::string>& kinds_;
  std::atomic<std::uint64_t>* counts_;
  std::atomic<std::uint64_t>* truths_;
  std::atomic<int>* files_;
  Slowest* slowest_;
  Job* jobs_;
  std::vector<Chunk> chunks_;
  std::uint64_t next_ = 0;
};

void Campaign::count_truth(std::size_t kind, const ExactTruth& truth) {
  std::atomic<std::uint64_t>* of_kind = truths_ + kind * kTruths;
  if (truth.truth == Truth::kSolvable) ++of_kind[0];
  if (truth.truth == Truth::kUnsolvable) ++of_kind[1];
  if (truth.shown_by_doubles) ++of_kind[2];
  if (truth.truth == Truth::kUnknown) ++of_kind[3];
}

void Campaign::keep(std::uint64_t index, std::uint64_t subject, Outcome outcome, const std::string& detail) {
  if (options_.out.empty()) return;
  if (files_[subject * kOutcomes + static_cast<std::size_t>(outcome)]++ >= options_.files_per_class) return;
  const std::string name = std::string(to_string(options_.family)) + "-" + to_string(outcome) + "-" +
                           options_.subjects[subject] + "-" + std::to_string(index);
  try {
    write_problem(generate(options_.family, options_.seed, index), options_.out / (name + ".json"));
  } catch (const InputError&) {
    // A given G* that rounding made indefinite may be no file: --first and the index draw it again.
  }
  std::ofstream(options_.out / (name + ".txt")) << detail << "\n";
}

std::atomic<std::uint64_t>& Campaign::cell(std::uint64_t index, std::uint64_t subject, Outcome outcome) {
  const std::size_t row = kind_of(index) * options_.subjects.size() + subject;
  return counts_[row * kOutcomes + static_cast<std::size_t>(outcome)];
}

void Campaign::count(std::uint64_t index, std::uint64_t subject, Outcome outcome, const std::string& detail) {
  ++cell(index, subject, outcome);
  if (contradiction(outcome)) keep(index, subject, outcome, detail);
}

bool Campaign::takes_part(std::uint64_t subject, std::uint64_t index) const {
  return subject < options_.sampled_from || (index / kinds_.size() + subject) % kSampled == 0;
}

/// What is known only when every subject has met the problem.
void Campaign::count_findings(std::uint64_t index, const Target& target, const std::vector<Outcome>& outcomes) {
  std::atomic<std::uint64_t>* of_kind = truths_ + kind_of(index) * kTruths;
  if (target.unresolved) ++of_kind[5];
  const bool contacts = target.problem.contact() != nullptr;
  if (!contacts || !target.passes || target.truth.truth != Truth::kUnsolvable) return;
  ++of_kind[4];
  for (std::size_t s = 0; s < outcomes.size(); ++s) {
    if (outcomes[s] != Outcome::kUnsolvable && outcomes[s] != Outcome::kUnsolvableNoProof) continue;
    --cell(index, s, outcomes[s]);
    ++cell(index, s, Outcome::kNearlyUnsolvable);
  }
}

Outcome Campaign::meet(std::size_t job, Target& target, std::uint64_t index, Subject& subject, std::uint64_t number) {
  jobs_[job].since_s = now_s();
  jobs_[job].subject = number;
  std::string detail;
  Outcome outcome = Outcome::kCrashed;
  const double start_s = now_s();
  try {
    outcome = subject.meet(target, options_.time_limit_s, detail);
  } catch (const std::exception& error) {
    detail = std::string("threw ") + error.what();
  }
  const double seconds = now_s() - start_s;
  if (seconds > slowest_[number].seconds) {
    slowest_[number].seconds = seconds;
    slowest_[number].index = index;
  }
  count(index, number, outcome, detail);
  return outcome;
}

void Campaign::work(std::size_t job, const Chunk& chunk) {
  std::vector<std::unique_ptr<Subject>> subjects;
  for (const std::string& name : options_.subjects) subjects.push_back(options_.make(name));
  for (std::uint64_t index = chunk.begin; index < chunk.end; ++index) {
    jobs_[job].since_s = now_s();
    jobs_[job].subject = subjects.size();
    jobs_[job].index = index;
    Target target(generate(options_.family, options_.seed, index), approach_of(index));
    const std::uint64_t first = index == chunk.begin ? chunk.first_subject : 0;
    if (first == 0) count_truth(kind_of(index), target.truth);
    std::vector<Outcome> outcomes(subjects.size(), Outcome::kRefused);
    for (std::uint64_t s = first; s < subjects.size(); ++s) {
      if (takes_part(s, index)) outcomes[s] = meet(job, target, index, *subjects[s], s);
    }
    count_findings(index, target, outcomes);
  }
}

bool Campaign::take_chunk(Chunk& chunk) {
  if (next_ >= options_.problems) return false;
  const std::uint64_t end = std::min(next_ + kChunk, options_.problems);
  chunk = {options_.first + next_, options_.first + end, 0, -1, true};
  next_ = end;
  return true;
}

void Campaign::start(std::size_t job) {
  Chunk& chunk = chunks_[job];
  jobs_[job].index = chunk.begin;
  jobs_[job].subject = options_.subjects.size();
  jobs_[job].since_s = now_s();
  chunk.waiting = false;
  std::fflush(nullptr);
  chunk.process = fork();
  if (chunk.process < 0) throw std::runtime_error("cannot start a process");
  if (chunk.process > 0) return;
  try {
    work(job, chunk);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "attack: problem %llu: %s\n", static_cast<unsigned long long>(jobs_[job].index.load()),
                 error.what());
    std::_Exit(1);
  }
  std::_Exit(0);
}

/// The process of a job died at, or was ended for, what it was doing: the rest is left to another one.
void Campaign::pass_over(std::size_t job, Outcome outcome, const std::string& detail) {
  const std::uint64_t index = jobs_[job].index;
  const std::uint64_t subject = jobs_[job].subject;
  Chunk& chunk = chunks_[job];
  chunk.process = -1;
  chunk.begin = index;
  if (subject < options_.subjects.size()) {
    count(index, subject, outcome, detail);
    chunk.first_subject = subject + 1;
  } else {
    std::fprintf(stderr, "attack: the exact truth of problem %llu was not found: %s\n",
                 static_cast<unsigned long long>(index), detail.c_str());
    count_truth(kind_of(index), ExactTruth{});
    chunk.begin = index + 1;
    chunk.first_subject = 0;
  }
  chunk.waiting = chunk.begin < chunk.end;
}

void Campaign::look_after(std::size_t job) {
  Chunk& chunk = chunks_[job];
  int status = 0;
  if (waitpid(chunk.process, &status, WNOHANG) == chunk.process) {
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      chunk.process = -1;
    } else {
      pass_over(job, Outcome::kCrashed,
                WIFSIGNALED(status) ? "signal " + std::to_string(WTERMSIG(status)) : "ended the process");
    }
    return;
  }
  if (now_s() - jobs_[job].since_s < options_.hard_limit_s) return;
  kill(chunk.process, SIGKILL);
  waitpid(chunk.process, &status, 0);
  pass_over(job, Outcome::kHung, "more than " + std::to_string(options_.hard_limit_s) + " s");
}

Tally Campaign::run() {
  if (options_.subjects.size() > kLargestSubjects) throw std::runtime_error("too many subjects");
  if (!options_.out.empty()) std::filesystem::create_directories(options_.out);
  for (bool busy = true; busy;) {
    busy = false;
    for (std::size_t job = 0; job < chunks_.size(); ++job) {
      Chunk& chunk = chunks_[job];
      if (chunk.process > 0) look_after(job);
      if (chunk.process < 0 && (chunk.waiting || take_chunk(chunk))) start(job);
      busy = busy || chunk.process > 0;
    }
    std::this_thread::sleep_for(kNap);
  }
  return tally();
}

Tally Campaign::tally() const {
  Tally result;
  result.kinds = kinds_;
  result.subjects = options_.subjects;
  const std::size_t cells = kinds_.size() * options_.subjects.size() * kOutcomes;
  for (std::size_t i = 0; i < cells; ++i) result.counts.push_back(counts_[i]);
  for (std::size_t i = 0; i < kinds_.size() * kTruths; ++i) result.truths.push_back(truths_[i]);
  for (std::size_t s = 0; s < options_.subjects.size(); ++s) {
    result.slowest_s.push_back(slowest_[s].seconds);
    result.slowest_at.push_back(slowest_[s].index);
  }
  return result;
}

}  // namespace

std::uint64_t Tally::count(std::size_t kind, std::size_t subject, Outcome outcome) const {
  return counts[(kind * subjects.size() + subject) * kOutcomes + static_cast<std::size_t>(outcome)];
}

std::uint64_t Tally::count(std::size_t subject, Outcome outcome) const {
  std::uint64_t sum = 0;
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) sum += count(kind, subject, outcome);
  return sum;
}

std::uint64_t Tally::contradictions() const {
  std::uint64_t sum = 0;
  for (std::size_t s = 0; s < subjects.size(); ++s) {
    for (std::size_t o = 0; o < kOutcomes; ++o) {
      const auto outcome = static_cast<Outcome>(o);
      if (contradiction(outcome)) sum += count(s, outcome);
    }
  }
  return sum;
}

std::uint64_t Tally::truth(std::size_t truth) const {
  std::uint64_t sum = 0;
  for (std::size_t i = truth; i < truths.size(); i += kTruths) sum += truths[i];
  return sum;
}

Tally run_campaign(const CampaignOptions& options) {
  Campaign campaign(options);
  return campaign.run();
}

}  // namespace lcpbench::attack
