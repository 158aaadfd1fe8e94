// The share of problems that Lemke solves over the paper's grid of 81 tolerances, by the paper's criterion, counting
// only answers that the solver claims as solved.
//
//   lemke_paper_rates SET TRIALS [SEED [SETTINGS]]      SETTINGS: engine=dense,update=incremental,...
//
// Prints worst, average and best cell, then the grid: a row for each pivot tolerance, a column for each zero tolerance.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "core/settings.h"
#include "core/spec.h"
#include "generators/sets.h"
#include "native/lemke.h"
#include "study/evaluation/evaluation.h"

namespace {

using namespace lcpbench;

constexpr int kSteps = 9;  // 1e-20, 1e-18, ... 1e-4

std::vector<std::unique_ptr<Lemke>> grid_of_solvers(LemkeSettings settings) {
  std::vector<std::unique_ptr<Lemke>> solvers;
  for (int pivot = 0; pivot < kSteps; ++pivot) {
    for (int zero = 0; zero < kSteps; ++zero) {
      settings.pivot_tolerance = std::pow(10.0, -20 + 2 * pivot);
      settings.zero_tolerance = std::pow(10.0, -20 + 2 * zero);
      solvers.push_back(std::make_unique<Lemke>(settings));
    }
  }
  return solvers;
}

void print(const std::vector<long>& solved, std::int64_t trials) {
  std::vector<double> rates;
  double sum = 0;
  for (const long count : solved) {
    rates.push_back(100.0 * static_cast<double>(count) / static_cast<double>(trials));
    sum += rates.back();
  }
  const auto [worst, best] = std::minmax_element(rates.begin(), rates.end());
  const auto at = static_cast<int>(best - rates.begin());
  std::printf("worst %.2f average %.2f best %.2f (pivot 1e%d, zero 1e%d)\n", *worst, sum / (kSteps * kSteps), *best,
              -20 + 2 * (at / kSteps), -20 + 2 * (at % kSteps));
  for (std::size_t cell = 0; cell < rates.size(); ++cell) {
    std::printf("%7.2f%s", rates[cell], (cell + 1) % kSteps == 0 ? "\n" : "");
  }
}

void measure(const std::string& name, std::int64_t trials, std::uint64_t seed, const std::string& settings) {
  const auto set = open_set(name);
  const Spec spec = parse_spec("lemke" + (settings.empty() ? std::string() : "{" + settings + "}"));
  const auto solvers = grid_of_solvers(parse_settings<LemkeSettings>(spec.name, spec.options));
  std::vector<long> solved(solvers.size(), 0);
  Answer answer;
  Vector last;
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    const Problem problem = set->generate(seed, trial);
    Evaluator evaluator(problem);
    bool last_passed = false;
    last.resize(0);
    for (std::size_t cell = 0; cell < solvers.size(); ++cell) {
      solvers[cell]->load(problem);
      solvers[cell]->solve({}, answer);
      if (answer.claim != Claim::kSolved) continue;
      if (last.size() != answer.z.size() || last != answer.z) {
        last_passed = evaluator.errors(answer).criterion;
        last = answer.z;
      }
      if (last_passed) ++solved[cell];
    }
  }
  std::printf("%s, %s, %lld trials: ", set->name().c_str(), spec.text().c_str(), static_cast<long long>(trials));
  print(solved, trials);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 5) {
    std::fprintf(stderr, "usage: lemke_paper_rates SET TRIALS [SEED [SETTINGS]]\n");
    return 2;
  }
  try {
    measure(argv[1], std::max(1L, std::atol(argv[2])), argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1,
            argc > 4 ? argv[4] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
