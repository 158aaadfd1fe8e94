#include "study/report/decision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include <fmt/format.h>

#include "study/report/coverage_text.h"
#include "study/report/figures.h"
#include "study/report/hard.h"
#include "study/report/scenes.h"
#include "study/report/speed_error.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

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
    if (!set.contact || is_hard_set(set.name) || is_dialled(set.name) || scene_kind(set) || !wanted(set)) continue;
    all.push_back(i);
    if (set.all_solvable) solvable.push_back(i);
  }
  return widely_met(summary, solvable.empty() ? all : solvable);
}

/// The sets of captured steps of a kind, those too that are not all proven solvable.
std::vector<std::size_t> scene_sets(const Summary& summary, SceneKind kind) {
  std::vector<std::size_t> sets;
  for (std::size_t i = 0; i < summary.sets.size(); ++i) {
    if (summary.sets[i].contact && scene_kind(summary.sets[i]) == kind) sets.push_back(i);
  }
  return widely_met(summary, sets);
}

/// ", 11 % of the planned cells" where some are missing.
std::string share_of_plan(double share) {
  return share < 1 ? ", " + escape(plan_share_text(share)) + " of the planned cells" : "";
}

std::string scope_of(const Summary& summary, const std::vector<std::size_t>& sets) {
  std::int64_t problems = 0;
  std::string names;
  std::string last;
  for (const std::size_t set : sets) {
    problems += summary.sets[set].problems;
    const std::optional<SceneName> scene = scene_name(summary.sets[set].name);
    const std::string name = scene ? scene->family : summary.sets[set].name;  // the engines of a scene in one word
    if (name != last) names += (names.empty() ? "" : ", ") + code(name);
    last = name;
  }
  return sets.empty() ? "" : counted(problems, "problem") + share_of_plan(plan_share(summary, sets)) + ": " + names;
}

void measure_errors(const Record& record, Contender& contender) {
  std::vector<double> errors;
  for (const auto& [set, outcome] : record.outcomes) {
    if (!outcome->claimed) continue;
    errors.push_back(std::isnan(outcome->error) ? std::numeric_limits<double>::infinity() : outcome->error);
  }
  std::sort(errors.begin(), errors.end());
  contender.median_error = median(errors);
  contender.p99_error = quantile(errors, 0.99);
}

void measure_times(const Record* reference, const Record& record, Contender& contender) {
  std::vector<double> times;
  for (const auto& [set, outcome] : record.outcomes) {
    if (!std::isnan(outcome->time_s)) times.push_back(outcome->time_s);
  }
  contender.time = median_estimate(times);
  if (reference != nullptr) contender.speedup = time_ratio(*reference, record);
}

/// A solver with what the table says of it.
struct Candidate {
  const Record* record = nullptr;
  Contender contender;

  bool may_be_recommended() const { return record->reliability.reliable() && contender.refused.part == 0; }
  double median_time() const {
    return std::isnan(contender.time.value) ? std::numeric_limits<double>::infinity() : contender.time.value;
  }
};

Candidate make_candidate(const Record& record, const Record* reference) {
  const Evidence& evidence = record.evidence;
  Candidate candidate{&record, {}};
  Contender& contender = candidate.contender;
  contender.solver = record.solver;
  contender.trials = evidence.false_claims.whole;
  contender.solved = evidence.solved;
  contender.solved_of_met = evidence.solved_of_met;
  contender.false_claims = evidence.false_claims;
  contender.refused = evidence.refused;
  contender.reliability = record.reliability;
  contender.sampled = contender.trials < evidence.most_taken;
  measure_times(reference, record, contender);
  measure_errors(record, contender);
  return candidate;
}

/// The fastest that may be recommended; nullptr where none may.
const Candidate* choose(const std::vector<Candidate>& candidates) {
  const Candidate* fastest = nullptr;
  for (const Candidate& candidate : candidates) {
    if (!candidate.may_be_recommended()) continue;
    if (fastest == nullptr || candidate.median_time() < fastest->median_time()) fastest = &candidate;
  }
  return fastest;
}

std::string time_words(const TimeFactor& time) {
  if (!time.shown()) return fmt::format("no factor in time: both solved {} of {}", time.problems, time.of);
  if (is_tie_in_time(time.ratio)) return "about as fast";
  if (!(time.ratio.value > 1)) return "faster in total, slower in the median";
  return fmt::format("{}× slower ({}–{}, n = {})", factor(time.ratio.value), factor(time.ratio.low),
                     factor(time.ratio.high), time.problems);
}

std::string misled_words(const Contender& contender) {
  return "said solved and was wrong on " + percent(contender.false_claims.value());
}

