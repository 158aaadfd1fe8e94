#include "study/compare/store_comparison.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "core/error.h"
#include "core/suggestion.h"
#include "generators/glob.h"
#include "study/report/choice.h"
#include "study/statistics/pairs.h"

namespace lcpbench {

using report::kSignificance;

namespace {

/// One answer, as far as two stores are compared by it.
struct Entry {
  std::int64_t problem = 0;
  std::string hash;
  bool solved = false;
  bool false_claim = false;
  std::int64_t pivots = -1;
  double time_s = 0;
};

/// The answers of one solver to one set, by parameterisation, each list by problem.
using Entries = std::map<std::int64_t, std::vector<Entry>>;

/// The answers to one set, by solver (store id).
using Answers = std::map<std::int64_t, Entries>;

using SetIds = std::map<std::string, std::int64_t, bool (*)(const std::string&, const std::string&)>;

Answers answers_to(Store& store, const SetIds& sets, const std::string& set) {
  Answers answers;
  const auto id = sets.find(set);
  if (id == sets.end()) return answers;
  const auto add = [&answers](const StoredAnswer& answer) {
    const double time_s = answer.times.setup_cpu_s + answer.times.solve_cpu_s;
    for (const std::uint32_t cell : *answer.cells) {
      answers[answer.solver_id][cell].push_back({.problem = answer.problem_id,
                                                 .hash = answer.hash,
                                                 .solved = answer.verdict == Verdict::kSolved,
                                                 .false_claim = answer.verdict == Verdict::kWrong,
                                                 .pivots = answer.counters.pivots,
                                                 .time_s = answer.claim == Claim::kUnsupported ? kNoNumber : time_s});
    }
  };
  store.for_each_answer(add, id->second);
  return answers;
}

void count_pair(const Entry& a, const Entry& b, CellChange& change) {
  ++change.problems;
  change.solved_a += a.solved ? 1 : 0;
  change.solved_b += b.solved ? 1 : 0;
  change.lost += a.solved && !b.solved ? 1 : 0;
  change.gained += !a.solved && b.solved ? 1 : 0;
  change.false_a += a.false_claim ? 1 : 0;
  change.false_b += b.false_claim ? 1 : 0;
  change.false_gone += a.false_claim && !b.false_claim ? 1 : 0;
  change.false_new += !a.false_claim && b.false_claim ? 1 : 0;
  if (a.pivots >= 0 && b.pivots >= 0) {
    ++change.counted;
    change.pivots_a += a.pivots;
    change.pivots_b += b.pivots;
  }
}

double ratio_of_medians(const PairedTimes& times) { return spread(times.second).median / spread(times.first).median; }

void compare_times(const PairedTimes& times, bool with_interval, CellChange& change) {
  change.timed = static_cast<std::int64_t>(times.first.size());
  change.median_ratio = ratio_of_medians(times);
  if (with_interval) {
    change.time_ratio = ratio_of_sums(times.second, times.first);
    return;
  }
  change.time_ratio = {spread(times.second).mean / spread(times.first).mean, kNoNumber, kNoNumber};
}

/// Pairs the answers to problems with the same data.
void compare_entries(const std::vector<Entry>& a, const std::vector<Entry>& b, bool with_interval, CellChange& change) {
  PairedTimes times;
  for_each_pair(a, b, &Entry::problem, [&](const Entry& left, const Entry& right) {
    if (left.hash != right.hash) {
      ++change.other_data;
      return;
    }
    count_pair(left, right, change);
    if (left.solved && right.solved) times.add(left.time_s, right.time_s);
  });
  const std::int64_t met_by_both = change.problems + change.other_data;
  change.only_in_a = std::ssize(a) - met_by_both;
  change.only_in_b = std::ssize(b) - met_by_both;
  change.solved_p = mcnemar_exact(change.lost, change.gained);
  change.false_p = mcnemar_exact(change.false_gone, change.false_new);
  compare_times(times, with_interval, change);
}

// --- who is compared with whom ---

std::vector<StoredSolver> chosen_solvers(Store& store, const std::string& wanted) {
  std::vector<StoredSolver> solvers = store.solvers();
  if (wanted.empty()) return solvers;
  std::vector<std::string> known;
  for (const StoredSolver& solver : solvers) {
    if (solver.row.sweep.empty()) known.push_back(solver.row.text());
  }
  std::erase_if(solvers,
                [&](const StoredSolver& solver) { return !solver.row.sweep.empty() || solver.row.text() != wanted; });
  if (solvers.empty()) {
    throw InputError(fmt::format("{}: no solver '{}'{}; it has {}", store.file().string(), wanted,
                                 did_you_mean(wanted, known), fmt::join(known, ", ")));
  }
  return solvers;
}

using SolverPair = std::pair<StoredSolver, StoredSolver>;

struct Matching {
  std::vector<SolverPair> pairs;
  std::vector<StoredSolver> only_in_a;
  std::vector<StoredSolver> only_in_b;
};

/// Pairs solvers for which `same` holds and moves them out of both lists.
template <class Same>
void take_pairs(std::vector<StoredSolver>& a, std::vector<StoredSolver>& b, Same same, Matching& matching) {
  std::vector<StoredSolver> unmatched;
  for (StoredSolver& solver : a) {
    const auto partner =
        std::find_if(b.begin(), b.end(), [&](const StoredSolver& other) { return same(solver.row, other.row); });
    if (partner == b.end()) {
      unmatched.push_back(std::move(solver));
      continue;
    }
    matching.pairs.emplace_back(std::move(solver), std::move(*partner));
    b.erase(partner);
  }
  a = std::move(unmatched);
}

/// Equal rows first, then equal but for the version, then equal but for version and instruction-set level.
Matching match_solvers(std::vector<StoredSolver> a, std::vector<StoredSolver> b, bool by_name) {
  Matching matching;
  const auto same_name = [by_name](const SolverRow& x, const SolverRow& y) {
    return !by_name || (x.name == y.name && x.settings == y.settings && x.sweep == y.sweep);
  };
  const auto same_level = [&](const SolverRow& x, const SolverRow& y) { return same_name(x, y) && x.isa == y.isa; };
  const auto same_row = [&](const SolverRow& x, const SolverRow& y) {
    return same_level(x, y) && x.version == y.version && x.library == y.library;
  };
  take_pairs(a, b, same_row, matching);
  take_pairs(a, b, same_level, matching);
  take_pairs(a, b, same_name, matching);
  matching.only_in_a = std::move(a);
  matching.only_in_b = std::move(b);
  return matching;
}

/// The parameterisation of `solver` with these settings.
std::optional<std::size_t> find_cell(const StoredSolver& solver, const std::string& settings) {
  for (std::size_t cell = 0; cell < solver.cells.size(); ++cell) {
    if (solver.cells[cell].settings == settings) return cell;
  }
  return std::nullopt;
}

void compare_solver(const std::string& set, const SolverPair& solvers, const Entries& a, const Entries& b,
                    StoreComparison& comparison) {
  const bool is_sweep = !solvers.first.row.sweep.empty();
  for (const auto& [cell, entries] : a) {
    const auto number = static_cast<std::size_t>(cell);
    const auto partner =
        is_sweep ? find_cell(solvers.second, solvers.first.cells.at(number).settings) : std::optional<std::size_t>(0);
    const auto others = partner ? b.find(static_cast<std::int64_t>(*partner)) : b.end();
    if (others == b.end()) {
      comparison.missing.push_back(set + ": " + solver_text(solvers.first.cell(number)));
      continue;
    }
    CellChange change;
    change.set = set;
    change.a = solvers.first.cell(number);
    change.b = solvers.second.cell(*partner);
    compare_entries(entries, others->second, !is_sweep, change);
    comparison.cells.push_back(std::move(change));
  }
}

bool is_wanted(const std::string& set, const std::vector<std::string>& patterns) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                         [&set](const std::string& pattern) { return glob_matches(pattern, set); });
}

