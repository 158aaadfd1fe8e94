#include "study/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <numeric>
#include <span>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "study/store/answer_scan.h"

namespace lcpbench {

namespace {

/// The answers of one solver to a set, by problem and part, with sums that are taken while they are read.
struct Answers {
  std::vector<Outcome> outcomes;
  struct Parts {
    double timed = 0;
    TimeParts sums{};
  };
  std::vector<Parts> parts;                                    ///< by parameterisation
  std::vector<std::map<std::string, std::int64_t>> refusals;  ///< their reasons, by parameterisation
  Done* done = nullptr;
};

/// The groups of parameterisations that gave one answer, by Outcome::group.
using Groups = std::vector<std::vector<std::uint32_t>>;

bool asks_for_ill_conditioning(const std::string& set) {
  return set.find("exp5-") != std::string::npos || set.find("exp6-") != std::string::npos ||
         set.find("extra100") != std::string::npos;
}

std::vector<RunSummary> read_runs(sqlite::Database& store) {
  sqlite::Statement query(store, "SELECT started, provenance FROM runs WHERE started <> '' ORDER BY started, id");
  std::vector<RunSummary> runs;
  while (query.step()) {
    auto provenance = nlohmann::ordered_json::parse(query.text(1), nullptr, false);
    if (provenance.is_discarded()) provenance = std::string(query.text(1));
    runs.push_back({std::string(query.text(0)), std::move(provenance)});
  }
  return runs;
}

/// The number at the end of "what: how many"; 1 where there is none.
std::int64_t count_of_note(const std::string& note, std::size_t colon) {
  constexpr long long kMost = 1LL << 40;  // sums of this many do not overflow, whatever a file says
  return colon == std::string::npos ? 1 : std::clamp(std::strtoll(note.c_str() + colon + 2, nullptr, 10), 0LL, kMost);
}

/// The notes of captured problems, summed up.
void read_differences(sqlite::Database& store, Summary& summary) {
  sqlite::Statement query(store, "SELECT notes, COUNT(*) FROM problems WHERE notes <> '[]' GROUP BY notes");
  while (query.step()) {
    const std::int64_t problems = query.integer(1);
    summary.differing += problems;
    for (const auto& each : nlohmann::json::parse(query.text(0), nullptr, false)) {
      if (!each.is_string()) continue;
      const auto note = each.get<std::string>();
      const std::size_t colon = note.rfind(": ");
      summary.differences[note.substr(0, colon)] += count_of_note(note, colon) * problems;
    }
  }
}

/// Adds a problem to the counts and flags of its set.
void count_problem(const AnsweredProblem& problem, SetSummary& set) {
  const ProblemRow& row = problem.row;
  const bool first = set.problems++ == 0;
  set.last_trial = std::max(set.last_trial, row.trial);
  const bool contact = row.kind != "lcp";
  set.contact = (first || set.contact) && contact;
  set.bare = (first || set.bare) && !contact;
  set.frictional = set.frictional || (row.nc > 0 && row.n > row.nc);
  const bool solvable = problem.truth == Truth::kSolvable || problem.truth == Truth::kAnswered;
  set.all_solvable = (first || set.all_solvable) && solvable;
  set.free_bodies = (first || set.free_bodies) && row.free_bodies;
  set.smallest_n = first ? row.n : std::min(set.smallest_n, row.n);
  set.largest_n = std::max(set.largest_n, row.n);
}

/// Adds a problem of truth "nearly", and lowers the set's bound to its own.
void count_nearly(const AnsweredProblem& problem, SetSummary& set) {
  double least = problem.least_violation_m_per_s;
  for (const StoredAnswer& answer : problem.answers) {
    least = std::fmax(least, answer.errors.least_violation_m_per_s);  // NaN is none
  }
  set.least_violation_m_per_s = std::fmin(set.least_violation_m_per_s, std::isnan(least) ? 0 : least);
  ++set.nearly;
}

Outcome outcome_of(const StoredAnswer& answer, std::size_t problem) {
  const Errors& errors = answer.errors;
  Outcome outcome;
  outcome.error = errors.measure();
  outcome.violation_m_per_s = errors.violation_m_per_s;
  outcome.solver_error_m_per_s = errors.velocity_residual_m_per_s;
  outcome.model_error_m_per_s = errors.model_error_m_per_s;
  outcome.time_s = answer.times.setup_cpu_s + answer.times.solve_cpu_s;
  outcome.problem = static_cast<std::uint32_t>(problem);
  outcome.group = answer.group;
  outcome.pivots = static_cast<std::int32_t>(std::min<std::int64_t>(answer.counters.pivots, INT32_MAX));
  outcome.claim = answer.claim;
  outcome.verdict = answer.verdict;
  outcome.truth = answer.truth;
  outcome.criterion = errors.criterion;
  outcome.odd_trial = (answer.trial & 1) != 0;
  return outcome;
}

void add_answer(const StoredAnswer& answer, std::size_t problem, Answers& answers) {
  const Outcome& outcome = answers.outcomes.emplace_back(outcome_of(answer, problem));
  const SolveTimes& times = answer.times;
  const TimeParts parts{times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s,
                        times.solve_cpu_s,  times.transport_s, answer.verify_s};
  for (const std::uint32_t number : answer.cells) {
    if (outcome.refused()) ++answers.refusals[number][answer.detail];
    if (outcome.refused() || std::isnan(outcome.time_s)) continue;
    answers.parts[number].timed += 1;
    for (std::size_t i = 0; i < parts.size(); ++i) answers.parts[number].sums[i] += parts[i];
  }
}

void count_answer(const Outcome& outcome, Cell& cell) {
  ++cell.counts[static_cast<std::size_t>(outcome.claim)][static_cast<std::size_t>(outcome.verdict)];
  if (outcome.solved() && outcome.error <= 1e-6) ++cell.solved_1e6;
  if (outcome.solved() && outcome.error <= 1e-9) ++cell.solved_1e9;
  if (outcome.claim == Claim::kUnsolvable && outcome.truth == Truth::kSolvable) ++cell.false_unsolvable;
  if (outcome.truth == Truth::kNearly) {
    ++cell.nearly_problems;
    if (outcome.solved()) ++cell.nearly_solved;
    if (outcome.unsolvable()) ++cell.nearly_unsolvable;
  }
  for (Part* part : {static_cast<Part*>(&cell), &cell.halves[outcome.odd_trial ? 1 : 0]}) {
    ++part->trials;
    if (outcome.solved()) ++part->solved;
    if (outcome.unsolvable()) ++part->unsolvable_problems;
    if (outcome.passes_criterion()) ++part->criterion;
    if (outcome.criterion) ++part->criterion_any;
  }
}

/// @param cells  of one solver, one for each parameterisation
void count_answers(const Answers& answers, const Groups& groups, std::span<Cell> cells) {
  for (const Outcome& outcome : answers.outcomes) {
    for (const std::uint32_t number : groups[outcome.group]) count_answer(outcome, cells[number]);
  }
  for (std::size_t number = 0; number < cells.size(); ++number) {
    Cell& cell = cells[number];
    const auto& refusals = answers.refusals[number];
    const auto most = std::max_element(refusals.begin(), refusals.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != refusals.end()) cell.refusal = most->first;
    cell.rate_interval = wilson(cell.count(Verdict::kSolved), cell.solvable());
    const Answers::Parts& parts = answers.parts[number];
    for (std::size_t i = 0; i < kTimeParts.size(); ++i) cell.time_parts[i] = parts.sums[i] / parts.timed;
  }
}

/// The outcomes that have a number, by its size.
using Order = std::vector<std::pair<double, const Outcome*>>;

/// @param value_of  NaN leaves the answer out
template <class ValueOf>
Order order_by(const std::vector<Outcome>& outcomes, ValueOf value_of) {
  Order order;
  order.reserve(outcomes.size());
  for (const Outcome& outcome : outcomes) {
    const double value = value_of(outcome);
    if (!std::isnan(value)) order.emplace_back(value, &outcome);
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return order;
}

/// A quantity of each parameterisation's trials, ascending: of all, of the even and of the odd ones.
struct Sample {
  std::vector<double> all;
  std::array<std::vector<double>, 2> halves;
};

/// Hands each value to the parameterisations that share it.
template <class Condition>
std::vector<Sample> distribute(const Order& order, const Groups& groups, std::size_t cells, Condition condition) {
  std::vector<Sample> samples(cells);
  for (const auto& [value, outcome] : order) {
    if (!condition(*outcome)) continue;
    for (const std::uint32_t number : groups[outcome->group]) {
      samples[number].all.push_back(value);
      samples[number].halves[outcome->odd_trial ? 1 : 0].push_back(value);
    }
  }
  return samples;
}

/// One of a cell's spreads, of all trials and, where it is one of a part, of its halves.
template <class Of, class Condition>
void measure(const Order& order, const Groups& groups, std::span<Cell> cells, Spread Of::*quantity,
             Condition condition) {
  const std::vector<Sample> samples = distribute(order, groups, cells.size(), condition);
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].*quantity = spread_of_sorted(samples[number].all);
    if constexpr (std::is_same_v<Of, Part>) {
      for (std::size_t i = 0; i < 2; ++i) {
        cells[number].halves[i].*quantity = spread_of_sorted(samples[number].halves[i]);
      }
    }
  }
}

void measure_answers(const std::vector<Outcome>& outcomes, const Groups& groups, std::span<Cell> cells) {
  const auto any = [](const Outcome& outcome) { return outcome.criterion; };  // whatever was claimed
  const Order times = order_by(outcomes, [](const Outcome& outcome) { return outcome.time_s; });
  measure(times, groups, cells, &Cell::all_time, std::not_fn(&Outcome::refused));
  measure(times, groups, cells, &Cell::solved_time, std::mem_fn(&Outcome::solved));
  measure(times, groups, cells, &Cell::criterion_time, std::mem_fn(&Outcome::passes_criterion));
  measure(times, groups, cells, &Cell::criterion_any_time, any);
  const Order violations = order_by(outcomes, [](const Outcome& outcome) { return outcome.violation_m_per_s; });
  measure(violations, groups, cells, &Cell::violation, std::mem_fn(&Outcome::solved));
  measure(violations, groups, cells, &Cell::criterion_violation, std::mem_fn(&Outcome::passes_criterion));
  measure(violations, groups, cells, &Cell::criterion_any_violation, any);
  const auto where_modelled = [](auto value) {
    return [=](const Outcome& outcome) {
      return outcome.solved() && !std::isnan(outcome.model_error_m_per_s) ? outcome.*value : kNoNumber;
    };
  };
  const auto all = [](const Outcome&) { return true; };
  measure(order_by(outcomes, where_modelled(&Outcome::solver_error_m_per_s)), groups, cells, &Cell::solver_error, all);
  measure(order_by(outcomes, where_modelled(&Outcome::model_error_m_per_s)), groups, cells, &Cell::model_error, all);
  const auto pivots = [](const Outcome& outcome) {
    return outcome.pivots < 0 ? kNoNumber : static_cast<double>(outcome.pivots);
  };
  measure(order_by(outcomes, pivots), groups, cells, &Cell::pivots, all);
}

/// Errors of the answers claimed solved; one that is no number is infinite.
void measure_errors(const std::vector<Outcome>& outcomes, const Groups& groups, const SetSummary& set,
                    std::span<Cell> cells) {
  const char* measure = set.contact ? "velocity_residual_relative" : set.bare ? "backward_row_norm" : "";
  const auto error = [measure](const Outcome& outcome) {
    if (!outcome.claimed() || *measure == '\0') return kNoNumber;
    return std::isnan(outcome.error) ? kInfinity : outcome.error;
  };
  std::vector<Sample> errors =
      distribute(order_by(outcomes, error), groups, cells.size(), [](const Outcome&) { return true; });
  for (std::size_t number = 0; number < cells.size(); ++number) {
    Cell& cell = cells[number];
    const std::vector<double>& sorted = errors[number].all;
    cell.error_measure = measure;
    cell.error_count = static_cast<std::int64_t>(sorted.size());
    cell.error_median = median(sorted);
    cell.error_p99 = quantile(sorted, 0.99);
    cell.error_max = sorted.empty() ? kNoNumber : sorted.back();
  }
}

Estimate median_time_of(const std::vector<Outcome>& outcomes) {
  std::vector<double> times;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.refused() && !std::isnan(outcome.time_s)) times.push_back(outcome.time_s);
  }
  return median_estimate(times);
}

