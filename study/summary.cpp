#include "study/summary.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string_view>

#include "core/error.h"

namespace lcpbench {

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double share(std::int64_t part, std::int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : kNone;
}

/// One answer as the store holds it.
struct Row {
  std::int64_t problem = 0;
  std::int64_t trial = 0;
  Claim claim = Claim::kNumericalFailure;
  Verdict verdict = Verdict::kOpen;
  bool criterion = false;
  double velocity_residual = 0;
  double backward_error = 0;
  double violation_m_per_s = 0;
  TimeParts times;
  std::string detail;

  double time_s() const { return times.setup_cpu + times.solve_cpu; }
};

bool asks_for_ill_conditioning(const std::string& set) {
  return set.find("exp5-") != std::string::npos || set.find("exp6-") != std::string::npos ||
         set.find("extra100") != std::string::npos;
}

std::vector<std::pair<std::int64_t, SetSummary>> read_sets(sqlite::Database& store) {
  sqlite::Statement query(store,
                          "SELECT s.id, s.name, COUNT(*), SUM(p.kind <> 'lcp'), SUM(p.nc > 0 AND p.n > p.nc),"
                          " SUM(t.truth = 'solvable'), MIN(p.n), MAX(p.n)"
                          " FROM sets s JOIN problems p ON p.set_id = s.id JOIN truths t ON t.problem_id = p.id"
                          " GROUP BY s.id");
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
    sets.emplace_back(query.integer(0), std::move(set));
  }
  std::sort(sets.begin(), sets.end(),
            [](const auto& a, const auto& b) { return natural_less(a.second.name, b.second.name); });
  return sets;
}

std::vector<RunSummary> read_runs(sqlite::Database& store) {
  sqlite::Statement query(store, "SELECT started, provenance FROM runs ORDER BY started, id");
  std::vector<RunSummary> runs;
  while (query.step()) {
    auto provenance = nlohmann::ordered_json::parse(query.text(1), nullptr, false);
    if (provenance.is_discarded()) provenance = std::string(query.text(1));
    runs.push_back({std::string(query.text(0)), std::move(provenance)});
  }
  return runs;
}

/// The answers to one set, by solver (store id), each list by problem.
std::map<std::int64_t, std::vector<Row>> read_answers(sqlite::Database& store, std::int64_t set_id) {
  sqlite::Statement query(store,
                          "SELECT j.solver_id, j.problem_id, j.trial, j.claim, j.verdict, v.criterion,"
                          " v.velocity_residual_relative, v.backward_row_norm, v.violation_m_per_s,"
                          " t.setup_wall_s, t.setup_cpu_s, t.solve_wall_s, t.solve_cpu_s, t.transport_s, t.verify_s, "
                          "CASE j.claim WHEN 'unsupported' THEN a.detail ELSE '' END"
                          " FROM judged j JOIN answers a USING (problem_id, solver_id)"
                          " JOIN verdicts v USING (problem_id, solver_id)"
                          " LEFT JOIN timings t USING (problem_id, solver_id)"
                          " WHERE j.set_id = ? ORDER BY j.problem_id");
  query.bind(1, set_id);
  std::map<std::int64_t, std::vector<Row>> answers;
  while (query.step()) {
    Row row;
    row.problem = query.integer(1);
    row.trial = query.integer(2);
    row.claim = stored_claim(store, query.text(3));
    row.verdict = stored_verdict(store, query.text(4));
    row.criterion = query.integer(5) != 0;
    row.velocity_residual = query.real(6);
    row.backward_error = query.real(7);
    row.violation_m_per_s = query.real(8);
    row.times = {query.real(9), query.real(10), query.real(11), query.real(12), query.real(13), query.real(14)};
    row.detail = query.text(15);
    answers[query.integer(0)].push_back(std::move(row));
  }
  return answers;
}

bool claimed_solved(const Row& row) { return row.claim == Claim::kSolved; }
bool refused(const Row& row) { return row.claim == Claim::kUnsupported; }
bool solved(const Row& row) { return row.verdict == Verdict::kSolved; }

const char* error_measure(const SetSummary& set) {
  if (set.contact) return "velocity_residual_relative";
  if (set.bare) return "backward_row_norm";
  return "";
}

