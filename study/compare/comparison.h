#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/store/store.h"

namespace lcpbench {

struct CompareOptions {
  std::vector<std::string> sets;  ///< globs over set names; empty: all
  std::string solver_a;           ///< compare only this solver of A, "name{settings}"; "": all
  std::string solver_b;           ///< with this one of B; "": the same as in A
};

/// Compares two stores, or one with itself for two of its solvers: the document of `compare --format json` without its
/// members `a` and `b` at the top. Cells belong together by set, solver name, settings and sweep; also across versions
/// and instruction-set levels, where a level in both stores goes with itself. Holm's correction runs three times,
/// apart: over the cells of single solvers, over their sums of all sets, and over the parameterisations of sweeps.
/// Times of sweeps get no interval. Refused problems count as not solved. Verdicts are those of each store. `gravity`
/// of a cell orders them: 0 for a new false claim, 1 for fewer solved, 2 for slower, 3 for what got better, 4 for a
/// tie. Memory: the answers of both stores to one set.
/// @throws InputError when a store cannot be read, a solver is not in its store, a pattern names no set, or nothing can
/// be compared.
nlohmann::ordered_json compare_stores(Store& a, Store& b, const CompareOptions& options);

/// For people: the most serious changes, then the conclusion about B. With three lines above it for the names of the
/// stores it has at most kAnswerLines lines, unless the conclusion alone takes more.
/// @param comparison  of compare_stores() @param width  characters of a line, or kUnlimited
/// @param all  instead every single solver, and of a sweep the cells that changed; of any length
std::string comparison_text(const nlohmann::ordered_json& comparison, int width, bool all);

}  // namespace lcpbench
