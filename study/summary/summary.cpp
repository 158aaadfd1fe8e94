#include "study/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <cstdint>
#include <map>
#include <span>
#include <unordered_map>
#include <utility>

#include "study/store/answer_scan.h"

namespace lcpbench {

namespace {

/// A problem of a set as its outcomes name it.
struct ProblemKey {
  std::int64_t id = 0;
  std::int64_t seed = 0;
  std::int64_t trial = 0;
};

/// One distinct answer as the store holds it, as small as may be: a set may have millions.
struct Row {
  std::uint32_t problem = 0;  ///< index into the set's problems
  std::int32_t pivots = -1;
  const std::vector<std::uint32_t>* cells = nullptr;  ///< parameterisations that gave it; the scan has them
  double error = kNoNumber;  ///< what the verdict was taken on: rho, or the backward error of a bare LCP
  double violation_m_per_s = kNoNumber;
  double solver_error_m_per_s = kNoNumber;
  double model_error_m_per_s = kNoNumber;
  double time_s = kNoNumber;
  Claim claim : 8 = Claim::kNumericalFailure;
  Verdict verdict : 8 = Verdict::kOpen;
  Truth truth : 8 = Truth::kUnknown;
  bool criterion : 1 = false;
  bool odd : 1 = false;  ///< its trial