std::string unsolved_words(const Candidate& candidate) {
  const Share& solved = candidate.contender.solved;
  const std::int64_t unsolved = solved.whole - solved.part;
  const Share crashed{candidate.record->crashed, candidate.contender.trials};
  return 2 * crashed.part > unsolved ? "crashed on " + percent(crashed.value())
                                     : "left " + percent(1 - solved.value()) + " unsolved";
}

/// The gravest thing to say of a solver that is not the recommended one, its false claims aside.
std::string gravest(const Candidate& candidate, const Candidate* chosen) {
  const Contender& contender = candidate.contender;
  const Share& met = contender.solved_of_met;
  const std::string solved = fmt::format("solved {} ({} of {})", percent(met.value()), met.part, met.whole);
  const std::string time = chosen == nullptr ? "" : ", " + time_words(time_ratio(*candidate.record, *chosen->record));
  switch (contender.reliability.ground) {
    case Ground::kFalseClaims: return "";
    case Ground::kUnsolved:
    case Ground::kBehindTheBest: return unsolved_words(candidate);
    case Ground::kOtherModel: return "solves the round cone, another problem; of that " + solved;
    case Ground::kNoTime: return "not ranked: nobody measured its time; " + solved;
    case Ground::kSomeSets: return "met only some of these sets; of what it met, " + solved;
    case Ground::kRefuses:
      return fmt::format("refused {} of {}; {}", contender.refused.part, contender.refused.whole, solved);
    case Ground::kFewProblems:
      return fmt::format("too few to say: solved {} of {}", contender.solved.part, contender.solved.whole);
    case Ground::kSmallSample: return "too few to say: " + solved + time;
    case Ground::kShortOfPlan:
      return "too few to say: " + solved + " (" + plan_share_text(candidate.record->evidence.plan_share) +
             " of the plan)";
    case Ground::kWideInterval:
      return "too few to say: " + solved + " (" + percent_range(contender.solved.interval()) + ")";
    case Ground::kNone: break;
  }
  if (contender.tie) return "a tie";
  const std::string refused =
      contender.refused.part > 0 ? " on what it takes, refused " + percent(contender.refused.value()) : "";
  const bool as_reliable = chosen != nullptr && contender.false_claims.part == 0;
  return (as_reliable ? "as reliable" : "reliable") + refused + time;
}

std::string why_not(const Candidate& candidate, const Candidate* chosen) {
  const Contender& contender = candidate.contender;
  std::string reason = gravest(candidate, chosen);
  if (contender.false_claims.part > 0) {
    reason += (reason.empty() ? "" : ", ") + misled_words(contender);
  }
  const Ground ground = contender.reliability.ground;
  const bool counted_already = ground == Ground::kFewProblems || ground == Ground::kRefuses;
  if (contender.sampled && !counted_already) reason += " (" + counted(contender.trials, "problem") + ")";
  return reason;
}

bool is_tie(const Candidate& candidate, const Candidate& chosen) {
  if (!candidate.may_be_recommended() || candidate.contender.false_claims.part > 0) return false;
  const TimeFactor time = time_ratio(*candidate.record, *chosen.record);
  return time.shown() && is_tie_in_time(time.ratio);
}

/// Why no solver of the situation is recommended.
std::string withheld_words(const Summary& summary, const Situation& situation) {
  const auto worth = [](const Contender& contender) {
    const double low = contender.solved_of_met.interval().low;
    return std::pair(contender.reliability.standing != Standing::kPartly, std::isnan(low) ? -1.0 : low);
  };
  std::int64_t most = 0;
  const Contender* best = nullptr;
  for (const Contender& contender : situation.contenders) {
    most = std::max(most, contender.solved.whole);
    if (best == nullptr || worth(contender) > worth(*best)) best = &contender;
  }
  if (best == nullptr) return "";
  const double share = plan_share(summary, situation.sets);
  if (too_few(most, share)) return too_few_text(most, share) + "; " + escape(few_problems_text(summary, situation));
  const Share& solved = best->solved_of_met;
  return fmt::format("no solver is shown to be reliable here; the best by share solved, {}, solved {} ({}) of {}",
                     code(summary.solvers[best->solver].text()), percent(solved.value()),
                     percent_range(solved.interval()), counted(solved.whole, "problem"));
}

void sort_contenders(std::vector<Contender>& contenders, std::optional<std::size_t> chosen_solver) {
  const auto number_or_last = [](double value) { return std::isnan(value) ? 1e300 : value; };
  std::sort(contenders.begin(), contenders.end(), [&](const Contender& a, const Contender& b) {
    const auto key = [&](const Contender& contender) {
      return std::tuple(contender.solver != chosen_solver, contender.reliability.ground == Ground::kSomeSets,
                        number_or_last(-contender.solved_of_met.value()), number_or_last(contender.time.value),
                        contender.solver);
    };
    return key(a) < key(b);
  });
}

}  // namespace

