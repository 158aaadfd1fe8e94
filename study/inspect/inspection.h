#pragma once

#include <string>
#include <vector>

#include "core/islands.h"
#include "core/problem.h"
#include "study/output/json_output.h"

namespace lcpbench {

/// Above this order nothing is computed with dense matrices: no spectra, no ranks.
inline constexpr Index kLargestDense = 600;

struct Warning {
  std::string code;      ///< stable, for programs: docs/reference/inspect.md lists them all
  std::string concern;   ///< "data": probably not what was meant; "difficulty": hard on solvers
  double value = 0;      ///< the number behind it
  std::string text;      ///< one plain sentence
};

/// What is found out about a problem: sections "problem", "contact", "matrix" and "velocity", each null where there is
/// nothing to say, and warnings.
struct Inspection {
  Json facts;
  std::vector<Warning> warnings;

  /// Each adds a warning if it holds.
  void data(bool holds, const char* code, double value, std::string text);
  void difficulty(bool holds, const char* code, double value, std::string text);
};

/// Looks at a problem; solves nothing. A function of the data alone. O(n^3), up to a few seconds at kLargestDense.
/// @pre the problem's data are finite and passed the reader's checks.
Inspection inspect(const Problem& problem);

Json inspection_json(const Inspection& inspection);
/// @param width  of the terminal
std::string inspection_text(const Inspection& inspection, int width);

/// The section "contact" and its warnings.
void inspect_contact(const ContactProblem& problem, const RigidScene* scene, Inspection& inspection);
/// The number of islands and the rows of the largest, among the first `rows` rows.
std::pair<Index, Index> island_sizes(const RowIslands& islands, Index rows);
/// Rows of M without the friction cones' rows, and one of each pair of opposite friction columns.
std::vector<Index> independent_rows(const ContactProblem& problem);

/// Largest / smallest nonzero eigenvalue of [N D]'G*[N D] with unit diagonal, formed in 113 bits; one of each pair of
/// opposite columns. NaN where it is not known, or the problem is larger than kLargestDense.
double response_condition(const ContactProblem& problem);

}  // namespace lcpbench