  std::size_t half() const { return odd ? 1 : 0; }
};
using Rows = std::deque<Row>;  // it grows without a copy

/// The answers of one solver to a set, by problem and part, and what is summed while they are read.
struct Answers {
  Rows rows;
  struct Parts {
    double timed = 0;
    TimeParts sums;
  };
  std::vector<Parts> parts;                                    ///< by parameterisation
  std::vector<std::map<std::string, std::int64_t>> refusals;  ///< their reasons, by parameterisation
  Done* done = nullptr;
};

bool asks_for_ill_conditioning(const std::string& set) {
  return set.find("exp5-") != std::string::npos || set.find("exp6-") != std::string::npos ||
         set.find("extra100") != std::string::npos;
}

/// The sets that have problems, by name alone.
std::vector<std::pair<std::int64_t, SetSummary>> read_sets(sqlite::Database& store) {
  sqlite::Statement query(
      store,
      "SELECT s.id, s.name FROM sets s WHERE EXISTS (SELECT 1 FROM problems p WHERE p.set_id = s.id)");
  std::vector<std::pair<std::int64_t, SetSummary>> sets;
  while (query.step()) {
    SetSummary set;
    set.name = query.text(1);
    set.ill_conditioned = asks_for_ill_conditioning(set.name);
    sets.emplace_back(query.integer(0), std::move(set));
  }
  std::sort(sets.begin(), sets.end(),
            [](const auto& a, const auto& b) { return natural_less(a.second.name, b.second.name); });
  return sets;
}

/// That every answer to a problem is proven to violate some contact by, by its certificate.
std::unordered_map<std::int64_t, double> read_least_violations(sqlite::Database& store) {
  sqlite::Statement query(store,
                          "SELECT problem_id, least_violation_m_per_s FROM certificates "
                          "WHERE least_violation_m_per_s IS NOT NULL");
  std::unordered_map<std::int64_t, double> violations;
  while (query.step()) violations[query.integer(0)] = query.real(1);
  return violations;
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

/// What a problem adds to its set. The flags hold for all problems so far.
void count_problem(const AnsweredProblem& problem, SetSummary& set) {
  const ProblemRow& row = problem.row;
  const bool first = set.problems++ == 0;
  const bool contact = row.kind != "lcp";
  set.contact = (first || set.contact) && contact;
  set.bare = (first || set.bare) && !contact;
  set.frictional = set.frictional || (row.nc > 0 && row.n > row.nc);
  set.all_solvable = (first || set.all_solvable) && problem.truth == Truth::kSolvable;
  set.free_bodies = (first || set.free_bodies) && row.free_bodies;
  set.smallest_n = first ? row.n : std::min(set.smallest_n, row.n);
  set.largest_n = std::max(set.largest_n, row.n);
}

/// What a problem that has nearly a solution adds. @param proven  by its certificate
void count_nearly(const AnsweredProblem& problem, double proven, SetSummary& set) {
  double least = proven;
  for (const StoredAnswer& answer : problem.answers) {
    least = std::fmax(least, answer.errors.least_violation_m_per_s);  // NaN is none
  }
  set.least_violation_m_per_s = std::fmin(set.least_violation_m_per_s, std::isnan(least) ? 0 : least);
  ++set.nearly;
}

Row row_of(const StoredAnswer& answer, std::size_t problem) {
  const Errors& errors = answer.errors;
  Row row;
  row.problem = static_cast<std::uint32_t>(problem);
  row.pivots = static_cast<std::int32_t>(std::min<std::int64_t>(answer.counters.pivots, INT32_MAX));
  row.cells = answer.cells.get();
  row.error = std::isnan(errors.velocity_residual_relative) ? errors.backward_row_norm : errors.velocity_residual_relative;
  row.violation_m_per_s = errors.violation_m_per_s;
  row.solver_error_m_per_s = errors.velocity_residual_m_per_s;
  row.model_error_m_per_s = errors.model_error_m_per_s;
  row.time_s = answer.times.setup_cpu_s + answer.times.solve_cpu_s;
  row.claim = answer.claim;
  row.verdict = answer.verdict;
  row.truth = answer.truth;
  row.criterion = errors.criterion;
  row.odd = (answer.trial & 1) != 0;
  return row;
}

void add_answer(const StoredAnswer& answer, std::size_t problem, Answers& answers) {
  const Row& row = answers.rows.emplace_back(row_of(answer, problem));
  const bool refused = answer.claim == Claim::kUnsupported;
  const SolveTimes& times = answer.times;
  const TimeParts parts{times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s,
                        times.solve_cpu_s,  times.transport_s, answer.verify_s};
  for (const std::uint32_t number : *row.cells) {
    if (refused) ++answers.refusals[number][answer.detail];
    if (refused || std::isnan(row.time_s)) continue;
    answers.parts[number].timed += 1;
    for (const auto part : kTimeParts) answers.parts[number].sums.*part += parts.*part;
  }
}

bool claimed_solved(const Row& row) { return row.claim == Claim::kSolved; }
bool refused(const Row& row) { return row.claim == Claim::kUnsupported; }
bool solved(const Row& row) { return row.verdict == Verdict::kSolved; }

bool unsolvable(const Row& row) { return row.truth == Truth::kUnsolvable || row.verdict == Verdict::kUnsolvable; }

/// What the paper counts as solved.
bool passes_criterion(const Row& row) { return claimed_solved(row) && row.criterion; }

void count_answer(const Row& row, Cell& cell) {
  ++cell.trials;
  ++cell.counts[static_cast<std::size_t>(row.claim)][static_cast<std::size_t>(row.verdict)];
  if (solved(row) && row.error <= 1e-6) ++cell.solved_1e6;
  if (solved(row) && row.error <= 1e-9) ++cell.solved_1e9;
  if (passes_criterion(row)) ++cell.criterion;
  if (row.criterion) ++cell.criterion_any;
  if (unsolvable(row)) ++cell.unsolvable_problems;
  if (row.claim == Claim::kUnsolvable && row.truth == Truth::kSolvable) ++cell.false_unsolvable;
  if (row.truth == Truth::kNearly) {
    ++cell.nearly_problems;
    if (solved(row)) ++cell.nearly_solved;
    if (unsolvable(row)) ++cell.nearly_unsolvable;
  }
  Cell::Half& half = cell.halves[row.half()];
  ++half.trials;
  if (solved(row)) ++half.solved;
  if (unsolvable(row)) ++half.unsolvable_problems;
  if (passes_criterion(row)) ++half.criterion;
  if (row.criterion) ++half.criterion_any;
}

/// @param cells  of one solver, one for each parameterisation
void count_answers(const Answers& answers, std::span<Cell> cells) {
  for (const Row& row : answers.rows) {
    for (const std::uint32_t number : *row.cells) count_answer(row, cells[number]);
  }
  for (std::size_t number = 0; number < cells.size(); ++number) {
    Cell& cell = cells[number];
    const auto& refusals = answers.refusals[number];
    const auto most = std::max_element(refusals.begin(), refusals.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != refusals.end()) cell.refusal = most->first;
    cell.rate_interval = wilson(cell.count(Verdict::kSolved), cell.solvable());
    const Answers::Parts& parts = answers.parts[number];
    for (const auto part : kTimeParts) cell.time_parts.*part = parts.sums.*part / parts.timed;
  }
}

/// The rows that have a number, by its size.
using Order = std::vector<std::pair<double, const Row*>>;

/// @param value_of  NaN leaves the answer out
template <class ValueOf>
Order order_by(const Rows& rows, ValueOf value_of) {
  Order order;
  order.reserve(rows.size());
  for (const Row& row : rows) {
    const double value = value_of(row);
    if (!std::isnan(value)) order.emplace_back(value, &row);
  }
  std::sort(order.begin(), order.end());
  return order;
}

/// A quantity of each parameterisation's trials, ascending: of all, of the even and of the odd ones.
struct Sample {
  std::vector<double> all;
  std::array<std::vector<double>, 2> halves;
};

/// Hands each value to the parameterisations that share it.
template <class Condition>
std::vector<Sample> distribute(const Order& order, std::size_t cells, Condition condition) {
  std::vector<Sample> samples(cells);
  for (const auto& [value, row] : order) {
    if (!condition(*row)) continue;
    for (const std::uint32_t number : *row->cells) {
      samples[number].all.push_back(value);
      samples[number].halves[row->half()].push_back(value);
    }
  }
  return samples;
}

/// One of a cell's spreads, of all trials and of its halves.
template <class Condition>
void measure(const Order& order, std::span<Cell> cells, Spread Cell::*whole, Spread Cell::Half::*half,
             Condition condition) {
  const std::vector<Sample> samples = distribute(order, cells.size(), condition);
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].*whole = spread_of_sorted(samples[number].all);
    if (half == nullptr) continue;
    for (std::size_t i = 0; i < 2; ++i) cells[number].halves[i].*half = spread_of_sorted(samples[number].halves[i]);
  }
}

void measure_answers(const Rows& rows, std::span<Cell> cells) {
  using Half = Cell::Half;
  const auto any = [](const Row& row) { return row.criterion; };  // whatever was claimed
  const Order times = order_by(rows, [](const Row& row) { return row.time_s; });
  measure(times, cells, &Cell::all_time, &Half::all_time, [](const Row& row) { return !refused(row); });
  measure(times, cells, &Cell::solved_time, &Half::solved_time, solved);
  measure(times, cells, &Cell::criterion_time, &Half::criterion_time, passes_criterion);
  measure(times, cells, &Cell::criterion_any_time, &Half::criterion_any_time, any);
  const Order violations = order_by(rows, [](const Row& row) { return row.violation_m_per_s; });
  measure(violations, cells, &Cell::violation, &Half::violation, solved);
  measure(violations, cells, &Cell::criterion_violation, &Half::criterion_violation, passes_criterion);
  measure(violations, cells, &Cell::criterion_any_violation, &Half::criterion_any_violation, any);
  const auto where_modelled = [](auto value) {
    return [=](const Row& row) { return solved(row) && !std::isnan(row.model_error_m_per_s) ? row.*value : kNoNumber; };
  };
  const auto all = [](const Row&) { return true; };
  measure(order_by(rows, where_modelled(&Row::solver_error_m_per_s)), cells, &Cell::solver_error, nullptr, all);
  measure(order_by(rows, where_modelled(&Row::model_error_m_per_s)), cells, &Cell::model_error, nullptr, all);
  const auto pivots = [](const Row& row) { return row.pivots < 0 ? kNoNumber : static_cast<double>(row.pivots); };
  measure(order_by(rows, pivots), cells, &Cell::pivots, nullptr, all);
}

/// Errors of the answers claimed solved; one that is no number is infinite.
void measure_errors(const Rows& rows, const SetSummary& set, bool swept, std::span<Cell> cells) {
  const char* measure = set.contact ? "velocity_residual_relative" : set.bare ? "backward_row_norm" : "";
  const auto error = [](const Row& row) { return std::isnan(row.error) ? kInfinity : row.error; };
  std::vector<Sample> errors = distribute(order_by(rows, error), cells.size(),
                                          [&](const Row& row) { return claimed_solved(row) && *measure != '\0'; });
  for (std::size_t number = 0; number < cells.size(); ++number) {
    Cell& cell = cells[number];
    std::vector<double>& sorted = errors[number].all;
    cell.error_measure = measure;
    cell.error_count = static_cast<std::int64_t>(sorted.size());
    cell.error_median = median(sorted);
    cell.error_p99 = quantile(sorted, 0.99);
    cell.error_max = sorted.empty() ? kNoNumber : sorted.back();
    sorted.shrink_to_fit();
    if (!swept) cell.errors = std::move(sorted);
  }
}

/// @param rows  of a solver by itself: one for each problem
std::vector<Outcome> outcomes_of(const Rows& rows, const std::vector<ProblemKey>& problems) {
  std::vector<Outcome> outcomes;
  for (const Row& row : rows) {
    const ProblemKey& problem = problems[row.problem];
    outcomes.push_back({.problem = problem.id,
                        .seed = problem.seed,
                        .trial = problem.trial,
                        .claimed = claimed_solved(row),
                        .solved = solved(row),
                        .false_claim = row.verdict == Verdict::kWrong,
                        .unsolvable = unsolvable(row),
                        .refused = refused(row),
                        .time_s = refused(row) ? kNoNumber : row.time_s,
                        .error = row.error});
  }
  return outcomes;
}

Estimate median_time_of(const Rows& rows) {
  std::vector<double> times;
  for (const Row& row : rows) {
    if (!refused(row) && !std::isnan(row.time_s)) times.push_back(row.time_s);
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

/// Of one set, by solver (store id).
using AnswersOfSet = std::map<std::int64_t, Answers>;

/// The reference at the solver's instruction-set level, else at any; nullptr where the set has none.
const Rows* find_reference(const std::vector<Source>& sources, const Source& source, const AnswersOfSet& answers) {
  const Rows* found = nullptr;
  for (const Source& candidate : sources) {
    const auto of = answers.find(candidate.id);
    if (!is_reference(candidate.row) || of == answers.end()) continue;
    if (candidate.row.isa == source.row.isa) return &of->second.rows;
    if (found == nullptr) found = &of->second.rows;
  }
  return found;
}

/// Over the reference's times on the problems that both solved. Both lists are by problem.
void add_time_ratios(const Rows& rows, const Rows* reference, std::span<Cell> cells) {
  std::vector<std::array<std::vector<double>, 2>> paired(cells.size());
  auto other = reference == nullptr ? rows.end() : reference->begin();
  for (const Row& row : rows) {
    while (reference != nullptr && other != reference->end() && other->problem < row.problem) ++other;
    if (reference == nullptr || other == reference->end()) break;
    const bool both = other->problem == row.problem && solved(row) && solved(*other);
    if (!both || std::isnan(row.time_s) || std::isnan(other->time_s)) continue;
    for (const std::uint32_t number : *row.cells) {
      paired[number][0].push_back(row.time_s);
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
                             const std::vector<ProblemKey>& problems, const Rows* reference) {
  const Rows& rows = answers.rows;
  std::vector<Cell> cells(source.solvers.size());
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].set = set;
    cells[number].solver = source.solvers[number];
  }
  count_answers(answers, cells);
  measure_answers(rows, cells);
  measure_errors(rows, summary, source.swept(), cells);
  add_time_ratios(rows, reference, cells);
  for (Cell& cell : cells) {
    if (!source.swept()) cell.outcomes = outcomes_of(rows, problems);
    cell.median_time = source.swept() ? Estimate{cell.all_time.median, kNoNumber, kNoNumber} : median_time_of(rows);
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
      solvers.push_back({stored.cell(cell), sources.size(), cell});
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
  SetSummary* summary = nullptr;
  std::vector<ProblemKey> problems;
  AnswersOfSet answers;
};

/// One scan of the answers: the sets and the coverage of the summary, and the answers of each of its sets.
/// @param scan  keeps the lists of parameterisations that the rows point to
std::vector<SetOfAnswers> read_answers(sqlite::Database& database, AnswerScan& scan, const std::vector<Source>& sources,
                                       Summary& summary) {
  std::unordered_map<std::int64_t, const Source*> source_of;
  for (const Source& source : sources) source_of[source.id] = &source;
  const auto least_violations = read_least_violations(database);
  const auto named = read_sets(database);
  for (const auto& [id, set] : named) summary.sets.push_back(set);
  std::vector<SetOfAnswers> sets(named.size());
  std::unordered_map<std::int64_t, SetOfAnswers*> set_of;
  for (std::size_t set = 0; set < sets.size(); ++set) {
    sets[set].summary = &summary.sets[set];
    set_of[named[set].first] = &sets[set];
  }
  std::map<Work, Done> done;
  scan.read(std::nullopt, [&](const AnsweredProblem& problem) {
    const ProblemRow& row = problem.row;
    SetOfAnswers& set = *set_of.at(row.set_id);
    count_problem(problem, *set.summary);
    if (problem.truth == Truth::kUnsolvable) summary.unsolvable.push_back(row.id);
    if (problem.truth == Truth::kNearly) {
      const auto proven = least_violations.find(row.id);
      count_nearly(problem, proven == least_violations.end() ? kNoNumber : proven->second, *set.summary);
    }
    for (const StoredAnswer& answer : problem.answers) {
      const Source& source = *source_of.at(answer.solver_id);
      Answers& of = set.answers[answer.solver_id];
      if (of.done == nullptr) {
        of.parts.resize(source.solvers.size());
        of.refusals.resize(source.solvers.size());
        of.done = &done[{set.summary->name, source.row.text(), source.row.sweep}];
      }
      of.done->add(row.id);
      add_answer(answer, set.problems.size(), of);
    }
    set.problems.push_back({row.id, static_cast<std::int64_t>(row.seed), row.trial});
  });
  summary.coverage = coverage_of(database, done);
  return sets;
}

}  // namespace

Summary summarize(Store& store, const SetVisitor& visit) {
  Summary summary;
  sqlite::Database& database = store.database();
  const sqlite::ReadSnapshot snapshot(database);  // a run may be writing
  summary.runs = read_runs(database);
  const std::vector<Source> sources = read_solvers(store, summary);
  AnswerScan scan(store);
  std::vector<SetOfAnswers> sets = read_answers(database, scan, sources, summary);
  for (std::size_t set = 0; set < sets.size(); ++set) {
    const auto first = static_cast<std::ptrdiff_t>(summary.cells.size());
    for (const Source& source : sources) {
      const auto of = sets[set].answers.find(source.id);
      if (of == sets[set].answers.end()) continue;
      const Rows* reference = find_reference(sources, source, sets[set].answers);
      for (Cell& cell : make_cells(set, summary.sets[set], source, of->second, sets[set].problems, reference)) {
        summary.cells.push_back(std::move(cell));
      }
      if (!is_reference(source.row)) sets[set].answers.erase(of);  // millions of rows are not held longer than needed
    }
    sets[set] = {};
    std::sort(summary.cells.begin() + first, summary.cells.end(),
              [](const Cell& a, const Cell& b) { return a.solver < b.solver; });
    const std::span<Cell> of_set(summary.cells.begin() + first, summary.cells.end());
    if (!visit) continue;
    visit(summary, of_set);
    for (Cell& cell : of_set) cell.outcomes = {};
  }
  summary.sweeps = summarize_sweeps(summary);
  return summary;
}

}  // namespace lcpbench