/// What the verdict was taken on: rho of a contact problem, else the backward error. NaN: the answer has none.
double error_of(const Row& row) {
  return std::isnan(row.velocity_residual) ? row.backward_error : row.velocity_residual;
}

void count_answers(const std::vector<Row>& rows, Cell& cell) {
  std::map<std::string, std::int64_t> refusals;
  for (const Row& row : rows) {
    ++cell.trials;
    ++cell.counts[static_cast<std::size_t>(row.claim)][static_cast<std::size_t>(row.verdict)];
    const double error = error_of(row);
    if (solved(row) && error <= 1e-6) ++cell.solved_1e6;
    if (solved(row) && error <= 1e-9) ++cell.solved_1e9;
    if (claimed_solved(row) && row.criterion) ++cell.criterion;
    if (refused(row)) ++refusals[row.detail];
    Cell::Half& half = cell.halves[static_cast<std::size_t>(row.trial & 1)];
    ++half.trials;
    if (solved(row)) ++half.solved;
    if (row.verdict == Verdict::kUnsolvable) ++half.unsolvable;
  }
  const auto most = std::max_element(refusals.begin(), refusals.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most != refusals.end()) cell.refusal = most->first;
  cell.rate_interval = wilson(cell.count(Verdict::kSolved), cell.solvable());
}

/// Means of the parts of the times of all timed trials that were not refused.
TimeParts mean_parts(const std::vector<Row>& rows) {
  TimeParts total;
  double timed = 0;
  for (const Row& row : rows) {
    if (std::isnan(row.time_s()) || refused(row)) continue;
    timed += 1;
    total.setup_wall += row.times.setup_wall;
    total.setup_cpu += row.times.setup_cpu;
    total.solve_wall += row.times.solve_wall;
    total.solve_cpu += row.times.solve_cpu;
    total.transport += row.times.transport;
    total.verify += row.times.verify;
  }
  return {total.setup_wall / timed, total.setup_cpu / timed, total.solve_wall / timed,
          total.solve_cpu / timed,  total.transport / timed, total.verify / timed};
}

void measure_answers(const std::vector<Row>& rows, bool with_intervals, Cell& cell) {
  std::vector<double> solved_times;
  std::vector<double> all_times;
  std::vector<double> violations;
  for (const Row& row : rows) {
    if (!std::isnan(row.time_s()) && !refused(row)) all_times.push_back(row.time_s());
    if (!std::isnan(row.time_s()) && solved(row)) solved_times.push_back(row.time_s());
    if (!std::isnan(row.violation_m_per_s) && solved(row)) violations.push_back(row.violation_m_per_s);
  }
  cell.solved_time = spread(solved_times);
  cell.all_time = spread(all_times);
  cell.violation = spread(violations);
  cell.time_parts = mean_parts(rows);
  cell.median_time = with_intervals ? median_estimate(all_times) : Estimate{cell.all_time.median, kNone, kNone};
}

void measure_errors(const std::vector<Row>& rows, const SetSummary& set, Cell& cell) {
  cell.error_measure = error_measure(set);
  std::vector<double> errors;
  for (const Row& row : rows) {
    if (!claimed_solved(row)) continue;
    const double error = error_of(row);
    errors.push_back(std::isnan(error) ? kInfinity : error);
  }
  std::sort(errors.begin(), errors.end());
  if (*cell.error_measure == '\0') errors.clear();
  cell.error_count = static_cast<std::int64_t>(errors.size());
  cell.error_median = median(errors);
  cell.error_p99 = quantile(errors, 0.99);
  cell.error_max = errors.empty() ? kNone : errors.back();
  cell.errors = std::move(errors);
}

std::vector<Outcome> outcomes_of(const std::vector<Row>& rows) {
  std::vector<Outcome> outcomes;
  outcomes.reserve(rows.size());
  for (const Row& row : rows) {
    outcomes.push_back({.problem = row.problem,
                        .trial = row.trial,
                        .solved = solved(row),
                        .false_claim = false_claim(row.claim, row.verdict),
                        .unsolvable = row.verdict == Verdict::kUnsolvable,
                        .refused = refused(row),
                        .time_s = refused(row) ? kNone : row.time_s(),
                        .error = error_of(row)});
  }
  return outcomes;
}