/// Is this the solver that all time ratios refer to: the paper's algorithm as published, `lemke{engine=dense}` and
/// nothing else off its default?
bool is_reference(const SolverRow& solver) {
  if (solver.name != "lemke" || !solver.sweep.empty()) return false;
  if (solver.settings == "engine=dense") return true;
  return solver.settings.empty() && solver.all_settings.find("engine=dense") != std::string::npos;
}

/// One solver of a store, and what its cells are called in the summary.
struct Source {
  std::int64_t id = 0;
  SolverRow row;
  std::vector<std::size_t> solvers;  ///< by cell: index into Summary::solvers

  bool swept() const { return !row.sweep.empty(); }
};

/// The reference at the solver's instruction-set level, of its version if there is one, else at any; nullptr where the
/// set has none.
/// @param answers  to a set, by source
const std::vector<Outcome>* find_reference(const std::vector<Source>& sources, const Source& source,
                                           const std::vector<Answers>& answers) {
  const std::vector<Outcome>* found = nullptr;
  std::pair<bool, bool> likeness;  // of what was found
  for (std::size_t i = 0; i < sources.size(); ++i) {
    const SolverRow& row = sources[i].row;
    if (!is_reference(row) || answers[i].outcomes.empty()) continue;
    const std::pair like(row.isa == source.row.isa,
                         row.library == source.row.library && row.version == source.row.version);
    if (found == nullptr || like > likeness) found = &answers[i].outcomes, likeness = like;
  }
  return found;
}