SetIds wanted_sets(Store& store, const std::vector<std::string>& patterns) {
  SetIds sets(natural_less);
  for (const auto& [id, name] : store.sets()) {
    if (is_wanted(name, patterns)) sets.emplace(name, id);
  }
  return sets;
}

/// A pattern that names no set of either store is a slip, not an empty comparison.
void check_patterns(Store& a, Store& b, const std::vector<std::string>& patterns) {
  for (const std::string& pattern : patterns) {
    if (!wanted_sets(a, {pattern}).empty() || !wanted_sets(b, {pattern}).empty()) continue;
    throw InputError(fmt::format("--set '{}': no such set in {} or {}", pattern, a.file().string(), b.file().string()));
  }
}

/// Names the solvers that have no partner and answers to this set.
void list_unmatched(const std::string& set, const Answers& answers, const std::vector<StoredSolver>& solvers,
                    std::vector<std::string>& list) {
  for (const StoredSolver& solver : solvers) {
    if (answers.contains(solver.id)) list.push_back(set + ": " + solver_text(solver.row));
  }
}

/// Holm's correction over the cells that `belongs` picks.
template <class Belongs>
void correct(std::vector<CellChange>& cells, Belongs belongs, double CellChange::*p, double CellChange::*corrected) {
  std::vector<CellChange*> family;
  std::vector<double> p_values;
  for (CellChange& cell : cells) {
    if (!belongs(cell)) continue;
    family.push_back(&cell);
    p_values.push_back(cell.*p);
  }
  const std::vector<double> adjusted = holm(p_values);
  for (std::size_t i = 0; i < family.size(); ++i) family[i]->*corrected = adjusted[i];
}