/// Is this the solver that all time ratios refer to: the paper's algorithm as published, `lemke{engine=dense}` and
/// nothing else off its default?
bool is_reference(const SolverRow& solver) {
  if (solver.name != "lemke") return false;
  if (solver.settings == "engine=dense") return true;
  return solver.settings.empty() && solver.all_settings.find("engine=dense") != std::string::npos;
}

void relate_to_reference(const std::vector<Outcome>& reference, bool with_intervals, Cell& cell) {
  std::vector<double> reference_times;
  std::vector<double> times;
  auto other = reference.begin();
  for (const Outcome& outcome : cell.outcomes) {
    while (other != reference.end() && other->problem < outcome.problem) ++other;
    if (other == reference.end()) break;
    if (other->problem != outcome.problem || !outcome.solved || !other->solved) continue;
    if (std::isnan(outcome.time_s) || std::isnan(other->time_s)) continue;
    reference_times.push_back(other->time_s);
    times.push_back(outcome.time_s);
  }
  cell.paired = static_cast<std::int64_t>(times.size());
  if (with_intervals) {
    cell.time_ratio = ratio_of_sums(times, reference_times);
    return;
  }
  const double total = std::accumulate(times.begin(), times.end(), 0.0);
  const double reference_total = std::accumulate(reference_times.begin(), reference_times.end(), 0.0);
  cell.time_ratio = {reference_total > 0 ? total / reference_total : kNone, kNone, kNone};
}

/// The reference at the cell's instruction-set level, else at any.
const Cell* find_reference(const std::vector<SolverRow>& solvers, std::span<const Cell> cells, const Cell& cell) {
  const Cell* found = nullptr;
  for (const Cell& candidate : cells) {
    if (!is_reference(solvers[candidate.solver])) continue;
    if (solvers[candidate.solver].isa == solvers[cell.solver].isa) return &candidate;
    if (found == nullptr) found = &candidate;
  }
  return found;
}

void add_time_ratios(const std::vector<SolverRow>& solvers, std::span<Cell> cells) {
  constexpr Estimate kNoRatio{kNone, kNone, kNone};
  for (Cell& cell : cells) {
    const Cell* reference = find_reference(solvers, cells, cell);
    cell.time_ratio = kNoRatio;
    if (reference != nullptr) relate_to_reference(reference->outcomes, solvers[cell.solver].sweep.empty(), cell);
  }
  for (Cell& cell : cells) {
    if (solvers[cell.solver].sweep.empty()) continue;
    cell.outcomes = {};
    cell.errors = {};
  }
}

Cell make_cell(std::size_t set_index, std::size_t solver_index, const Summary& summary, const std::vector<Row>& rows) {
  Cell cell;
  cell.set = set_index;
  cell.solver = solver_index;
  count_answers(rows, cell);
  measure_answers(rows, summary.solvers[solver_index].sweep.empty(), cell);
  measure_errors(rows, summary.sets[set_index], cell);
  cell.outcomes = outcomes_of(rows);
  return cell;
}

/// A rate of every cell of a sweep; NaN rates (all problems unsolvable) leave the range NaN.
template <class Rate>
SweepSummary::Range range_over(const Summary& summary, const std::vector<const Cell*>& cells, Rate rate) {
  SweepSummary::Range range{kInfinity, 0, -kInfinity, "", ""};
  for (const Cell* cell : cells) {
    const double value = rate(*cell);
    if (std::isnan(value)) return {kNone, kNone, kNone, "", ""};
    const std::string& settings = summary.solvers[cell->solver].settings;
    range.average += value / static_cast<double>(cells.size());
    if (value < range.worst) {
      range.worst = value;
      range.worst_settings = settings;
    }
    if (value > range.best) {
      range.best = value;
      range.best_settings = settings;
    }
  }
  range.average = std::clamp(range.average, range.worst, range.best);  // the sum is rounded
  return range;
}

double best_held_out(const std::vector<const Cell*>& cells) {
  const Cell* best = nullptr;
  for (const Cell* cell : cells) {
    if (std::isnan(cell->halves[0].rate())) continue;
    if (best == nullptr || cell->halves[0].rate() > best->halves[0].rate()) best = cell;
  }
  return best == nullptr ? kNone : best->halves[1].rate();
}