Situation judge_situation(const Summary& summary, std::string title, std::vector<std::size_t> sets) {
  Situation situation{std::move(title), scope_of(summary, sets), std::move(sets), {}, std::nullopt, ""};
  const std::vector<Record> records = judged_records(summary, situation.sets);
  const auto reference = std::find_if(records.begin(), records.end(), [&summary](const Record& record) {
    return summary.solvers[record.solver].text() == summary.reference;
  });
  std::vector<Candidate> candidates;
  for (const Record& record : records) {
    candidates.push_back(make_candidate(record, reference == records.end() ? nullptr : &*reference));
  }
  const Candidate* chosen = choose(candidates);
  for (Candidate& candidate : candidates) {
    candidate.contender.recommended_factor =
        chosen == nullptr ? TimeFactor{} : time_ratio(*chosen->record, *candidate.record);
    if (&candidate == chosen) continue;
    candidate.contender.tie = chosen != nullptr && is_tie(candidate, *chosen);
    candidate.contender.verdict = why_not(candidate, chosen);
  }
  for (const Candidate& candidate : candidates) situation.contenders.push_back(candidate.contender);
  std::optional<std::size_t> chosen_solver;
  if (chosen != nullptr) chosen_solver = chosen->contender.solver;
  sort_contenders(situation.contenders, chosen_solver);
  if (chosen != nullptr) situation.recommended = 0;
  if (chosen == nullptr) situation.withheld = withheld_words(summary, situation);
  return situation;
}

namespace {

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

/// How many of decide()'s situations, the last ones, are random problems.
constexpr std::size_t kRandomSituations = 3;

/// The situation of random problems that the report's first sentence speaks of: one with a recommended solver if there
/// is any, else one with solvers; nullptr where no solver met any.
const Situation* most_telling(const std::vector<Situation>& situations) {
  constexpr std::size_t kPreferred[] = {1, 2, 0};
  const Situation* const random = &situations[situations.size() - kRandomSituations];
  for (const std::size_t preferred : kPreferred) {
    if (random[preferred].recommended) return &random[preferred];
  }
  for (const std::size_t preferred : kPreferred) {
    if (!random[preferred].contenders.empty()) return &random[preferred];
  }
  return nullptr;
}

/// "<code>auto</code>, which solved 100 % (92.3–100 %) of 46 problems in a median of 62 µs"
std::string recommendation(const Summary& summary, const Situation& situation) {
  const Contender& best = situation.contenders[*situation.recommended];
  const char* alone = situation.contenders.size() == 1 ? " (the only solver here)" : "";
  return fmt::format("{}{}, which solved {} ({}) of {} in a median of {}", code(summary.solvers[best.solver].text()),
                     alone, percent(best.solved.value()), percent_range(best.solved.interval()),
                     counted(best.solved.whole, "problem"), duration(best.time.value));
}

std::string in_a_sentence(std::string title) {
  title.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(title.front())));
  return title;
}