void correct_all(std::vector<CellChange>& cells) {
  for (const bool swept : {false, true}) {
    const auto belongs = [swept](const CellChange& cell) { return cell.a.sweep.empty() != swept; };
    correct(cells, belongs, &CellChange::solved_p, &CellChange::solved_p_holm);
    correct(cells, belongs, &CellChange::false_p, &CellChange::false_p_holm);
  }
}

}  // namespace

const char* to_string(Tendency tendency) {
  switch (tendency) {
    case Tendency::kTie: return "tie";
    case Tendency::kBetter: return "better";
    case Tendency::kWorse: return "worse";
    case Tendency::kUnknown: return "unknown";
  }
  return "unknown";
}

Tendency CellChange::solved() const {
  if (!(solved_p_holm < kSignificance)) return Tendency::kTie;
  return gained > lost ? Tendency::kBetter : Tendency::kWorse;
}

Tendency CellChange::false_claims() const {
  if (!(false_p_holm < kSignificance)) return Tendency::kTie;
  return false_gone > false_new ? Tendency::kBetter : Tendency::kWorse;
}

Tendency CellChange::time() const {
  if (std::isnan(time_ratio.low) || std::isnan(time_ratio.high)) return Tendency::kUnknown;
  if (is_tie_in_time(time_ratio)) return Tendency::kTie;
  return time_ratio.value < 1 ? Tendency::kBetter : Tendency::kWorse;
}

bool CellChange::regressed() const { return solved() == Tendency::kWorse || false_new > 0; }

std::string solver_text(const SolverRow& row) {
  return row.sweep.empty() ? row.text() : row.text() + " (sweep " + row.sweep + ")";
}

std::int64_t StoreComparison::sum(std::int64_t CellChange::*count) const {
  std::int64_t total = 0;
  for (const CellChange& cell : cells) total += cell.*count;
  return total;
}

bool StoreComparison::regressed() const {
  return std::any_of(cells.begin(), cells.end(), [](const CellChange& cell) { return cell.regressed(); });
}

bool StoreComparison::slower() const {
  return std::any_of(cells.begin(), cells.end(),
                     [](const CellChange& cell) { return cell.time() == Tendency::kWorse; });
}

StoreComparison compare_stores(Store& a, Store& b, const CompareOptions& options) {
  check_patterns(a, b, options.sets);
  const std::string& wanted_b = options.solver_b.empty() ? options.solver_a : options.solver_b;
  const bool by_name = options.solver_a.empty() || options.solver_a == wanted_b;
  const Matching matching = match_solvers(chosen_solvers(a, options.solver_a), chosen_solvers(b, wanted_b), by_name);
  const SetIds sets_a = wanted_sets(a, options.sets);
  const SetIds sets_b = wanted_sets(b, options.sets);
  StoreComparison comparison;
  std::vector<std::string> missing_solvers;
  std::vector<std::string> added_solvers;
  SetIds sets = sets_a;
  sets.insert(sets_b.begin(), sets_b.end());
  for (const auto& [set, id] : sets) {
    const Answers left = answers_to(a, sets_a, set);
    const Answers right = answers_to(b, sets_b, set);
    for (const SolverPair& solvers : matching.pairs) {
      if (!sets_a.contains(set)) break;
      const auto of_a = left.find(solvers.first.id);
      const auto of_b = right.find(solvers.second.id);
      if (of_a != left.end()) {
        compare_solver(set, solvers, of_a->second, of_b != right.end() ? of_b->second : Entries(), comparison);
      } else if (of_b != right.end()) {
        comparison.added.push_back(set + ": " + solver_text(solvers.second.row));
      }
    }
    list_unmatched(set, left, matching.only_in_a, missing_solvers);
    list_unmatched(set, right, matching.only_in_b, added_solvers);
  }
  comparison.missing.insert(comparison.missing.end(), missing_solvers.begin(), missing_solvers.end());
  comparison.added.insert(comparison.added.end(), added_solvers.begin(), added_solvers.end());
  if (comparison.sum(&CellChange::problems) == 0) {
    throw InputError(
        fmt::format("{} and {}: no solver met the same problem in both", a.file().string(), b.file().string()));
  }
  correct_all(comparison.cells);
  return comparison;
}

}  // namespace lcpbench
