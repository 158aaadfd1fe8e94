#include "study/report/decision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "study/report/conditioning.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kSignificance = 0.05;

/// A contender with its outcomes, in the order of (set, problem).
struct Record {
  Contender contender;
  std::size_t sets = 0;   ///< in which it met problems
  bool eligible = false;  ///< may be recommended
  std::vector<std::pair<std::size_t, const Outcome*>> outcomes;
};

/// Without the sets that less than half as many solvers met as met the most popular one: those of a sweep or of a
/// special question, which would leave no solver that met all.
std::vector<std::size_t> widely_met(const Summary& summary, std::vector<std::size_t> sets) {
  std::size_t most = 0;
  for (const std::size_t set : sets) most = std::max(most, drawn_cells(summary, set).size());
  std::erase_if(sets, [&](std::size_t set) { return 2 * drawn_cells(summary, set).size() < most; });
  return sets;
}

/// A step along a dial of conditioning, with a section of its own, and no situation that a user is in.
bool is_dialled(const std::string& set) {
  const std::optional<ConditionDial> dial = condition_dial(set);
  return dial && dial->by_option;
}

std::vector<std::size_t> sets_where(const Summary& summary, bool (*wanted)(const SetSummary&)) {
  std::vector<std::size_t> all;
  std::vector<std::size_t> solvable;
  for (std::size_t i = 0; i < summary.sets.size(); ++i) {
    const SetSummary& set = summary.sets[i];
    if (!set.contact || is_hard_set(set.name) || is_dialled(set.name) || !wanted(set)) continue;
    all.push_back(i);
    if (set.all_solvable) solvable.push_back(i);
  }
  return widely_met(summary, solvable.empty() ? all : solvable);
}

std::string scope_of(const Summary& summary, const std::vector<std::size_t>& sets) {
  std::int64_t problems = 0;
  std::string names;
  for (const std::size_t set : sets) {
    problems += summary.sets[set].problems;
    names += (names.empty() ? "" : ", ") + code(summary.sets[set].name);
  }
  return sets.empty() ? "" : counted(problems, "problem") + ": " + names;
}

std::vector<Record> records_of(const Summary& summary, const std::vector<std::size_t>& sets) {
  std::map<std::size_t, Record> by_solver;
  for (const std::size_t set : sets) {
    for (const Cell* cell : drawn_cells(summary, set)) {
      Record& record = by_solver[cell->solver];
      Contender& contender = record.contender;
      ++record.sets;
      const std::int64_t taken = cell->trials - cell->count(Claim::kUnsupported);
      contender.solver = cell->solver;
      contender.trials += taken;
      contender.solved.part += cell->count(Verdict::kSolved);
      contender.solved.whole +=
          taken - cell->unsolvable_problems + cell->count(Claim::kUnsupported, Verdict::kUnsolvable);
      contender.false_claims.part += cell->false_claims();
      contender.crashed.part += cell->count(Claim::kCrashed);
      for (const Outcome& outcome : cell->outcomes) record.outcomes.emplace_back(set, &outcome);
    }
  }
  std::vector<Record> records;
  for (auto& [solver, record] : by_solver) {
    record.contender.false_claims.whole = record.contender.trials;
    record.contender.crashed.whole = record.contender.trials;
    records.push_back(std::move(record));
  }
  return records;
}

/// Calls visit(a, b) for every problem that both met.
template <class Visit>
void for_each_pair(const Record& a, const Record& b, Visit visit) {
  const auto key = [](const auto& outcome) { return std::pair(outcome.first, outcome.second->problem); };
  auto other = b.outcomes.begin();
  for (const auto& outcome : a.outcomes) {
    while (other != b.outcomes.end() && key(*other) < key(outcome)) ++other;
    if (other == b.outcomes.end()) return;
    if (key(*other) == key(outcome)) visit(*outcome.second, *other->second);
  }
}

/// Time of `a` over time of `b` on the problems that both solved; NaN where there are none.
Estimate time_ratio(const Record& a, const Record& b) {
  std::vector<double> own;
  std::vector<double> others;
  for_each_pair(a, b, [&](const Outcome& left, const Outcome& right) {
    if (!left.solved || !right.solved || std::isnan(left.time_s) || std::isnan(right.time_s)) return;
    own.push_back(left.time_s);
    others.push_back(right.time_s);
  });
  return ratio_of_sums(own, others);
}

