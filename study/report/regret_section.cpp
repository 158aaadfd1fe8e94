#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/report/page.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr std::size_t kWorstShown = 10;

constexpr const char* kAboutRegret =
    "<section id=\"regret\"><h2>Regret of auto</h2>\n<p>The regret is the time of <code>auto</code> over that of the "
    "fastest solver of this store that claimed an answer of at most the target error on the same problem. 1 means that "
    "nothing here is faster. Every problem is in <code>tables/regret.csv</code>.</p>\n"
    "<details><summary>How to read the regret</summary>\n<ul>\n"
    "<li>At each target, <code>auto</code> is the one of the store with the largest stated error "
    "(<code>auto{error=T}</code>) up to the target. The error is ρ, and of bare LCPs the backward error.</li>\n"
    "<li>All solvers at single settings take part that solve the same friction model; native ones at the same "
    "instruction-set level. The fastest is known only afterwards, and its time is the least of many: equal solvers "
    "would have a regret above 1 by the noise of the clock alone.</li>\n"
    "<li>The interval of the geometric mean takes the problems for independent. Steps of one scene are not.</li>\n"
    "<li><em>Not reached</em>: some solver reached the target, and <code>auto</code> did not.</li>\n"
    "<li><em>Share of the loss</em>: of the sum of log(regret) at this target. The methods are those that "
    "<code>auto</code> ran, in a fixed order; several mean that some gave up, or that islands differ.</li>\n"
    "</ul>\n</details>\n";

std::string regret_target(double target) { return fmt::format("<th scope=\"row\">{:.0e}</th>", target); }

std::string regret_share(const Share& share) {
  return number_cell(share.value(), percent(share.value()), percent_range(share.interval()));
}

std::string regret_mean(const Estimate& mean) {
  const bool has_range = std::isfinite(mean.low);
  return number_cell(mean.value, factor(mean.value),
                     has_range ? fmt::format("{}–{}", factor(mean.low), factor(mean.high)) : "");
}

std::string regret_cells(const RegretStatistics& statistics) {
  return number_cell(static_cast<double>(statistics.problems), std::to_string(statistics.problems)) +
         regret_mean(statistics.geometric_mean) + number_cell(statistics.p99, factor(statistics.p99)) +
         number_cell(statistics.max, factor(statistics.max)) + regret_share(statistics.large) +
         number_cell(static_cast<double>(statistics.missed.part), std::to_string(statistics.missed.part),
                     percent_range(statistics.missed.interval())) +
         "</tr>\n";
}

std::vector<Column> regret_columns(std::vector<Column> first) {
  for (const char* heading : {"Problems", "Geometric mean", "99 %", "Largest", "Above 3", "Not reached"}) {
    first.push_back({heading, true});
  }
  return first;
}

std::vector<const Regret*> at_target(const RegretStudy& study, double target) {
  std::vector<const Regret*> regrets;
  for (const Regret& regret : study.regrets) {
    if (regret.target == target) regrets.push_back(&regret);
  }
  return regrets;
}

std::string regret_targets(const Report& report) {
  std::string rows;
  for (const RegretStatistics& statistics : report.regret.targets) {
    const std::vector<const Regret*> regrets = at_target(report.regret, statistics.target);
    rows += "<tr>" + regret_target(statistics.target) + "<td>" +
            (regrets.empty() ? "–" : code(solver_label(report.summary, regrets.front()->solver))) + "</td>" +
            regret_cells(statistics);
  }
  return table_head("cells", regret_columns({{"Target"}, {"With"}})) + rows + kTableEnd;
}

std::string regret_methods(const std::vector<MethodRegret>& methods) {
  std::vector<Column> columns = regret_columns({{"Methods that auto ran"}});
  columns.insert(columns.begin() + 1, {"Share of the loss", true});
  std::string rows;
  for (const MethodRegret& cost : methods) {
    const std::string share = std::isnan(cost.share_of_loss) ? "–" : percent(cost.share_of_loss);
    rows += "<tr><th scope=\"row\">" + escape(cost.methods) + "</th>" + number_cell(cost.share_of_loss, share) +
            regret_cells(cost.statistics);
  }
  return table_head("cells", columns) + rows + kTableEnd;
}

std::string regret_sets(const Summary& summary, double target, const std::vector<const Regret*>& regrets) {
  std::string rows;
  for (auto begin = regrets.begin(); begin != regrets.end();) {
    const std::size_t set = (*begin)->set;
    const auto end = std::find_if(begin, regrets.end(), [set](const Regret* each) { return each->set != set; });
    rows += "<tr><th scope=\"row\">" + code(summary.sets[set].name) + "</th>" +
            regret_cells(regret_statistics(target, {begin, end}));
    begin = end;
  }
  return table_head("cells", regret_columns({{"Set"}})) + rows + kTableEnd;
}

/// Those that `auto` did not reach first, then the largest regrets.
std::string worst_regrets(const Summary& summary, std::vector<const Regret*> regrets) {
  const auto badness = [](const Regret* regret) { return regret->reached() ? regret->value() : kInfinity; };
  std::stable_sort(regrets.begin(), regrets.end(),
                   [&](const Regret* a, const Regret* b) { return badness(a) > badness(b); });
  if (regrets.size() > kWorstShown) regrets.resize(kWorstShown);
  std::string rows;
  for (const Regret* regret : regrets) {
    rows += "<tr><th scope=\"row\">" + code(summary.sets[regret->set].name) +
            fmt::format("<small>seed {}, trial {}</small></th>", regret->seed, regret->trial);
    rows += regret->reached() ? number_cell(regret->value(), factor(regret->value()))
                              : number_cell(kInfinity, "<span class=\"bad\">not reached</span>");
    rows += number_cell(regret->time_s, duration(regret->time_s)) + "<td>" + escape(regret->methods) + "</td><td>" +
            code(solver_label(summary, regret->fastest)) + "</td>" +
            number_cell(regret->fastest_s, duration(regret->fastest_s)) + "</tr>\n";
  }
  return table_head("cells", {{"Problem"},
                              {"Regret", true},
                              {"auto", true},
                              {"Methods that auto ran"},
                              {"Fastest"},
                              {"Its time", true}}) +
         rows + kTableEnd;
}

}  // namespace

std::string regret_section(const Report& report) {
  const RegretStudy& study = report.regret;
  if (study.regrets.empty()) return "";
  std::string section = kAboutRegret + regret_targets(report);
  for (std::size_t i = 0; i < study.targets.size(); ++i) {
    const double target = study.targets[i].target;
    const std::vector<const Regret*> regrets = at_target(study, target);
    if (regrets.empty()) continue;
    section += fmt::format("<details><summary>At {:.0e}: methods, sets, and the worst problems</summary>\n", target) +
               regret_methods(study.methods[i]) + regret_sets(report.summary, target, regrets) +
               worst_regrets(report.summary, regrets) + "</details>\n";
  }
  return section + "</section>\n";
}

}  // namespace lcpbench::report