/// Over the reference's times on the problems that both solved. Both lists are by problem.
void add_time_ratios(const std::vector<Outcome>& outcomes, const std::vector<Outcome>* reference, const Groups& groups,
                     std::span<Cell> cells) {
  std::vector<std::array<std::vector<double>, 2>> paired(cells.size());
  auto other = reference == nullptr ? outcomes.end() : reference->begin();
  for (const Outcome& outcome : outcomes) {
    while (reference != nullptr && other != reference->end() && other->problem < outcome.problem) ++other;
    if (reference == nullptr || other == reference->end()) break;
    const bool both = other->problem == outcome.problem && outcome.solved() && other->solved();
    if (!both || std::isnan(outcome.time_s) || std::isnan(other->time_s)) continue;
    for (const std::uint32_t number : groups[outcome.group]) {
      paired[number][0].push_back(outcome.time_s);
      paired[number][1].push_back(other->time_s);
    }
  }
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].paired = std::ssize(paired[number][0]);
    cells[number].time_ratio = ratio_of_sums(paired[number][0], paired[number][1]);
  }
}

/// The cells of one solver on one set.
std::vector<Cell> make_cells(std::size_t set, const SetSummary& summary, const Source& source, const Answers& answers,
                             const Groups& groups, const std::vector<Outcome>* reference) {
  const std::vector<Outcome>& outcomes = answers.outcomes;
  std::vector<Cell> cells(source.solvers.size());
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].set = set;
    cells[number].solver = source.solvers[number];
  }
  count_answers(answers, groups, cells);
  measure_answers(outcomes, groups, cells);
  measure_errors(outcomes, groups, summary, cells);
  add_time_ratios(outcomes, reference, groups, cells);
  for (Cell& cell : cells) {
    cell.median_time = source.swept() ? Estimate{cell.all_time.median, kNoNumber, kNoNumber} : median_time_of(outcomes);
  }
  return cells;
}