/// Which solver to take for captured steps; "" for a store without them.
std::string scenes_answer(const Summary& summary, const std::vector<Situation>& situations) {
  std::string answer;
  for (std::size_t i = 0; i + kRandomSituations < situations.size(); ++i) {
    const Situation& situation = situations[i];
    if (situation.contenders.empty()) continue;
    answer += (answer.empty() ? "For captured scenes: " : "; ") + in_a_sentence(situation.title) + ": ";
    if (!situation.recommended) {
      answer += "no solver is recommended: " + situation.withheld;
      continue;
    }
    answer += recommendation(summary, situation);
    const Contender& best = situation.contenders[*situation.recommended];
    if (best.false_claims.part > 0) answer += " (it " + misled_words(best) + ")";
  }
  return answer.empty() ? "" : answer + ".";
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

TimeFactor time_ratio(const Record& a, const Record& b) {
  PairedTimes times;
  std::int64_t met = 0;
  for_each_pair(a, b, [&](const Outcome& left, const Outcome& right) {
    ++met;
    if (left.solved && right.solved) times.add(left.time_s, right.time_s);
  });
  return {ratio_of_sums(times.first, times.second), std::ssize(times.first), met};
}

std::vector<const Contender*> without_fault(const Situation& situation) {
  std::int64_t most = 0;
  for (const Contender& contender : situation.contenders) most = std::max(most, contender.trials);
  std::vector<const Contender*> faultless;
  for (const Contender& contender : situation.contenders) {
    if (contender.trials == most && contender.solved.part == contender.solved.whole &&
        contender.false_claims.part == 0 && std::isfinite(contender.time.value)) {
      faultless.push_back(&contender);
    }
  }
  std::stable_sort(faultless.begin(), faultless.end(),
                   [](const Contender* a, const Contender* b) { return a->time.value < b->time.value; });
  return faultless;
}

std::string few_problems_text(const Summary& summary, const Situation& situation) {
  const std::vector<const Contender*> faultless = without_fault(situation);
  if (faultless.empty()) {
    const Contender& most = situation.contenders.front();  // their order is by the share solved
    const Share& solved = most.solved_of_met;
    return fmt::format("no solver solved all of them; the most, {} of {} ({}), did {}", solved.part, solved.whole,
                       percent_range(solved.interval()), summary.solvers[most.solver].text());
  }
  const Contender& fastest = *faultless.front();
  return fmt::format(
      "{} solved by {} of {}, the fastest of them {} in a median of {}; that shows a share of at least {} (95 %)",
      fastest.solved.whole == 1 ? "it is" : fmt::format("all {} are", fastest.solved.whole), faultless.size(),
      counted(std::ssize(situation.contenders), "solver"), summary.solvers[fastest.solver].text(),
      duration(fastest.time.value), percent(fastest.solved.interval().low));
}

std::vector<Situation> decide(const Summary& summary) {
  const auto frictionless =
      sets_where(summary, [](const SetSummary& set) { return !set.frictional && !set.ill_conditioned; });
  const auto frictional =
      sets_where(summary, [](const SetSummary& set) { return set.frictional && !set.ill_conditioned; });
  const auto ill_conditioned = ill_conditioned_sets(summary);
  std::vector<Situation> situations;
  for (const SceneKind kind : kSceneKinds) {
    const std::vector<std::size_t> sets = scene_sets(summary, kind);
    if (!sets.empty()) situations.push_back(judge_situation(summary, title(kind), sets));
  }
  situations.push_back(judge_situation(summary, "Frictionless", frictionless));
  situations.push_back(judge_situation(summary, "Frictional", frictional));
  situations.push_back(judge_situation(summary, ill_conditioned_title(summary, ill_conditioned), ill_conditioned));
  return situations;
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

std::string speed_beside_reference(const Summary& summary, const Contender& best) {
  const bool is_reference = summary.solvers[best.solver].text() == summary.reference;
  if (is_reference || !best.speedup.shown()) return "";
  return speed_against(1 / best.speedup.ratio.value) + " the dense reference";
}

std::vector<std::pair<std::size_t, Share>> caught_solvers(const Summary& summary) {
  std::map<std::size_t, Share> false_claims;
  for (const Cell& cell : summary.cells) {
    if (!summary.solvers[cell.solver].sweep.empty()) continue;
    false_claims[cell.solver].part += cell.false_claims();
    false_claims[cell.solver].whole += cell.trials - cell.count(Claim::kUnsupported);
  }
  std::erase_if(false_claims, [](const auto& entry) { return entry.second.part == 0; });
  std::vector<std::pair<std::size_t, Share>> caught(false_claims.begin(), false_claims.end());
  std::stable_sort(caught.begin(), caught.end(),
                   [](const auto& a, const auto& b) { return a.second.interval().low > b.second.interval().low; });
  return caught;
}

std::string situation_key(std::size_t situation, std::size_t solver) {
  return fmt::format("s{}:{}", situation, solver);
}

std::string one_line_answer(const Summary& summary, const std::vector<Situation>& situations) {
  if (only_special_sets(summary, situations)) return answer_without_situations(summary);
  const std::string scenes = scenes_answer(summary, situations);
  const Situation* situation = most_telling(situations);
  if (situation == nullptr && !scenes.empty()) return scenes;
  if (situation == nullptr) return "The store does not yet hold enough verified answers to recommend a solver.";
  std::string answer = scenes.empty() ? "For " : scenes + " For random ";
  answer += in_a_sentence(situation->title) + " contacts";
  if (!situation->recommended) return answer + " no solver is recommended: " + situation->withheld + ".";
  const Contender& best = situation->contenders[*situation->recommended];
  answer += ": " + recommendation(summary, *situation);
  if (const std::string speed = speed_beside_reference(summary, best); !speed.empty()) {
    const auto index = static_cast<std::size_t>(situation - situations.data());
    answer += fmt::format(", <span data-speed=\"{}\">{}</span>", situation_key(index, best.solver), speed);
  }
  if (!std::isnan(best.p99_error)) {
    answer += fmt::format("; the error ρ of 99 % of its answers is at most {}", scientific(best.p99_error));
  }
  if (best.false_claims.part > 0) answer += "; it " + misled_words(best);
  return answer + ".";
}

}  // namespace lcpbench::report