void measure_errors(Record& record) {
  std::vector<double> errors;
  for (const auto& [set, outcome] : record.outcomes) {
    if (!outcome->claimed) continue;
    errors.push_back(std::isnan(outcome->error) ? std::numeric_limits<double>::infinity() : outcome->error);
  }
  std::sort(errors.begin(), errors.end());
  record.contender.median_error = median(errors);
  record.contender.p99_error = quantile(errors, 0.99);
}

void measure_times(const Record* reference, Record& record) {
  std::vector<double> times;
  for (const auto& [set, outcome] : record.outcomes) {
    if (!std::isnan(outcome->time_s)) times.push_back(outcome->time_s);
  }
  record.contender.time = median_estimate(times);
  record.contender.speedup = reference == nullptr ? Estimate{kNone, kNone, kNone} : time_ratio(*reference, record);
}

/// Does `a` show `property` on significantly more of the common problems than `b`?
bool significantly_more(const Record& a, const Record& b, bool Outcome::*property) {
  std::int64_t only_a = 0;
  std::int64_t only_b = 0;
  for_each_pair(a, b, [&](const Outcome& left, const Outcome& right) {
    if (left.*property && !(right.*property)) ++only_a;
    if (right.*property && !(left.*property)) ++only_b;
  });
  return only_a > only_b && sign_test(only_a, only_b) < kSignificance;
}

bool as_reliable(const Record& record, const Record& best) {
  return !significantly_more(best, record, &Outcome::solved) &&
         !significantly_more(record, best, &Outcome::false_claim);
}

double median_time(const Record& record) {
  const double value = record.contender.time.value;
  return std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
}

/// The solver whose share solved is the surest to be high; nullptr where none solved anything.
const Record* most_solving(const std::vector<Record>& records) {
  const Record* most = nullptr;
  for (const Record& record : records) {
    if (!record.eligible || record.contender.solved.part == 0) continue;
    if (most == nullptr || record.contender.solved.interval().low > most->contender.solved.interval().low)
      most = &record;
  }
  return most;
}

const Record* choose(const std::vector<Record>& records) {
  const Record* most = most_solving(records);
  if (most == nullptr) return nullptr;
  const Record* fastest = most;
  for (const Record& record : records) {
    if (!record.eligible || !as_reliable(record, *most)) continue;
    if (median_time(record) < median_time(*fastest)) fastest = &record;
  }
  return fastest;
}

std::string time_words(const Estimate& ratio) {
  if (std::isnan(ratio.value)) return "no time to compare";
  if (is_tie_in_time(ratio)) return "about as fast";
  return ratio.value > 1 ? factor(ratio.value) + "× slower" : "faster in total, slower in the median";
}

/// The gravest thing to say of a solver that is not the recommended one, without the size of its sample.
std::string gravest(const Record& record, const Record* chosen) {
  const Contender& contender = record.contender;
  const std::string unsolved = "left " + percent(1 - contender.solved.value()) + " unsolved";
  const std::string misled = "said solved and was wrong on " + percent(contender.false_claims.value());
  const std::string solved = "solved " + percent(contender.solved.value());
  if (!contender.complete) {
    return "met only some of these sets; there " + (contender.false_claims.part > 0 ? misled : solved);
  }
  if (chosen == nullptr) return contender.false_claims.part > 0 ? misled : unsolved;
  if (significantly_more(record, *chosen, &Outcome::false_claim)) return misled;
  if (significantly_more(*chosen, record, &Outcome::solved)) {
    const bool mostly_crashes = 2 * contender.crashed.part > contender.solved.whole - contender.solved.part;
    const std::string failed = mostly_crashes ? "crashed on " + percent(contender.crashed.value()) : unsolved;
    return contender.false_claims.part > 0 ? failed + ", " + misled : failed;
  }
  const std::string time = time_words(time_ratio(record, *chosen));
  if (!record.eligible) return contender.false_claims.part > 0 ? misled : solved + ", " + time;
  if (contender.tie) return "a tie";
  if (median_time(record) < median_time(*chosen)) return "faster, but solves fewer than the best";
  return "as reliable, " + time;
}

std::string why_not(const Record& record, const Record* chosen) {
  const std::string sample = record.contender.sampled ? " (" + counted(record.contender.trials, "problem") + ")" : "";
  return gravest(record, chosen) + sample;
}

