// choices STORE COUNT: what choose() answers to random selections of sets, solvers and error, as JSON. page_test.py
// asks the page the same.

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "study/report/decision.h"
#include "study/report/report.h"
#include "study/report/sets.h"
#include "study/statistics/statistics.h"
#include "study/store/store.h"
#include "tests/support/bounded_draw.h"

namespace {

using lcpbench::report::Choice;
using Json = nlohmann::ordered_json;

/// A random part of `all`, in its order and not empty, of any size with the same chance.
std::vector<std::size_t> part_of(std::vector<std::size_t> all, lcpbench::BoundedDraw& draw) {
  const std::uint64_t wanted = 1 + draw.below(all.size());
  while (all.size() > wanted) all.erase(all.begin() + static_cast<std::ptrdiff_t>(draw.below(all.size())));
  return all;
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  lcpbench::Store store = lcpbench::Store::open_for_reading(argv[1]);
  const lcpbench::report::Report report = lcpbench::report::read_report(store);
  const auto label = [&report](std::size_t solver) { return lcpbench::report::solver_label(report.summary, solver); };
  std::vector<std::size_t> sets(report.summary.sets.size());
  for (std::size_t i = 0; i < sets.size(); ++i) sets[i] = i;
  const std::vector<std::size_t> solvers = lcpbench::report::single_solvers(report.summary);

  lcpbench::BoundedDraw draw(20261123);
  Json answers = Json::array();
  for (int i = 0; i < std::atoi(argv[2]); ++i) {
    const std::vector<std::size_t> of_sets = part_of(sets, draw);
    const std::vector<std::size_t> of_solvers = part_of(solvers, draw);
    const std::size_t error = draw.below(lcpbench::report::kErrors);
    const Choice choice = choose(report.statistics, of_sets, of_solvers, error);
    Json answer{{"sets", of_sets}, {"error", error}, {"recommended", choice.recommended}, {"plan", choice.plan_share}};
    for (const std::size_t solver : of_solvers) answer["solvers"].push_back(label(solver));
    answer["contenders"] = Json::array();
    for (const lcpbench::report::Contender& each : choice.contenders) {
      answer["contenders"].push_back(Json{{"solver", label(each.solver)},
                                      {"ground", to_string(each.ground)},
                                      {"tie", each.tie},
                                      {"solved", each.solved.part},
                                      {"of", each.solved.whole},
                                      {"low", number(each.solved.interval().low)},
                                      {"false", each.false_claims.part},
                                      {"time", number(each.time.value)},
                                      {"factor_n", each.factor.problems},
                                      {"factor", number(each.factor.ratio.value)},
                                      {"factor_low", number(each.factor.ratio.low)}});
    }
    answers.push_back(std::move(answer));
  }
  fmt::print("{}\n", answers.dump());
}
