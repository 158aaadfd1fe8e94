#include "study/summary/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>
#include <span>
#include <unordered_set>
#include <utility>

#include "study/statistics/pairs.h"

namespace lcpbench {

namespace {

constexpr std::int64_t kMostPivots = std::numeric_limits<std::int32_t>::max();

/// One distinct answer as the store holds it, as small as may be: a set may have millions.
struct Row {
  std::int64_t problem = 0;
  std::int64_t seed = 0;
  std::int64_t trial = 0;
  std::shared_ptr<const std::vector<std::uint32_t>> cells;  ///< parameterisations that gave it
  Claim claim = Claim::kNumericalFailure;
  Verdict verdict = Verdict::kOpen;
  bool criterion = false;
  Truth truth = Truth::kUnknown;
  double velocity_residual = 0;
  double backward_error = 0;
  double forward_error = kNoNumber;
  double violation_m_per_s = 0;
  double solver_error_m_per_s = 0;
  double model_error_m_per_s = 0;
  std::int32_t pivots = -1;
  TimeParts times;
  const std::string* detail = nullptr;  ///< why it was refused

  double time_s() const { return times.setup_cpu + times.solve_cpu; }
  std::size_t half() const { return static_cast<std::size_t>(trial & 1); }
};

bool asks_for_ill_conditioning(const std::string& set) {
  return set.find("exp5-") != std::string::npos || set.find("exp6-") != std::string::npos ||
         set.find("extra100") != std::string::npos;
}

std::vector<std::pair<std::int64_t, SetSummary>> read_sets(sqlite::Database& store) {
  sqlite::Statement query(
      store,
      "SELECT s.id, s.name, COUNT(*), SUM(p.kind <> 'lcp'), SUM(p.nc > 0 AND p.n > p.nc), "
      "SUM(t.truth = 'solvable'), MIN(p.n), MAX(p.n), SUM(p.free_bodies), SUM(t.truth = 'nearly'), "
      "MIN(iif(t.truth = 'nearly', IFNULL((SELECT MAX(d) FROM (SELECT least_violation_m_per_s AS d FROM certificates c "
      "WHERE c.problem_id = p.id UNION ALL SELECT least_violation_m_per_s FROM verdicts v WHERE v.problem_id = p.id "
      "AND v.farkas_checked = 1)), 0), NULL)) FROM sets s JOIN problems p ON p.set_id = s.id JOIN truths t ON "
      "t.problem_id = p.id GROUP BY s.id");
  std::vector<std::pair<std::int64_t, SetSummary>> sets;
  while (query.step()) {
    SetSummary set;
    set.name = query.text(1);
    set.problems = query.integer(2);
    set.contact = query.integer(3) == set.problems;
    set.bare = query.integer(3) == 0;
    set.frictional = query.integer(4) > 0;
    set.all_solvable = query.integer(5) == set.problems;
    set.ill_conditioned = asks_for_ill_conditioning(set.name);
    set.smallest_n = query.integer(6);
    set.largest_n = query.integer(7);
    set.free_bodies = query.integer(8) == set.problems;
    set.nearly = query.integer(9);
    set.least_violation_m_per_s = query.real(10);
    sets.emplace_back(query.integer(0), std::move(set));
  }
  std::sort(sets.begin(), sets.end(),
            [](const auto& a, const auto& b) { return natural_less(a.second.name, b.second.name); });
  return sets;
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

/// Problems of a set whose only post-impact velocity is certified.
std::unordered_set<std::int64_t> read_unique_velocities(sqlite::Database& store, std::int64_t set_id) {
  std::unordered_set<std::int64_t> problems;
  sqlite::Statement query(store,
                          "SELECT c.problem_id FROM certificates c JOIN problems p ON p.id = c.problem_id"
                          " WHERE p.set_id = ? AND c.velocity_unique = 1 AND c.velocity IS NOT NULL");
  query.bind_all(set_id);
  while (query.step()) problems.insert(query.integer(0));
  return problems;
}

/// The answers to one set, by solver (store id), each list by problem and part. @param details  keeps the reasons of
/// refusals
std::map<std::int64_t, std::vector<Row>> read_answers(Store& store, std::int64_t set_id,
                                                      const std::unordered_set<std::int64_t>& unique_velocities,
                                                      std::set<std::string>& details) {
  std::map<std::int64_t, std::vector<Row>> answers;
  const auto add = [&](const StoredAnswer& answer) {
    const Errors& errors = answer.errors;
    const SolveTimes& times = answer.times;
    Row& row = answers[answer.solver_id].emplace_back();
    row.problem = answer.problem_id;
    row.seed = static_cast<std::int64_t>(answer.seed);
    row.trial = answer.trial;
    row.cells = answer.cells;
    row.claim = answer.claim;
    row.verdict = answer.verdict;
    row.criterion = errors.criterion;
    row.truth = answer.truth;
    row.velocity_residual = errors.velocity_residual_relative;
    row.backward_error = errors.backward_row_norm;
    row.violation_m_per_s = errors.violation_m_per_s;
    row.solver_error_m_per_s = errors.velocity_residual_m_per_s;
    row.model_error_m_per_s = errors.model_error_m_per_s;
    if (unique_velocities.contains(row.problem)) {
      row.forward_error = errors.usable ? errors.forward_velocity : kInfinity;
    }
    row.pivots = static_cast<std::int32_t>(std::min<std::int64_t>(answer.counters.pivots, kMostPivots));
    row.times = {times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s,
                 times.solve_cpu_s,  times.transport_s, answer.verify_s};
    if (answer.claim == Claim::kUnsupported) row.detail = &*details.insert(answer.detail).first;
  };
  store.for_each_answer(add, set_id);
  return answers;
}

bool claimed_solved(const Row& row) { return row.claim == Claim::kSolved; }
bool refused(const Row& row) { return row.claim == Claim::kUnsupported; }
bool solved(const Row& row) { return row.verdict == Verdict::kSolved; }

bool unsolvable(const Row& row) { return row.truth == Truth::kUnsolvable || row.verdict == Verdict::kUnsolvable; }

const char* error_measure(const SetSummary& set) {
  if (set.contact) return "velocity_residual_relative";
  if (set.bare) return "backward_row_norm";
  return "";
}

/// What the verdict was taken on: rho of a contact problem, else the backward error. NaN: the answer has none.
double error_of(const Row& row) {
  return std::isnan(row.velocity_residual) ? row.backward_error : row.velocity_residual;
}

/// What the paper counts as solved.
bool passes_criterion(const Row& row) { return claimed_solved(row) && row.criterion; }
bool passes_unclaimed(const Row& row) { return row.criterion; }
bool has_model_error(const Row& row) { return solved(row) && !std::isnan(row.model_error_m_per_s); }

void count_answer(const Row& row, Cell& cell) {
  ++cell.trials;
  ++cell.counts[static_cast<std::size_t>(row.claim)][static_cast<std::size_t>(row.verdict)];
  const double error = error_of(row);
  if (solved(row) && error <= 1e-6) ++cell.solved_1e6;
  if (solved(row) && error <= 1e-9) ++cell.solved_1e9;
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
void count_answers(const std::vector<Row>& rows, std::span<Cell> cells) {
  std::vector<std::map<std::string, std::int64_t>> refusals(cells.size());
  for (const Row& row : rows) {
    for (const std::uint32_t number : *row.cells) {
      count_answer(row, cells[number]);
      if (refused(row)) ++refusals[number][*row.detail];
    }
  }
  for (std::size_t number = 0; number < cells.size(); ++number) {
    const auto most = std::max_element(refusals[number].begin(), refusals[number].end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most != refusals[number].end()) cells[number].refusal = most->first;
    cells[number].rate_interval = wilson(cells[number].count(Verdict::kSolved), cells[number].solvable());
  }
}

/// Means of the parts of the times of all timed trials that were not refused.
void measure_time_parts(const std::vector<Row>& rows, std::span<Cell> cells) {
  std::vector<double> timed(cells.size());
  for (const Row& row : rows) {
    if (std::isnan(row.time_s()) || refused(row)) continue;
    for (const std::uint32_t number : *row.cells) {
      timed[number] += 1;
      for (const auto part : kTimeParts) cells[number].time_parts.*part += row.times.*part;
    }
  }
  for (std::size_t number = 0; number < cells.size(); ++number) {
    for (const auto part : kTimeParts) cells[number].time_parts.*part /= timed[number];
  }
}

/// A quantity of each parameterisation's trials, ascending: of all, of the even and of the odd ones.
struct Sample {
  std::vector<double> all;
  std::array<std::vector<double>, 2> halves;
};

/// Sorts the distinct answers once and hands each value to the parameterisations that share it.
/// @param value_of  NaN leaves the answer out
template <class ValueOf>
std::vector<Sample> distribute(const std::vector<Row>& rows, std::size_t cells, ValueOf value_of) {
  std::vector<std::pair<double, const Row*>> values;
  values.reserve(rows.size());
  for (const Row& row : rows) {
    const double value = value_of(row);
    if (!std::isnan(value)) values.emplace_back(value, &row);
  }
  std::stable_sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Sample> samples(cells);
  for (const auto& [value, row] : values) {
    for (const std::uint32_t number : *row->cells) {
      samples[number].all.push_back(value);
      samples[number].halves[row->half()].push_back(value);
    }
  }
  return samples;
}

/// One of a cell's spreads, of all trials and of its halves.
template <class ValueOf>
void measure(const std::vector<Row>& rows, std::span<Cell> cells, Spread Cell::*whole, Spread Cell::Half::*half,
             ValueOf value_of) {
  const std::vector<Sample> samples = distribute(rows, cells.size(), value_of);
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].*whole = spread(samples[number].all);
    for (std::size_t i = 0; i < 2; ++i) cells[number].halves[i].*half = spread(samples[number].halves[i]);
  }
}

void measure_answers(const std::vector<Row>& rows, std::span<Cell> cells) {
  const auto time = [](const Row& row) { return row.time_s(); };
  const auto violation = [](const Row& row) { return row.violation_m_per_s; };
  const auto where = [](auto condition, auto value) {
    return [=](const Row& row) { return condition(row) ? value(row) : kNoNumber; };
  };
  measure(rows, cells, &Cell::all_time, &Cell::Half::all_time,
          where([](const Row& row) { return !refused(row); }, time));
  measure(rows, cells, &Cell::solved_time, &Cell::Half::solved_time, where(solved, time));
  measure(rows, cells, &Cell::violation, &Cell::Half::violation, where(solved, violation));
  measure(rows, cells, &Cell::criterion_time, &Cell::Half::criterion_time, where(passes_criterion, time));
  measure(rows, cells, &Cell::criterion_violation, &Cell::Half::criterion_violation,
          where(passes_criterion, violation));
  measure(rows, cells, &Cell::criterion_any_time, &Cell::Half::criterion_any_time, where(passes_unclaimed, time));
  measure(rows, cells, &Cell::criterion_any_violation, &Cell::Half::criterion_any_violation,
          where(passes_unclaimed, violation));
  const auto measure_whole = [&](Spread Cell::*whole, auto value_of) {
    const std::vector<Sample> samples = distribute(rows, cells.size(), value_of);
    for (std::size_t number = 0; number < cells.size(); ++number) cells[number].*whole = spread(samples[number].all);
  };
  measure_whole(&Cell::solver_error, where(has_model_error, [](const Row& row) { return row.solver_error_m_per_s; }));
  measure_whole(&Cell::model_error, where(has_model_error, [](const Row& row) { return row.model_error_m_per_s; }));
  measure_whole(&Cell::pivots,
                [](const Row& row) { return row.pivots < 0 ? kNoNumber : static_cast<double>(row.pivots); });
}

/// Errors of the answers claimed solved; one that is no number is infinite.
void measure_errors(const std::vector<Row>& rows, const SetSummary& set, bool swept, std::span<Cell> cells) {
  const char* measure = error_measure(set);
  std::vector<Sample> errors = distribute(rows, cells.size(), [measure](const Row& row) {
    if (!claimed_solved(row) || *measure == '\0') return kNoNumber;
    const double error = error_of(row);
    return std::isnan(error) ? kInfinity : error;
  });
  for (std::size_t number = 0; number < cells.size(); ++number) {
    Cell& cell = cells[number];
    std::vector<double>& sorted = errors[number].all;
    cell.error_measure = measure;
    cell.error_count = static_cast<std::int64_t>(sorted.size());
    cell.error_median = median(sorted);
    cell.error_p99 = quantile(sorted, 0.99);
    cell.error_max = sorted.empty() ? kNoNumber : sorted.back();
    if (!swept) cell.errors = std::move(sorted);
  }
}

/// @param rows  of a solver by itself: one for each problem
std::vector<Outcome> outcomes_of(const std::vector<Row>& rows) {
  std::vector<Outcome> outcomes;
  outcomes.reserve(rows.size());
  for (const Row& row : rows) {
    outcomes.push_back({.problem = row.problem,
                        .seed = row.seed,
                        .trial = row.trial,
                        .claimed = claimed_solved(row),
                        .solved = solved(row),
                        .false_claim = row.verdict == Verdict::kWrong,
                        .unsolvable = unsolvable(row),
                        .refused = refused(row),
                        .time_s = refused(row) ? kNoNumber : row.time_s(),
                        .error = error_of(row),
                        .forward_error = row.forward_error,
                        .solver_error_m_per_s = row.solver_error_m_per_s,
                        .model_error_m_per_s = row.model_error_m_per_s});
  }
  return outcomes;
}

Estimate median_time_of(const Cell& cell) {
  std::vector<double> times;
  for (const Outcome& outcome : cell.outcomes) {
    if (!std::isnan(outcome.time_s)) times.push_back(outcome.time_s);
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

/// Times of a solver's cells, each paired with the reference's.
std::vector<PairedTimes> pair_times(const std::vector<Row>& rows, std::size_t cells,
                                    const std::vector<Row>& reference) {
  std::vector<PairedTimes> paired(cells);
  for_each_pair(rows, reference, &Row::problem, [&](const Row& row, const Row& other) {
    if (!solved(row) || !solved(other)) return;
    for (const std::uint32_t number : *row.cells) paired[number].add(row.time_s(), other.time_s());
  });
  return paired;
}

Estimate plain_ratio(const PairedTimes& paired) {
  const double total = std::accumulate(paired.first.begin(), paired.first.end(), 0.0);
  const double reference = std::accumulate(paired.second.begin(), paired.second.end(), 0.0);
  return {reference > 0 ? total / reference : kNoNumber, kNoNumber, kNoNumber};
}

/// One solver of a store, and what its cells are called in the summary.
struct Source {
  std::int64_t id = 0;
  SolverRow row;
  std::vector<std::size_t> solvers;  ///< by cell: index into Summary::solvers

  bool swept() const { return !row.sweep.empty(); }
};

/// The reference at the solver's instruction-set level, else at any; nullptr where the set has none.
const std::vector<Row>* find_reference(const std::vector<Source>& sources, const Source& source,
                                       const std::map<std::int64_t, std::vector<Row>>& answers) {
  const std::vector<Row>* found = nullptr;
  for (const Source& candidate : sources) {
    const auto rows = answers.find(candidate.id);
    if (!is_reference(candidate.row) || rows == answers.end()) continue;
    if (candidate.row.isa == source.row.isa) return &rows->second;
    if (found == nullptr) found = &rows->second;
  }
  return found;
}

void add_time_ratios(const std::vector<Row>& rows, const std::vector<Row>* reference, bool swept,
                     std::span<Cell> cells) {
  for (Cell& cell : cells) cell.time_ratio = {kNoNumber, kNoNumber, kNoNumber};
  if (reference == nullptr) return;
  const std::vector<PairedTimes> paired = pair_times(rows, cells.size(), *reference);
  for (std::size_t number = 0; number < cells.size(); ++number) {
    const PairedTimes& times = paired[number];
    cells[number].paired = static_cast<std::int64_t>(times.first.size());
    cells[number].time_ratio = swept ? plain_ratio(times) : ratio_of_sums(times.first, times.second);
  }
}

/// The cells of one solver on one set.
std::vector<Cell> make_cells(std::size_t set, const SetSummary& summary, const Source& source,
                             const std::vector<Row>& rows, const std::vector<Row>* reference) {
  std::vector<Cell> cells(source.solvers.size());
  for (std::size_t number = 0; number < cells.size(); ++number) {
    cells[number].set = set;
    cells[number].solver = source.solvers[number];
  }
  count_answers(rows, cells);
  measure_time_parts(rows, cells);
  measure_answers(rows, cells);
  measure_errors(rows, summary, source.swept(), cells);
  add_time_ratios(rows, reference, source.swept(), cells);
  for (Cell& cell : cells) {
    if (!source.swept()) cell.outcomes = outcomes_of(rows);
    cell.median_time = source.swept() ? Estimate{cell.all_time.median, kNoNumber, kNoNumber} : median_time_of(cell);
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

}  // namespace

Summary summarize(Store& store, const SetVisitor& visit) {
  Summary summary;
  sqlite::Database& database = store.database();
  const sqlite::ReadSnapshot snapshot(database);  // a run may be writing
  summary.runs = read_runs(database);
  summary.coverage = coverage_of(database);
  const std::vector<Source> sources = read_solvers(store, summary);
  const auto sets = read_sets(database);
  for (const auto& [id, set] : sets) summary.sets.push_back(set);
  for (std::size_t set = 0; set < sets.size(); ++set) {
    const auto unique_velocities = read_unique_velocities(database, sets[set].first);
    summary.sets[set].unique_velocities = static_cast<std::int64_t>(unique_velocities.size());
    std::set<std::string> details;
    auto answers = read_answers(store, sets[set].first, unique_velocities, details);
    const auto first = static_cast<std::ptrdiff_t>(summary.cells.size());
    for (const Source& source : sources) {
      const auto rows = answers.find(source.id);
      if (rows == answers.end()) continue;
      const std::vector<Row>* reference = find_reference(sources, source, answers);
      for (Cell& cell : make_cells(set, summary.sets[set], source, rows->second, reference)) {
        summary.cells.push_back(std::move(cell));
      }
      if (!is_reference(source.row)) answers.erase(rows);  // millions of rows are not held longer than needed
    }
    std::sort(summary.cells.begin() + first, summary.cells.end(),
              [](const Cell& a, const Cell& b) { return a.solver < b.solver; });
    if (!visit) continue;
    const std::span<Cell> of_set(summary.cells.begin() + first, summary.cells.end());
    visit(summary, of_set);
    for (Cell& cell : of_set) cell.outcomes = {};
  }
  summary.sweeps = summarize_sweeps(summary);
  return summary;
}

}  // namespace lcpbench
