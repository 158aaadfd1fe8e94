// What it saves to walk the paper's 81 pairs of tolerances as one tree instead of running them one by one, and how much
// dearer a pivot of the tree is.
//
//   lemke_sweep_benchmark SET PROBLEMS [SEED [SETTINGS]]      SETTINGS of lemke: cap=3n,update=incremental,...
//
// Times are thread CPU time of set-up and solve together, tree and runs in alternating order on each problem. Printed:
// the ratio of the summed times and of the pivots gone; and the time that the tree reports for a cell against that
// of the cell's own run, as the ratio of the sums (solve alone, paths that end at the limit on pivots left out) and as
// quantiles over cells and problems. The runs of one problem follow each other, so that all but the first find caches
// and branch prediction trained by the others: of one cell a problem, run before anything else, the ratios are given as
// well. Fails when an answer differs.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/isa.h"
#include "core/settings.h"
#include "core/spec.h"
#include "core/timed_solve.h"
#include "generators/sets.h"
#include "native/lemke/lemke_sweep.h"
#include "native/lemke/swept_answers.h"

namespace {

using namespace lcpbench;

std::vector<LemkeSettings> paper_grid(LemkeSettings settings) {
  std::vector<LemkeSettings> cells;
  for (int pivot = -20; pivot <= -4; pivot += 2) {
    for (int zero = -20; zero <= -4; zero += 2) {
      settings.pivot_tolerance = std::pow(10.0, pivot);
      settings.zero_tolerance = std::pow(10.0, zero);
      cells.push_back(settings);
    }
  }
  return cells;
}

struct Run {
  Answer answer;
  double solve_s = 0;
};

class Comparison {
 public:
  explicit Comparison(const std::vector<LemkeSettings>& cells) : sweep_(cells), runs_(cells.size()) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      solvers_.push_back(std::make_unique<Lemke>(cells[i]));
      tries_.push_back({static_cast<std::uint32_t>(i), std::numeric_limits<double>::infinity()});
    }
  }

  void compare(const Problem& problem, std::size_t trial) {
    const std::size_t first = 37 * trial % runs_.size();
    const double first_s = run(first, problem);
    const bool tree_first = trial % 2 == 0;
    if (tree_first) walk(problem);
    run_all(problem);
    if (!tree_first) walk(problem);
    for (const LemkeLeaf& leaf : leaves_) add(leaf, first, first_s);
    leaves_seen_ += static_cast<double>(leaves_.size());
    ++problems_;
  }

  void print(const std::string& set) {
    std::printf("%s, %s: %.0f problems, all answers equal; %.1f leaves\n", set.c_str(), to_string(isa_level()),
                problems_, leaves_seen_ / problems_);
    std::printf(
        "  pivots: tree %.1f, one by one %.1f, ratio %.1f; time: tree %.1f us, one by one %.1f us, ratio %.1f\n",
        pivots_tree_ / problems_, pivots_runs_ / problems_, pivots_runs_ / pivots_tree_, 1e6 * tree_s_ / problems_,
        1e6 * runs_s_ / problems_, runs_s_ / tree_s_);
    std::printf(
        "  a path's time in the tree / alone: sums %.2f, quantiles 10 %% %.2f, 50 %% %.2f, 90 %% %.2f; / alone and "
        "first: 10 %% %.2f, 50 %% %.2f, 90 %% %.2f; at the limit on pivots: sums %.2f\n",
        paths_s_ / solves_s_, quantile(dearer_, 0.1), quantile(dearer_, 0.5), quantile(dearer_, 0.9),
        quantile(dearer_than_first_, 0.1), quantile(dearer_than_first_, 0.5), quantile(dearer_than_first_, 0.9),
        extrapolated_s_ / limited_s_);
  }

 private:
  void walk(const Problem& problem) {
    const double begin = thread_cpu_clock_s();
    sweep_.load(problem);
    pivots_tree_ += static_cast<double>(sweep_.walk(tries_, leaves_));
    tree_s_ += thread_cpu_clock_s() - begin;
  }

  /// Returns the time of the solve.
  double run(std::size_t cell, const Problem& problem) {
    const double begin = thread_cpu_clock_s();
    solvers_[cell]->load(problem);
    const double loaded = thread_cpu_clock_s();
    solvers_[cell]->solve({}, runs_[cell].answer);
    const double end = thread_cpu_clock_s();
    last_run_s_ = end - begin;
    return end - loaded;
  }

  void run_all(const Problem& problem) {
    for (std::size_t cell = 0; cell < runs_.size(); ++cell) {
      runs_[cell].solve_s = run(cell, problem);
      runs_s_ += last_run_s_;
      pivots_runs_ += static_cast<double>(runs_[cell].answer.counters.pivots);
    }
  }

  void add(const LemkeLeaf& leaf, std::size_t first, double first_s) {
    const Counters& counters = leaf.answer.counters;
    for (const std::uint32_t cell : leaf.cells) {
      const Run& own = runs_[cell];
      if (!same_answer(own.answer, leaf.answer)) throw std::runtime_error("the tree's answer differs from its cell's");
      if (leaf.answer.claim == Claim::kIterationLimit) {
        extrapolated_s_ += leaf.cpu_s;
        limited_s_ += own.solve_s;
      } else if (counters.pivots > 0) {
        paths_s_ += leaf.cpu_s;
        solves_s_ += own.solve_s;
        dearer_.push_back(leaf.cpu_s / own.solve_s);
        if (cell == first) dearer_than_first_.push_back(leaf.cpu_s / first_s);
      }
    }
  }

  static double quantile(std::vector<double>& values, double share) {
    if (values.empty()) return std::nan("");
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }

  LemkeSweep sweep_;
  std::vector<std::unique_ptr<Lemke>> solvers_;
  std::vector<LemkeTry> tries_;
  std::vector<LemkeLeaf> leaves_;
  std::vector<Run> runs_;
  std::vector<double> dearer_, dearer_than_first_;
  double problems_ = 0, leaves_seen_ = 0, pivots_tree_ = 0, pivots_runs_ = 0;
  double tree_s_ = 0, runs_s_ = 0, paths_s_ = 0, solves_s_ = 0, extrapolated_s_ = 0, limited_s_ = 0;
  double last_run_s_ = 0;
};

void measure(const std::string& name, std::int64_t problems, std::uint64_t seed, const std::string& settings) {
  const auto set = open_set(name);
  const Spec spec = parse_spec("lemke" + (settings.empty() ? std::string() : "{" + settings + "}"));
  Comparison comparison(paper_grid(parse_settings<LemkeSettings>(spec.name, spec.options)));
  for (std::int64_t trial = 0; trial < problems; ++trial) {
    comparison.compare(set->generate(seed, trial), static_cast<std::size_t>(trial));
  }
  comparison.print(set->name() + ", " + spec.text());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: lemke_sweep_benchmark SET PROBLEMS [SEED [SETTINGS]]\n");
    return 2;
  }
  try {
    measure(argv[1], std::max(1L, std::atol(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1,
            argc > 4 ? argv[4] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
