#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/statistics/statistics.h"
#include "study/store/store.h"

namespace lcpbench {

/// The change of a quantity from A to B.
enum class Tendency { kTie, kBetter, kWorse, kUnknown };
const char* to_string(Tendency tendency);

/// "lemke{engine=kernel}", "lemke (sweep paper)".
std::string solver_text(const SolverRow& row);

/// One solver parameterisation on one set in two stores, on the problems that it met in both with the same data.
struct CellChange {
  std::string set;
  SolverRow a;  ///< with the parameterisation's own settings
  SolverRow b;
  std::int64_t problems = 0;
  std::int64_t other_data = 0;  ///< same set, seed and trial but other data: left out
  std::int64_t only_in_a = 0;   ///< problems that B did not meet: left out
  std::int64_t only_in_b = 0;

  std::int64_t solved_a = 0;
  std::int64_t solved_b = 0;
  std::int64_t lost = 0;    ///< solved in A only
  std::int64_t gained = 0;  ///< solved in B only
  double solved_p = 1;      ///< exact McNemar
  double solved_p_holm = 1;

  std::int64_t false_a = 0;
  std::int64_t false_b = 0;
  std::int64_t false_gone = 0;  ///< false claims in A only
  std::int64_t false_new = 0;   ///< in B only
  double false_p = 1;
  double false_p_holm = 1;

  std::int64_t timed = 0;     ///< problems that both solved and timed
  Estimate time_ratio{};      ///< B's summed time over A's on these; NaN ends where there is none
  double median_ratio = 0;    ///< B's median time over A's on the same
  std::int64_t counted = 0;   ///< problems on which both count pivots
  std::int64_t pivots_a = 0;  ///< sums over these
  std::int64_t pivots_b = 0;

  /// By the corrected test at 5 %.
  Tendency solved() const;
  Tendency false_claims() const;
  /// A tie where the ratio is within 5 % of 1 or its interval contains 1; unknown without an interval.
  Tendency time() const;
  /// It solves significantly fewer problems, or makes any false claim that it did not make.
  bool regressed() const;
};

struct CompareOptions {
  std::vector<std::string> sets;  ///< globs over set names; empty: all
  std::string solver_a;           ///< compare only this solver of A, "name{settings}"; "": all
  std::string solver_b;           ///< with this one of B; "": the same as in A
};

/// Two stores side by side.
struct StoreComparison {
  std::vector<CellChange> cells;     ///< by set, then solver
  std::vector<std::string> missing;  ///< "set: solver" that only A has
  std::vector<std::string> added;    ///< that only B has

  /// A count over all cells.
  std::int64_t sum(std::int64_t CellChange::*count) const;
  bool regressed() const;
  bool slower() const;
};

/// Compares two stores, or one with itself for two of its solvers. Cells belong together by set, solver name, settings,
/// sweep and cell; also across versions and instruction-set levels, where a level in both stores goes with itself.
/// Corrections run over all cells of the comparison, parameterisations of sweeps apart from single solvers. Times of
/// sweeps get no interval. Refused problems count as not solved. Verdicts are those of each store.
/// @throws InputError when a store cannot be read, a solver is not in its store, or nothing can be compared.
StoreComparison compare_stores(Store& a, Store& b, const CompareOptions& options);

/// All of it; NaN is null.
nlohmann::ordered_json comparison_document(const StoreComparison& comparison);

/// For people: the most serious changes, then the conclusion about B. At most kAnswerLines, the names of the stores
/// included.
std::string comparison_answer(const StoreComparison& comparison, int width);

/// A table for people: every single solver; of a sweep the cells that changed, and how many did not.
std::string comparison_text(const StoreComparison& comparison, int width);

}  // namespace lcpbench