bool is_tie(const Record& record, const Record& chosen) {
  return record.eligible && as_reliable(record, chosen) && is_tie_in_time(time_ratio(record, chosen));
}

void sort_contenders(std::vector<Contender>& contenders, std::optional<std::size_t> chosen_solver) {
  const auto number_or_last = [](double value) { return std::isnan(value) ? 1e300 : value; };
  std::sort(contenders.begin(), contenders.end(), [&](const Contender& a, const Contender& b) {
    const auto key = [&](const Contender& contender) {
      return std::tuple(contender.solver != chosen_solver, !contender.complete,
                        number_or_last(-contender.solved.value()), number_or_last(contender.time.value),
                        contender.solver);
    };
    return key(a) < key(b);
  });
}

/// Who met how much of `sets`, and so may be recommended.
void compare_samples(std::size_t sets, std::vector<Record>& records) {
  std::int64_t most_trials = 0;
  for (const Record& record : records) most_trials = std::max(most_trials, record.contender.trials);
  for (Record& record : records) {
    record.contender.complete = record.sets == sets;
    record.contender.sampled = record.contender.trials < most_trials;
    record.eligible = record.contender.complete && 2 * record.contender.trials >= most_trials;
  }
}

Situation judge(const Summary& summary, std::string title, std::vector<std::size_t> sets) {
  Situation situation{std::move(title), scope_of(summary, sets), std::move(sets), {}, std::nullopt};
  std::vector<Record> records = records_of(summary, situation.sets);
  compare_samples(situation.sets.size(), records);
  const auto reference = std::find_if(records.begin(), records.end(), [&summary](const Record& record) {
    return summary.solvers[record.contender.solver].text() == summary.reference;
  });
  for (Record& record : records) {
    measure_times(reference == records.end() ? nullptr : &*reference, record);
    measure_errors(record);
  }
  const Record* chosen = choose(records);
  for (Record& record : records) {
    if (&record == chosen) continue;
    record.contender.tie = chosen != nullptr && is_tie(record, *chosen);
    record.contender.verdict = why_not(record, chosen);
  }
  for (const Record& record : records) situation.contenders.push_back(record.contender);
  std::optional<std::size_t> chosen_solver;
  if (chosen != nullptr) chosen_solver = chosen->contender.solver;
  sort_contenders(situation.contenders, chosen_solver);
  if (chosen != nullptr) situation.recommended = 0;
  return situation;
}

std::vector<std::size_t> ill_conditioned_sets(const Summary& summary) {
  const auto frictional =
      sets_where(summary, [](const SetSummary& set) { return set.ill_conditioned && set.frictional; });
  if (!frictional.empty()) return frictional;
  return sets_where(summary, [](const SetSummary& set) { return set.ill_conditioned && !set.frictional; });
}

std::string ill_conditioned_title(const Summary& summary, const std::vector<std::size_t>& sets) {
  if (sets.empty()) return "Ill-conditioned";
  return summary.sets[sets.front()].frictional ? "Ill-conditioned, frictional" : "Ill-conditioned, frictionless";
}

double mean_rate(const std::vector<const Cell*>& cells) {
  double total = 0;
  double counted_cells = 0;
  for (const Cell* cell : cells) {
    if (std::isnan(cell->rate())) continue;
    total += cell->rate();
    counted_cells += 1;
  }
  return total / counted_cells;
}

const Situation* most_telling(const std::vector<Situation>& situations) {
  for (const std::size_t preferred : {std::size_t{1}, std::size_t{2}, std::size_t{0}}) {
    if (situations[preferred].recommended) return &situations[preferred];
  }
  return nullptr;
}

/// Names the solver whose false claims are the surest: by the lower end of their interval.
std::string warning_on(const Summary& summary, const Situation& situation) {
  const Contender* worst = nullptr;
  for (const Contender& contender : situation.contenders) {
    if (worst == nullptr || contender.false_claims.interval().low > worst->false_claims.interval().low) {
      worst = &contender;
    }
  }
  if (worst == nullptr || worst->false_claims.part == 0) return "No solver here said solved and was wrong.";
  return fmt::format("Trust no status code: {} said solved and was wrong on {} ({}) of {}.",
                     code(summary.solvers[worst->solver].text()), percent(worst->false_claims.value()),
                     percent_range(worst->false_claims.interval()), counted(worst->trials, "problem"));
}