std::vector<SweepSummary> summarize_sweeps(const Summary& summary) {
  struct Key {
    std::size_t set;
    std::string solver, sweep, isa;
    auto operator<=>(const Key&) const = default;
  };
  std::map<Key, std::vector<const Cell*>> groups;
  for (const Cell& cell : summary.cells) {
    const SolverRow& solver = summary.solvers[cell.solver];
    if (!solver.sweep.empty()) groups[{cell.set, solver.name, solver.sweep, solver.isa}].push_back(&cell);
  }
  std::vector<SweepSummary> sweeps;
  for (const auto& [key, cells] : groups) {
    SweepSummary sweep{key.set, key.solver, key.sweep, key.isa, static_cast<std::int64_t>(cells.size()), 0, {}, {}, 0};
    sweep.trials = (*std::min_element(cells.begin(), cells.end(), [](const Cell* a, const Cell* b) {
                     return a->trials < b->trials;
                   }))->trials;
    sweep.verdict = range_over(summary, cells, [](const Cell& cell) { return cell.rate(); });
    sweep.criterion = range_over(summary, cells, [](const Cell& cell) { return cell.criterion_rate(); });
    sweep.best_held_out = best_held_out(cells);
    sweeps.push_back(std::move(sweep));
  }
  return sweeps;
}

nlohmann::ordered_json nullable(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(text);
}

nlohmann::ordered_json spread_json(const Spread& values, bool with_median) {
  nlohmann::ordered_json json{{"mean", values.mean}, {"sigma", values.sigma}, {"max", values.max}};
  if (with_median) json["median"] = values.median;
  return json;
}

nlohmann::ordered_json claims_json(const Cell& cell) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Claim claim : kAllClaims) {
    for (const Verdict verdict : kAllVerdicts) {
      json[to_string(claim)][to_string(verdict)] = cell.count(claim, verdict);
    }
  }
  return json;
}

nlohmann::ordered_json cell_json(const Summary& summary, const Cell& cell) {
  const SolverRow& solver = summary.solvers[cell.solver];
  nlohmann::ordered_json json;
  json["set"] = summary.sets[cell.set].name;
  json["solver"] = solver.name;
  json["settings"] = solver.settings;
  json["library"] = solver.library;
  json["version"] = solver.version;
  json["isa"] = solver.isa;
  json["sweep"] = solver.sweep;
  json["trials"] = cell.trials;
  json["claimed"] = cell.count(Claim::kSolved);
  json["solved"] = cell.count(Verdict::kSolved);
  json["solved_1e6"] = cell.solved_1e6;
  json["solved_1e9"] = cell.solved_1e9;
  json["criterion"] = cell.criterion;
  for (const Verdict verdict : kAllVerdicts) {
    if (verdict != Verdict::kSolved) json[to_string(verdict)] = cell.count(verdict);
  }
  json["false_claims"] = cell.false_claims();
  json["gave_up"] = cell.gave_up();
  for (const Claim claim : {Claim::kTimeLimit, Claim::kUnsupported, Claim::kCrashed}) {
    json[to_string(claim)] = cell.count(claim);
  }
  json["rate"] = cell.rate();
  json["rate_low"] = cell.rate_interval.low;
  json["rate_high"] = cell.rate_interval.high;
  json["time"]["solved"] = spread_json(cell.solved_time, true);
  json["time"]["all"] = spread_json(cell.all_time, true);
  json["time"]["all"]["median_low"] = cell.median_time.low;
  json["time"]["all"]["median_high"] = cell.median_time.high;
  json["time"]["parts_mean"] = {{"setup_wall", cell.time_parts.setup_wall}, {"setup_cpu", cell.time_parts.setup_cpu},
                                {"solve_wall", cell.time_parts.solve_wall}, {"solve_cpu", cell.time_parts.solve_cpu},
                                {"transport", cell.time_parts.transport},   {"verify", cell.time_parts.verify}};
  json["time_ratio"] = cell.time_ratio.value;
  json["time_ratio_low"] = cell.time_ratio.low;
  json["time_ratio_high"] = cell.time_ratio.high;
  json["time_ratio_problems"] = cell.paired;
  json["violation"] = spread_json(cell.violation, false);
  json["error"]["measure"] = nullable(cell.error_measure);
  json["error"]["answers"] = cell.error_count;
  json["error"]["median"] = cell.error_median;
  json["error"]["p99"] = cell.error_p99;
  json["error"]["max"] = cell.error_max;
  json["claims"] = claims_json(cell);
  return json;
}