/// Every parameterisation becomes a solver of the summary, in natural order.
std::vector<Source> read_solvers(Store& store, Summary& summary) {
  struct Named {
    SolverRow row;
    std::size_t source, cell;
  };
  std::vector<Source> sources;
  std::vector<Named> solvers;
  for (const StoredSolver& stored : store.solvers()) {
    for (std::size_t cell = 0; cell < stored.cells.size(); ++cell) {
      solvers.push_back({stored.cells[cell], sources.size(), cell});
    }
    sources.push_back({stored.id, stored.row, std::vector<std::size_t>(stored.cells.size())});
  }
  std::stable_sort(solvers.begin(), solvers.end(),
                   [](const Named& a, const Named& b) { return natural_less(a.row.text(), b.row.text()); });
  for (Named& solver : solvers) {
    sources[solver.source].solvers[solver.cell] = summary.solvers.size();
    if (is_reference(solver.row)) summary.reference = solver.row.text();
    summary.solvers.push_back(std::move(solver.row));
  }
  return sources;
}

/// One set, as it is read.
struct SetOfAnswers {
  std::int64_t id = 0;
  SetSummary summary;
  std::size_t expected = 0;  ///< problems
  std::vector<ProblemKey> problems;
  std::vector<Answers> answers;  ///< by source
};

/// The sets that have problems, by name alone, in natural order.
std::vector<SetOfAnswers> read_sets(sqlite::Database& store, std::size_t sources) {
  sqlite::Statement query(
      store, "SELECT s.id, s.name, COUNT(*) FROM sets s JOIN problems p ON p.set_id = s.id GROUP BY s.id");
  std::vector<SetOfAnswers> sets;
  while (query.step()) {
    SetOfAnswers& set = sets.emplace_back();
    query.read(0, set.id, set.summary.name, set.expected);
    set.summary.ill_conditioned = asks_for_ill_conditioning(set.summary.name);
    set.answers.resize(sources);
  }
  std::sort(sets.begin(), sets.end(), [](const SetOfAnswers& a, const SetOfAnswers& b) {
    return natural_less(a.summary.name, b.summary.name);
  });
  return sets;
}