/// What a store is for that has no set to recommend a solver on.
std::string answer_without_situations(const Summary& summary) {
  const auto hard = std::count_if(summary.sets.begin(), summary.sets.end(),
                                  [](const SetSummary& set) { return is_hard_set(set.name); });
  if (hard == 0)
    return "This store has no random contact problems, so it recommends no solver; what it has stands below.";
  return fmt::format(
      "This store holds {}, chosen to break solvers: no share of them recommends one. "
      "<a href=\"#hard\">Who is right on which</a>.",
      counted(hard, "hard case"));
}

}  // namespace

double Share::value() const { return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : kNone; }

Interval Share::interval() const { return wilson(part, whole); }

std::vector<Situation> decide(const Summary& summary) {
  const auto frictionless =
      sets_where(summary, [](const SetSummary& set) { return !set.frictional && !set.ill_conditioned; });
  const auto frictional =
      sets_where(summary, [](const SetSummary& set) { return set.frictional && !set.ill_conditioned; });
  const auto ill_conditioned = ill_conditioned_sets(summary);
  return {judge(summary, "Frictionless", frictionless), judge(summary, "Frictional", frictional),
          judge(summary, ill_conditioned_title(summary, ill_conditioned), ill_conditioned)};
}

std::set<std::size_t> reliable_solvers(const Summary& summary, std::size_t set) {
  std::vector<Record> records = records_of(summary, {set});
  compare_samples(1, records);
  const Record* most = most_solving(records);
  std::set<std::size_t> reliable;
  for (const Record& record : records) {
    if (most != nullptr && record.eligible && as_reliable(record, *most)) reliable.insert(record.contender.solver);
  }
  return reliable;
}

std::map<std::size_t, std::size_t> recommended_by_set(const std::vector<Situation>& situations) {
  std::map<std::size_t, std::size_t> recommended;
  for (const Situation& situation : situations) {
    if (!situation.recommended) continue;
    for (const std::size_t set : situation.sets) {
      recommended[set] = situation.contenders[*situation.recommended].solver;
    }
  }
  return recommended;
}

std::optional<std::size_t> headline_set(const Summary& summary) {
  std::optional<std::size_t> hardest;
  std::pair<bool, double> lowest{};
  for (std::size_t i = 0; i < summary.sets.size(); ++i) {
    const SetSummary& set = summary.sets[i];
    const auto cells = drawn_cells(summary, i);
    if (cells.empty() || is_hard_set(set.name) || is_dialled(set.name)) continue;
    if (set.name == "paper/copositive/exp5-1e8") return i;
    const double rate = mean_rate(cells);
    const std::pair<bool, double> key{!set.frictional, std::isnan(rate) ? 2 : rate};
    if (!hardest || key < lowest) {
      hardest = i;
      lowest = key;
    }
  }
  return hardest;
}

bool only_special_sets(const Summary& summary, const std::vector<Situation>& situations) {
  return !summary.cells.empty() && std::all_of(situations.begin(), situations.end(),
                                               [](const Situation& situation) { return situation.sets.empty(); });
}

std::string one_line_answer(const Summary& summary, const std::vector<Situation>& situations) {
  if (only_special_sets(summary, situations)) return answer_without_situations(summary);
  const Situation* situation = most_telling(situations);
  if (situation == nullptr) return "The store does not yet hold enough verified answers to recommend a solver.";
  const Contender& best = situation->contenders[*situation->recommended];
  std::string title = situation->title;
  title.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(title.front())));
  const char* alone = situation->contenders.size() == 1 ? " (the only solver here)" : "";
  std::string answer = fmt::format("For {} contacts: {}{}, which solved {} ({}) of {} in a median of {}", title,
                                   code(summary.solvers[best.solver].text()), alone, percent(best.solved.value()),
                                   percent_range(best.solved.interval()), counted(best.solved.whole, "problem"),
                                   duration(best.time.value));
  const bool is_reference = summary.solvers[best.solver].text() == summary.reference;
  if (!is_reference && std::isfinite(best.speedup.value)) {
    answer += fmt::format(", {} the dense reference", speed_against(1 / best.speedup.value));
  }
  if (!std::isnan(best.p99_error)) {
    answer += fmt::format("; the error ρ of 99 % of its answers is at most {}", scientific(best.p99_error));
  }
  return answer + ". " + warning_on(summary, *situation);
}

}  // namespace lcpbench::report
