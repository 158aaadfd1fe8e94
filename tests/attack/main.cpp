// Solvers, certificates and the evaluation against nasty small problems whose exact truth is found independently.
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include <CLI/CLI.hpp>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "tests/attack/problems.h"
#include "tests/attack/subjects.h"

namespace lcpbench::attack {
namespace {

constexpr std::uint64_t kMostUnresolved = 100;  // one problem in so many may have an inertia that is not resolved
constexpr double kTimeLimit_s = 1;              // asked of the solvers

struct Arguments {
  std::string family = "all";
  std::string subject;  ///< "": all
  std::uint64_t seed = 1;
  std::uint64_t problems = 1000;
  std::uint64_t first = 0;  ///< index of the first problem
  int jobs = 1;
  std::filesystem::path out;  ///< where problems of contradictions are written; "": nowhere
};

unsigned long long printable(std::uint64_t value) { return static_cast<unsigned long long>(value); }

/// Every subject on every problem of a family; the sampled ones on one problem in kSampled.
class Campaign {
 public:
  Campaign(const Arguments& arguments, Family family)
      : arguments_(arguments), family_(family), names_(subject_names()), always_(names_.size()) {
    const std::vector<std::string> sampled = sampled_subject_names();
    names_.insert(names_.end(), sampled.begin(), sampled.end());
    if (!arguments.subject.empty()) {
      std::erase_if(names_, [&](const std::string& name) { return name.find(arguments.subject) == std::string::npos; });
      always_ = names_.size();
    }
    counts_ = std::vector<std::array<std::uint64_t, kOutcomes>>(names_.size());
  }

  /// Whether nothing contradicts the truth, and little is left unresolved.
  bool holds() {
    std::vector<std::thread> threads;
    for (int job = 0; job < arguments_.jobs; ++job) threads.emplace_back([this] { work(); });
    for (std::thread& thread : threads) thread.join();
    print();
    const bool may_be = family_ == Family::kRank;
    const bool too_many_unresolved = !may_be && kMostUnresolved * unresolved_ > arguments_.problems;
    if (too_many_unresolved) std::printf("the evaluation left more than 1 %% of a family unresolved\n");
    return contradictions_ == 0 && !too_many_unresolved;
  }

 private:
  void work() {
    std::vector<std::unique_ptr<Subject>> subjects;  // they live through all problems
    for (const std::string& name : names_) subjects.push_back(make_subject(name));
    for (std::uint64_t k = next_++; k < arguments_.problems; k = next_++) meet_all(arguments_.first + k, subjects);
  }

  void meet_all(std::uint64_t index, const std::vector<std::unique_ptr<Subject>>& subjects) {
    const std::uint64_t round = index / kinds(family_).size();
    // Of each kind in turn: half are loaded, a quarter updated, a quarter started anywhere.
    const Approach approach = round % 4 == 1 ? Approach::kUpdate : round % 4 == 3 ? Approach::kStart : Approach::kLoad;
    Target target(generate(family_, arguments_.seed, index), approach);
    std::vector<Outcome> outcomes(subjects.size(), Outcome::kRefused);
    for (std::size_t s = 0; s < subjects.size(); ++s) {
      if (s >= always_ && (round + s) % kSampled != 0) continue;
      std::string detail;
      try {
        outcomes[s] = subjects[s]->meet(target, kTimeLimit_s, detail);
      } catch (const std::exception& error) {
        outcomes[s] = Outcome::kCrashed;
        detail = std::string("threw ") + error.what();
      }
      if (contradiction(outcomes[s])) keep(target.problem, names_[s], outcomes[s], detail);
    }
    const std::scoped_lock lock(mutex_);
    count(target, outcomes);
  }