/// One scan of the answers: the sets and the coverage of the summary, and the answers of each of its sets.
std::vector<SetOfAnswers> read_answers(sqlite::Database& database, AnswerScan& scan, const std::vector<Source>& sources,
                                       Summary& summary) {
  std::vector<SetOfAnswers> sets = read_sets(database, sources.size());
  std::unordered_map<std::int64_t, SetOfAnswers*> set_of;
  for (SetOfAnswers& set : sets) set_of[set.id] = &set;
  std::map<std::int64_t, std::size_t> places;  // of the sources, by id
  for (std::size_t i = 0; i < sources.size(); ++i) places[sources[i].id] = i;
  std::map<Work, Done> done;
  scan.read(std::nullopt, [&](const AnsweredProblem& problem) {
    const ProblemRow& row = problem.row;
    SetOfAnswers& set = *set_of.at(row.set_id);
    count_problem(problem, set.summary);
    if (problem.truth == Truth::kNearly) count_nearly(problem, set.summary);
    auto place = places.begin();  // answers are in order of their solvers' ids, too
    for (const StoredAnswer& answer : problem.answers) {
      while (place->first != answer.solver_id) ++place;
      const Source& source = sources[place->second];
      Answers& of = set.answers[place->second];
      if (of.done == nullptr) {
        of.parts.resize(source.solvers.size());
        of.refusals.resize(source.solvers.size());
        of.outcomes.reserve(set.expected);  // what is not filled takes no memory
        of.done = &done[{set.summary.name, source.row.text(), source.row.sweep}];
      }
      of.done->add(row.id);
      add_answer(answer, set.problems.size(), of);
    }
    set.problems.push_back({row.seed, row.trial});
  });
  for (const SetOfAnswers& set : sets) summary.sets.push_back(set.summary);
  summary.coverage = coverage_of(summary.runs, done);
  return sets;
}

}  // namespace

std::int64_t Cell::count(Verdict verdict) const {
  std::int64_t total = 0;
  for (const Claim claim : kAllClaims) total += count(claim, verdict);
  return total;
}

std::int64_t Cell::count(Claim claim) const {
  const auto& verdicts = counts[static_cast<std::size_t>(claim)];
  return std::accumulate(verdicts.begin(), verdicts.end(), std::int64_t{0});
}

std::int64_t Cell::count(Claim claim, Verdict verdict) const {
  return counts[static_cast<std::size_t>(claim)][static_cast<std::size_t>(verdict)];
}

std::int64_t Cell::gave_up() const {
  return count(Verdict::kRefused) + count(Verdict::kMissed) + count(Verdict::kOpen);
}

double Part::rate() const { return share_of(solved, solvable()); }
double Part::criterion_rate() const { return share_of(criterion, trials); }

Summary summarize(Store& store, const SetVisitor& visit) {
  Summary summary;
  sqlite::Database& database = store.database();
  const sqlite::ReadSnapshot snapshot(database);  // a run may be writing
  summary.runs = read_runs(database);
  read_differences(database, summary);
  const std::vector<Source> sources = read_solvers(store, summary);
  AnswerScan scan(store);
  std::vector<SetOfAnswers> sets = read_answers(database, scan, sources, summary);
  for (std::size_t set = 0; set < sets.size(); ++set) {
    std::vector<Answers>& answers = sets[set].answers;
    const auto first = static_cast<std::ptrdiff_t>(summary.cells.size());
    std::map<std::size_t, Answers*> singles;  // by cell
    for (std::size_t i = 0; i < sources.size(); ++i) {
      const Source& source = sources[i];
      if (answers[i].outcomes.empty()) continue;
      if (!source.swept()) singles[summary.cells.size()] = &answers[i];
      const std::vector<Outcome>* reference = find_reference(sources, source, answers);
      for (Cell& cell : make_cells(set, summary.sets[set], source, answers[i], scan.groups(), reference)) {
        summary.cells.push_back(std::move(cell));
      }
    }
    for (const auto& [cell, of] : singles) summary.cells[cell].outcomes = std::move(of->outcomes);
    std::sort(summary.cells.begin() + first, summary.cells.end(),
              [](const Cell& a, const Cell& b) { return a.solver < b.solver; });
    const std::span<Cell> of_set(summary.cells.begin() + first, summary.cells.end());
    if (visit) visit(summary, sets[set].problems, of_set);
    for (Cell& cell : of_set) cell.outcomes = {};
    sets[set] = {};
  }
  return summary;
}

}  // namespace lcpbench
