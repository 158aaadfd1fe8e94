#include "study/report/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "study/output/text_table.h"
#include "study/report/text.h"
#include "study/run/trials.h"

namespace lcpbench {

namespace {

using Json = nlohmann::ordered_json;

/// Some trials of a set: those below `trials` that one of the steps divides.
struct Trials {
  std::int64_t trials = 0;
  std::vector<std::int64_t> every;

  auto operator<=>(const Trials&) const = default;
};

/// A solver on the problems of a set, whatever its version and level. Names as in the store.
struct Work {
  std::string set;
  std::string solver;  ///< SolverRow::text()
  std::string sweep;

  auto operator<=>(const Work&) const = default;
};

/// What all runs together plan: by work and seed, each with its cells per problem.
struct PlannedWork {
  std::int64_t cells = 1;
  std::map<std::uint64_t, std::set<Trials>> trials;
};

using Planned = std::map<Work, PlannedWork>;

/// The trials of any of the rules. Rules are in ascending order of their trials: from one number of trials to the next
/// the same ones hold.
std::int64_t count(const std::set<Trials>& rules) {
  std::int64_t planned = 0;
  std::int64_t from = 0;
  for (auto rule = rules.begin(); rule != rules.end(); ++rule) {
    if (rule->trials <= from) continue;
    std::vector<std::int64_t> steps;
    for (auto longer = rule; longer != rules.end(); ++longer) {
      steps.insert(steps.end(), longer->every.begin(), longer->every.end());
    }
    planned += count_trials(rule->trials, steps) - count_trials(from, steps);
    from = rule->trials;
  }
  return planned;
}

/// Adds what one run planned. @throws Json::exception for anything but what planned_cells() writes.
void add_plan(const Json& plan, Planned& planned) {
  const auto seed = plan.at("seed").get<std::uint64_t>();
  const Json& sets = plan.at("sets");
  for (const Json& solver : plan.at("solvers")) {
    for (const Json& part : solver.at("on")) {
      for (const Json& index : part.at("sets")) {
        const Json& set = sets.at(index.get<std::size_t>());
        Trials trials{set.at("trials").get<std::int64_t>(), part.at("every").get<std::vector<std::int64_t>>()};
        if (std::any_of(trials.every.begin(), trials.every.end(), [](std::int64_t step) { return step < 1; })) continue;
        PlannedWork& work = planned[{set.at("set").get<std::string>(), solver.at("solver").get<std::string>(),
                                     solver.at("sweep").get<std::string>()}];
        work.cells = solver.at("cells").get<std::int64_t>();
        work.trials[seed].insert(std::move(trials));
      }
    }
  }
}

/// nullopt where there is no run, or one that recorded no plan.
std::optional<Planned> read_plans(sqlite::Database& store, std::map<std::string, std::int64_t>& left_out) {
  sqlite::Statement query(store, "SELECT provenance FROM runs WHERE started <> ''");
  Planned planned;
  bool any = false;
  while (query.step()) {
    const Json provenance = Json::parse(query.text(0), nullptr, false);
    if (!provenance.is_object() || !provenance.contains("planned")) return std::nullopt;
    try {
      for (const Json& solver : provenance.value("skipped", Json())) left_out[solver.get<std::string>()] = 0;
      add_plan(provenance["planned"], planned);
    } catch (const Json::exception&) {
      return std::nullopt;
    }
    any = true;
  }
  return any ? std::optional(std::move(planned)) : std::nullopt;
}

/// Problems that each solver answered, by its work.
std::map<Work, std::int64_t> read_done(sqlite::Database& store) {
  sqlite::Statement query(store,
                          "SELECT s.name, v.name, v.settings, v.sweep, COUNT(DISTINCT a.problem_id) FROM answers a "
                          "JOIN problems p ON p.id = a.problem_id JOIN sets s ON s.id = p.set_id JOIN solvers v ON "
                          "v.id = a.solver_id WHERE a.part = 0 GROUP BY p.set_id, v.name, v.settings, v.sweep");
  std::map<Work, std::int64_t> done;
  while (query.step()) {
    SolverRow solver;
    solver.name = query.text(1);
    solver.settings = query.text(2);
    done[{std::string(query.text(0)), solver.text(), std::string(query.text(3))}] = query.integer(4);
  }
  return done;
}

double ratio(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double Coverage::Set::share() const { return ratio(done, planned); }
bool Coverage::Set::thin() const { return share() < kThinBelow; }
double Coverage::share() const { return ratio(done, planned); }

Coverage Coverage::part(const std::vector<std::string>& names) const {
  Coverage part;
  part.known = known;
  for (const Set& set : sets) {
    if (std::find(names.begin(), names.end(), set.name) == names.end()) continue;
    part.planned += set.planned;
    part.done += set.done;
    part.sets.push_back(set);
  }
  return part;
}

std::vector<Coverage::Set> Coverage::thin_sets() const {
  std::vector<Set> thin;
  std::copy_if(sets.begin(), sets.end(), std::back_inserter(thin), [](const Set& set) { return set.thin(); });
  std::stable_sort(thin.begin(), thin.end(), [](const Set& a, const Set& b) { return a.share() < b.share(); });
  return thin;
}

Json planned_cells(const Study& study) {
  Json sets = Json::array();
  for (const StudySet& set : study.sets) sets.push_back({{"set", set.set->name()}, {"trials", set.trials}});
  Json solvers = Json::array();
  std::int64_t cells = 0;
  for (const StudySolver& solver : study.solvers) {
    std::map<std::vector<std::int64_t>, Json> parts;  // sets by the steps of their trials
    for (std::size_t set = 0; set < solver.every.size(); ++set) {
      if (solver.every[set].empty()) continue;
      parts[solver.every[set]].push_back(set);
      cells += solver.cell_count() * count_trials(study.sets[set].trials, solver.every[set]);
    }
    Json on = Json::array();
    for (const auto& [every, indices] : parts) on.push_back({{"every", every}, {"sets", indices}});
    solvers.push_back({{"solver", solver.row.text()},
                       {"sweep", solver.row.sweep},
                       {"cells", solver.cell_count()},
                       {"on", std::move(on)}});
  }
  return {{"cells", cells}, {"seed", study.seed}, {"sets", std::move(sets)}, {"solvers", std::move(solvers)}};
}

Coverage coverage_of(sqlite::Database& store) {
  Coverage coverage;
  const std::optional<Planned> planned = read_plans(store, coverage.left_out);
  if (!planned) return coverage;
  coverage.known = true;
  const std::map<Work, std::int64_t> done = read_done(store);
  std::map<std::string, Coverage::Set, decltype(&natural_less)> sets(&natural_less);
  for (const auto& [work, plan] : *planned) {
    Coverage::Set& set = sets[work.set];
    set.name = work.set;
    std::int64_t cells = 0;
    for (const auto& [seed, rules] : plan.trials) cells += plan.cells * count(rules);
    const auto answered = done.find(work);
    const std::int64_t answers = answered == done.end() ? 0 : plan.cells * answered->second;
    set.planned += cells;
    set.done += answers;
    for (auto& [line, missing] : coverage.left_out) {
      if (line.starts_with(work.solver.substr(0, work.solver.find('{')) + ": ")) missing += cells - answers;
    }
  }
  std::erase_if(coverage.left_out, [](const auto& solver) { return solver.second == 0; });
  for (auto& [name, set] : sets) {
    coverage.planned += set.planned;
    coverage.done += set.done;
    coverage.sets.push_back(std::move(set));
  }
  return coverage;
}

namespace report {

namespace {

constexpr std::size_t kSetsInTheBox = 8;
constexpr std::size_t kSetsOnTheTerminal = 4;
constexpr const char* kUnknown =
    "How much of its plan this store covers is not known: a run in it recorded no plan, as runs of earlier versions "
    "did not.";

std::string cells_text(const Coverage& coverage) {
  return fmt::format("{} of {} cells", format_count(coverage.done), format_count(coverage.planned));
}

/// "these 3 sets are thin"
std::string thin_words(std::size_t thin, std::size_t sets) {
  return thin == sets && sets > 1 ? fmt::format("all {} sets are thin", sets)
         : thin == 1              ? "this set is thin"
                                  : fmt::format("these {} sets are thin", thin);
}

std::string left_out_text(const Coverage& coverage) {
  std::string text;
  for (const auto& [line, missing] : coverage.left_out) {
    text += fmt::format("{} planned cells are missing, and not failures, since a run left out {}\n",
                        format_count(missing), line);
  }
  return text;
}

}  // namespace

std::string plan_share_text(double share) {
  if (std::isnan(share)) return "–";
  const auto whole = static_cast<int>(std::floor(100 * share));
  return whole == 0 && share > 0 ? "<1 %" : fmt::format("{} %", whole);
}

std::string coverage_html(const Coverage& coverage) {
  if (!coverage.known) return "<p class=\"note\">" + std::string(kUnknown) + "</p>\n";
  if (!coverage.incomplete()) return "";
  std::string box = fmt::format(
      "<div class=\"alarm\" role=\"note\"><p><strong>{} of the plan.</strong> This store holds {} that its runs "
      "planned. The numbers below are of the problems that were met. To complete the study, repeat the "
      "<code>lcpbench run</code> that wrote it; where it was run in shards, merge their stores.</p>\n",
      plan_share_text(coverage.share()), cells_text(coverage));
  const std::vector<Coverage::Set> thin = coverage.thin_sets();
  if (!thin.empty()) {
    std::string names;
    for (const Coverage::Set& set : thin) {
      names += (names.empty() ? "" : ", ") + code(set.name) + " " + escape(plan_share_text(set.share()));
    }
    std::string words = thin_words(thin.size(), coverage.sets.size());
    words.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(words.front())));
    words += fmt::format(" (less than {:.0f} % of the planned cells are done)", 100 * kThinBelow);
    box += thin.size() <= kSetsInTheBox ? "<p>" + words + ": " + names + ".</p>\n"
                                        : "<details><summary>" + words + "</summary><p>" + names + "</p></details>\n";
  }
  if (!coverage.left_out.empty()) box += "<p>" + escape(left_out_text(coverage)) + "</p>\n";
  return box + "</div>\n";
}

std::string coverage_text(const Coverage& coverage) {
  if (!coverage.known) return std::string(kUnknown) + "\n";
  if (!coverage.incomplete()) return "";
  std::string text =
      fmt::format("INCOMPLETE: {} of the plan ({})", plan_share_text(coverage.share()), cells_text(coverage));
  const std::string remedy =
      left_out_text(coverage) +
      "To complete it, repeat the lcpbench run that wrote it; where it was run in shards, merge their stores.\n";
  const std::vector<Coverage::Set> thin = coverage.thin_sets();
  if (thin.empty()) return text + "\n" + remedy;
  text += fmt::format("; {}:\n", thin_words(thin.size(), coverage.sets.size()));
  const std::size_t shown = thin.size() <= kSetsOnTheTerminal ? thin.size() : kSetsOnTheTerminal - 1;
  for (std::size_t i = 0; i < shown; ++i) {
    text += fmt::format("  {:>5}  {}\n", plan_share_text(thin[i].share()), mended(thin[i].name));
  }
  if (shown < thin.size()) text += fmt::format("  and {} more sets\n", thin.size() - shown);
  return text + remedy;
}

std::string set_coverage(const Coverage& coverage, const std::string& set) {
  if (!coverage.known) return "";
  const auto found = std::find_if(coverage.sets.begin(), coverage.sets.end(),
                                  [&set](const Coverage::Set& each) { return each.name == set; });
  if (found == coverage.sets.end() || found->done >= found->planned) return "";
  return plan_share_text(found->share()) + " of its planned cells are done";
}

nlohmann::ordered_json coverage_json(const Coverage& coverage) {
  nlohmann::ordered_json sets = nlohmann::ordered_json::array();
  for (const Coverage::Set& set : coverage.sets) {
    sets.push_back({{"set", set.name},
                    {"planned", set.planned},
                    {"done", set.done},
                    {"share", set.share()},
                    {"thin", set.thin()}});
  }
  const auto known = [&coverage](std::int64_t count) { return coverage.known ? Json(count) : Json(); };
  return {{"planned", known(coverage.planned)},
          {"done", known(coverage.done)},
          {"share", coverage.known ? Json(coverage.share()) : Json()},
          {"left_out", coverage.left_out},
          {"thin_below", kThinBelow},
          {"sets", std::move(sets)}};
}

}  // namespace report

}  // namespace lcpbench