  void count(const Target& target, const std::vector<Outcome>& outcomes) {
    const bool unsolvable = target.truth.truth == Truth::kUnsolvable;
    const bool nearly = target.passes && unsolvable;
    solvable_ += target.truth.truth == Truth::kSolvable ? 1 : 0;
    unsolvable_ += unsolvable ? 1 : 0;
    nearly_ += nearly ? 1 : 0;
    unresolved_ += target.unresolved ? 1 : 0;
    for (std::size_t s = 0; s < outcomes.size(); ++s) {
      const bool said = outcomes[s] == Outcome::kUnsolvable || outcomes[s] == Outcome::kUnsolvableNoProof;
      const Outcome outcome = nearly && said ? Outcome::kNearlyUnsolvable : outcomes[s];
      ++counts_[s][static_cast<std::size_t>(outcome)];
    }
  }

  void keep(const Problem& problem, const std::string& subject, Outcome outcome, const std::string& detail) {
    const std::scoped_lock lock(mutex_);
    ++contradictions_;
    std::fprintf(stderr, "%s, %s: %s: %s\n", problem.name().c_str(), subject.c_str(), to_string(outcome),
                 detail.c_str());
    if (arguments_.out.empty()) return;
    try {
      write_problem(problem, arguments_.out / (problem.name() + ".json"));
    } catch (const InputError&) {
      // A given G* that rounding made indefinite may be no file: --first and the index draw it again.
    }
  }

  void print() const {
    std::printf(
        "%s: %llu problems, seed %llu: %llu solvable, %llu unsolvable (%llu nearly solvable), %llu unresolved\n",
        to_string(family_), printable(arguments_.problems), printable(arguments_.seed), printable(solvable_),
        printable(unsolvable_), printable(nearly_), printable(unresolved_));
    for (std::size_t s = 0; s < names_.size(); ++s) {
      std::printf("  %-20s", names_[s].c_str());
      for (std::size_t o = 0; o < kOutcomes; ++o) {
        const auto outcome = static_cast<Outcome>(o);
        if (counts_[s][o] == 0) continue;
        std::printf(" %s%s %llu", contradiction(outcome) ? "! " : "", to_string(outcome), printable(counts_[s][o]));
      }
      std::printf("\n");
    }
  }

  const Arguments& arguments_;
  Family family_;
  std::vector<std::string> names_;
  std::size_t always_;  ///< the subjects behind these are sampled
  std::atomic<std::uint64_t> next_ = 0;
  std::mutex mutex_;
  std::vector<std::array<std::uint64_t, kOutcomes>> counts_;  ///< by subject
  std::uint64_t solvable_ = 0, unsolvable_ = 0, nearly_ = 0, unresolved_ = 0, contradictions_ = 0;
};

int attack(const Arguments& arguments) {
  if (!arguments.out.empty()) std::filesystem::create_directories(arguments.out);
  bool holds = true;
  for (const Family family : kFamilies) {
    if (arguments.family != "all" && arguments.family != to_string(family)) continue;
    Campaign campaign(arguments, family);
    holds = campaign.holds() && holds;
  }
  return holds ? 0 : 1;
}

}  // namespace
}  // namespace lcpbench::attack

int main(int argc, char** argv) {
  lcpbench::attack::Arguments arguments;
  CLI::App app(
      "Attacks the native solvers, certify and the evaluation with nasty small problems of known truth.\n"
      "Exit code: 0, no contradiction; 1, contradictions; 2, usage.");
  app.add_option("--kind", arguments.family, "lcp, mixed, contact, soft, doubtful, rank, rows, limits or all")
      ->check(CLI::IsMember({"lcp", "mixed", "contact", "soft", "doubtful", "rank", "rows", "limits", "all"}));
  app.add_option("--problems", arguments.problems, "number of problems of each kind");
  app.add_option("--first", arguments.first, "index of the first problem");
  app.add_option("--subject", arguments.subject, "only what is under test and has this in its name, on every problem");
  app.add_option("--seed", arguments.seed, "seed");
  app.add_option("--jobs", arguments.jobs, "threads")->check(CLI::Range(1, 256));
  app.add_option("--out", arguments.out, "folder for the problems of contradictions");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return lcpbench::attack::attack(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "attack: %s\n", error.what());
    return 3;
  }
}