nlohmann::ordered_json range_json(const SweepSummary::Range& range) {
  return {{"worst", range.worst},
          {"average", range.average},
          {"best", range.best},
          {"worst_settings", range.worst_settings},
          {"best_settings", range.best_settings}};
}

nlohmann::ordered_json sweep_json(const Summary& summary, const SweepSummary& sweep) {
  nlohmann::ordered_json json{
      {"set", summary.sets[sweep.set].name}, {"solver", sweep.solver}, {"sweep", sweep.sweep}, {"isa", sweep.isa},
      {"cells", sweep.parameterisations},    {"trials", sweep.trials}};
  json.update(range_json(sweep.verdict));
  json["best_held_out"] = sweep.best_held_out;
  json["criterion"] = range_json(sweep.criterion);
  return json;
}

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// The run of digits at `at`, leading zeros skipped; `at` moves behind it.
std::string_view take_number(const std::string& text, std::size_t& at) {
  while (at < text.size() && text[at] == '0') ++at;
  const std::size_t begin = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return std::string_view(text).substr(begin, at - begin);
}

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view left = take_number(a, i);
      const std::string_view right = take_number(b, j);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;
}

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
  std::int64_t total = 0;
  for (const Verdict verdict : {Verdict::kCriterionOnly, Verdict::kMissed, Verdict::kOpen}) {
    total += count(verdict) - count(Claim::kSolved, verdict);
  }
  return total;
}

double Cell::rate() const { return share(count(Verdict::kSolved), solvable()); }
double Cell::criterion_rate() const { return share(criterion, trials); }
double Cell::Half::rate() const { return share(solved, trials - unsolvable); }

Summary summarize(Store& store) {
  Summary summary;
  sqlite::Database& database = store.database();
  summary.runs = read_runs(database);
  std::vector<StoredSolver> solvers = store.solvers();
  std::stable_sort(solvers.begin(), solvers.end(), [](const StoredSolver& a, const StoredSolver& b) {
    return natural_less(a.row.text(), b.row.text());
  });
  for (const StoredSolver& solver : solvers) {
    summary.solvers.push_back(solver.row);
    if (is_reference(solver.row)) summary.reference = solver.row.text();
  }

  const auto sets = read_sets(database);
  for (const auto& [id, set] : sets) summary.sets.push_back(set);
  for (std::size_t set = 0; set < sets.size(); ++set) {
    const auto answers = read_answers(database, sets[set].first);
    const std::size_t first = summary.cells.size();
    for (std::size_t solver = 0; solver < solvers.size(); ++solver) {
      const auto rows = answers.find(solvers[solver].id);
      if (rows != answers.end()) summary.cells.push_back(make_cell(set, solver, summary, rows->second));
    }
    add_time_ratios(summary.solvers, std::span(summary.cells).subspan(first));
  }
  summary.sweeps = summarize_sweeps(summary);
  return summary;
}

nlohmann::ordered_json summary_json(const Summary& summary) {
  nlohmann::ordered_json json;
  json["provenance"]["reference"] = nullable(summary.reference);
  json["provenance"]["runs"] = nlohmann::ordered_json::array();
  for (const RunSummary& run : summary.runs) {
    json["provenance"]["runs"].push_back({{"started", run.started}, {"provenance", run.provenance}});
  }
  json["cells"] = nlohmann::ordered_json::array();
  for (const Cell& cell : summary.cells) json["cells"].push_back(cell_json(summary, cell));
  json["sweeps"] = nlohmann::ordered_json::array();
  for (const SweepSummary& sweep : summary.sweeps) json["sweeps"].push_back(sweep_json(summary, sweep));
  return json;
}

}  // namespace lcpbench
