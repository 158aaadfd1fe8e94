// The share of problems that Lemke solves over the paper's grid of 81 tolerances, by the paper's criterion: of the
// answers that the solver claims as solved, and of all that it returns.
//
//   lemke_paper_rates SET TRIALS [SEED [SETTINGS [FIRST]]]      SETTINGS: engine=dense,update=incremental,...
//
// Prints for both counts worst, average and best cell, then the grid: a row for each pivot tolerance, a column for each
// zero tolerance.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/settings.h"
#include "core/spec.h"
#include "generators/sets.h"
#include "native/lemke/lemke_sweep.h"
#include "study/evaluation/evaluation.h"

namespace {

using namespace lcpbench;

constexpr int kSteps = 9;  // 1e-20, 1e-18, ... 1e-4

std::vector<LemkeSettings> paper_grid(LemkeSettings settings) {
  std::vector<LemkeSettings> cells;
  for (int pivot = 0; pivot < kSteps; ++pivot) {
    for (int zero = 0; zero < kSteps; ++zero) {
      settings.pivot_tolerance = std::pow(10.0, -20 + 2 * pivot);
      settings.zero_tolerance = std::pow(10.0, -20 + 2 * zero);
      cells.push_back(settings);
    }
  }
  return cells;
}

/// The answers of all cells to a problem: as one sweep where the engine can, else one by one.
class Grid {
 public:
  explicit Grid(const LemkeSettings& settings) {
    const auto cells = paper_grid(settings);
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
      tries_.push_back({i, std::numeric_limits<double>::infinity()});
      if (settings.engine != LemkeEngine::kKernel) solvers_.push_back(std::make_unique<Lemke>(cells[i]));
    }
    if (settings.engine == LemkeEngine::kKernel) sweep_ = std::make_unique<LemkeSweep>(cells);
  }

  const std::vector<LemkeLeaf>& solve(const Problem& problem) {
    if (sweep_ != nullptr) {
      sweep_->load(problem);
      sweep_->walk(tries_, leaves_);
      return leaves_;
    }
    leaves_.resize(solvers_.size());
    for (std::size_t i = 0; i < solvers_.size(); ++i) {
      leaves_[i].cells = {static_cast<std::uint32_t>(i)};
      solvers_[i]->load(problem);
      solvers_[i]->solve({}, leaves_[i].answer);
    }
    return leaves_;
  }

 private:
  std::vector<LemkeTry> tries_;
  std::unique_ptr<LemkeSweep> sweep_;
  std::vector<std::unique_ptr<Lemke>> solvers_;
  std::vector<LemkeLeaf> leaves_;
};

void print(const char* counted, const std::vector<long>& solved, std::int64_t trials) {
  std::vector<double> rates;
  double sum = 0;
  for (const long count : solved) {
    rates.push_back(100.0 * static_cast<double>(count) / static_cast<double>(trials));
    sum += rates.back();
  }
  const auto [worst, best] = std::minmax_element(rates.begin(), rates.end());
  const auto at = static_cast<int>(best - rates.begin());
  std::printf("%s: worst %.2f average %.2f best %.2f (pivot 1e%d, zero 1e%d)\n", counted, *worst,
              sum / (kSteps * kSteps), *best, -20 + 2 * (at / kSteps), -20 + 2 * (at % kSteps));
  for (std::size_t cell = 0; cell < rates.size(); ++cell) {
    std::printf("%7.2f%s", rates[cell], (cell + 1) % kSteps == 0 ? "\n" : "");
  }
}

void measure(const std::string& name, std::int64_t trials, std::uint64_t seed, const std::string& settings,
             std::int64_t first) {
  const auto set = open_set(name);
  const Spec spec = parse_spec("lemke" + (settings.empty() ? std::string() : "{" + settings + "}"));
  Grid grid(parse_settings<LemkeSettings>(spec.name, spec.options));
  std::vector<long> solved(kSteps * kSteps, 0);
  std::vector<long> passed(kSteps * kSteps, 0);
  long at_limit = 0;
  Vector last;
  for (std::int64_t trial = first; trial < first + trials; ++trial) {
    const Problem problem = set->generate(seed, trial);
    Evaluator evaluator(problem);
    bool last_passed = false;
    last.resize(0);
    for (const LemkeLeaf& leaf : grid.solve(problem)) {
      const auto cells = static_cast<long>(leaf.cells.size());
      if (leaf.answer.claim == Claim::kIterationLimit) at_limit += cells;
      if (last.size() != leaf.answer.z.size() || last != leaf.answer.z) {
        last_passed = evaluator.errors(leaf.answer).criterion;
        last = leaf.answer.z;
      }
      for (const std::uint32_t cell : leaf.cells) {
        passed[cell] += last_passed ? 1 : 0;
        solved[cell] += last_passed && leaf.answer.claim == Claim::kSolved ? 1 : 0;
      }
    }
  }
  std::printf("%s, %s, %lld trials, %ld of the runs at the limit on pivots\n", set->name().c_str(), spec.text().c_str(),
              static_cast<long long>(trials), at_limit);
  print("claimed as solved", solved, trials);
  print("whatever is claimed", passed, trials);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 6) {
    std::fprintf(stderr, "usage: lemke_paper_rates SET TRIALS [SEED [SETTINGS [FIRST]]]\n");
    return 2;
  }
  try {
    measure(argv[1], std::max(1L, std::atol(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1,
            argc > 4 ? argv[4] : "", argc > 5 ? std::max(0L, std::atol(argv[5])) : 0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
