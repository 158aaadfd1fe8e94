#include "study/inspect/inspection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/selection.h"
#include "study/inspect/spectra.h"
#include "study/output/explanation.h"
#include "study/output/text_table.h"

// Every threshold is a ratio, says what physical quantity it is, or is near an end of the range of double.

namespace lcpbench {
namespace {

constexpr double kFarFromSymmetric = 1e-6;     // closer than this, asymmetry is lost digits, not another matrix
constexpr double kNearlySemidefinite = 1e-10;  // an eigenvalue so far below zero, relative to the largest, is rounding
constexpr double kWideSpread = 1e8;            // no absolute tolerance suits both ends
constexpr double kFastestImpact = 100;         // [m/s] a fall of 500 m: rather mm/s
constexpr double kCriterionVelocity = 1e-3;    // [m/s] the paper's tolerance
constexpr double kSmallestSafe = 1e-290;       // products of such a number with a small one may underflow
constexpr double kLargestSafe = 1e290;         // and of such a number with a large one overflow

Vector approach_velocities(const ContactProblem& problem) {
  Vector velocities(problem.nc());
  for (Index i = 0; i < problem.nc(); ++i) velocities(i) = dot_column(problem.N, i, problem.v) + problem.offset(i);
  return velocities;
}

double asymmetry(const Matrix& M) {
  const double largest = M.size() > 0 ? M.cwiseAbs().maxCoeff() : 0;
  return largest > 0 ? (M / largest - M.transpose() / largest).cwiseAbs().maxCoeff() : 0;
}

Index impossible_rows(const Matrix& M, const Vector& q) {
  Index count = 0;
  for (Index i = 0; i < q.size(); ++i) count += q(i) < 0 && M.row(i).maxCoeff() <= 0 ? 1 : 0;
  return count;
}

void warn_of_bare_matrix(const Lcp& lcp, const Spectrum& spectrum, double skew, Inspection& inspection) {
  const Vector diagonal = lcp.M.diagonal();
  const Index negative = (diagonal.array() < 0).count();
  const Index impossible = impossible_rows(lcp.M, lcp.q);
  const bool negated = spectrum.rank > 0 && spectrum.largest <= spectrum.rounding;
  inspection.data(negated, "negative_semidefinite", spectrum.largest,
                  fmt::format("-M is positive semidefinite (the largest eigenvalue of the symmetric part of M is "
                              "{:.3g}): M has the wrong sign?",
                              spectrum.largest));
  inspection.data(!negated && negative > 0, "negative_diagonal", diagonal.size() > 0 ? diagonal.minCoeff() : 0,
                  fmt::format("negative diagonal entries of M: {}, which no contact problem has: a slip in the sign?",
                              negative));
  inspection.data(impossible > 0 && skew > 0 && impossible_rows(lcp.M.transpose(), lcp.q) == 0, "transposed",
                  static_cast<double>(impossible),
                  "a row is impossible to satisfy, and M transposed has no such row: M was stored by columns and read "
                  "by rows?");
  inspection.data(impossible > 0, "impossible_rows", static_cast<double>(impossible),
                  fmt::format("rows without a positive entry but with q_i < 0: {}. No z >= 0 makes w_i >= 0, so there "
                              "is no solution",
                              impossible));
  inspection.data(skew > 0 && skew <= kFarFromSymmetric, "nearly_symmetric", skew,
                  fmt::format("M differs from its transpose by {:.3g} of its largest entry: symmetric but for lost "
                              "digits, and solvers for symmetric M may refuse it or read one half of it",
                              skew));
}

/// Rows and columns of a contact problem mix units: of one only the diagonal is looked at.
void warn_of_scaling(const Matrix& M, bool contact, double condition, Inspection& inspection) {
  Range entries;
  for (Index i = 0; i < M.size(); ++i) entries.add(std::abs(M.data()[i]));
  Range rows;
  Range columns;
  Range diagonal;
  for (Index i = 0; i < M.rows(); ++i) {
    rows.add(M.row(i).cwiseAbs().maxCoeff());
    columns.add(M.col(i).cwiseAbs().maxCoeff());
    diagonal.add(std::abs(M(i, i)));
  }
  inspection.facts["matrix"]["diagonal"] = range_json(diagonal);
  if (!contact) inspection.facts["matrix"]["rows"] = range_json(rows);
  if (!contact) inspection.facts["matrix"]["columns"] = range_json(columns);
  const double widest = contact ? diagonal.spread() : std::max({rows.spread(), columns.spread(), diagonal.spread()});
  inspection.difficulty(widest > kWideSpread, "scaling_spread", widest,
                        fmt::format("rows, columns or diagonal entries of M spread over a factor of {:.3g}: no "
                                    "absolute tolerance suits all of them",
                                    widest));
  if (!M.allFinite()) entries.add(std::numeric_limits<double>::infinity());  // where an infinity met a zero, NaN stands
  const double extreme = entries.low < kSmallestSafe ? entries.low : entries.high;
  inspection.difficulty(extreme < kSmallestSafe || extreme > kLargestSafe, "extreme_magnitude", extreme,
                        fmt::format("M has an entry of {:.3g}: products underflow or overflow", extreme));
  inspection.difficulty(condition > kIllConditioned, "ill_conditioned_matrix", condition,
                        fmt::format("the nonzero eigenvalues of M with unit diagonal spread over a factor of {:.3g}: "
                                    "an answer in double may have {:.0f} of its 16 digits wrong",
                                    condition, std::min(16.0, std::log10(condition))));
}

/// (q, M) as a solver on matrices is given it.
void inspect_matrix(const Lcp& lcp, const std::vector<Index>& independent, bool contact, Inspection& inspection) {
  const Matrix& M = lcp.M;
  const Matrix rows = M(independent, independent);
  const Matrix symmetric = rows / 2 + rows.transpose() / 2;
  const Spectrum spectrum = spectrum_of(symmetric);
  const double skew = asymmetry(M);
  Json& facts = inspection.facts["matrix"];
  facts = {{"asymmetry", json_number(skew)},
           {"spectrum", spectrum_json(spectrum)},
           {"rank", rank_json(M, M, 0x1p-50 * static_cast<double>(M.rows()))}};
  if (!contact) {
    const auto [blocks, largest] = island_sizes(row_islands(M), M.rows());
    facts["condition"] = json_number(nonzero_condition(spectrum_of(unit_diagonal(QuadMatrix(symmetric)), 0)));
    facts["blocks"] = blocks;
    facts["largest_block"] = largest;
    warn_of_bare_matrix(lcp, spectrum, skew, inspection);
  }
  const double below = spectrum.smallest / spectrum.largest;
  inspection.difficulty(
      spectrum.has_negative() && spectrum.largest > 0 && (contact || below >= -kNearlySemidefinite),
      "rounded_indefinite", spectrum.smallest,
      fmt::format("M in double is not positive semidefinite, and that is rounding: its smallest eigenvalue is {:.3g} "
                  "(+- {:.1g}), the largest {:.3g}; exact methods may end on a ray",
                  spectrum.smallest, spectrum.rounding, spectrum.largest));
  const Json& condition = (contact ? inspection.facts["contact"] : facts)["condition"];
  warn_of_scaling(M, contact, condition.is_null() ? 0 : condition.get<double>(), inspection);
}

/// Of a bare LCP q; of a contact problem the speeds at which contacts approach (< 0).
void inspect_velocities(const Vector& q, bool contact, Inspection& inspection) {
  const Index negative = (q.array() < 0).count();
  const Index zero = (q.array() == 0).count();
  const double least = q.size() > 0 ? q.minCoeff() : 0;
  const double speed = q.size() > 0 ? q.cwiseAbs().maxCoeff() : 0;
  const Index ties = least < 0 ? (q.array() == least).count() : 0;
  inspection.facts["velocity"] = {{"negative", negative},
                                  {"zero", zero},
                                  {"positive", q.size() - negative - zero},
                                  {"least", json_number(least)},
                                  {"largest_magnitude", json_number(speed)}};
  inspection.data(negative == 0 && q.size() > 0, "trivial", least,
                  contact ? fmt::format("no contact approaches (least N'v + b {:.3g} m/s): nothing happens; if that is "
                                        "not meant, v or N has the wrong sign",
                                        least)
                          : fmt::format("q >= 0 (least entry {:.3g}): z = 0 solves it whatever M is; if that is not "
                                        "meant, q has the wrong sign",
                                        least));
  inspection.data(contact && speed > kFastestImpact, "fast_impact", speed,
                  fmt::format("a contact moves at {:.3g} m/s: are lengths in millimetres?", speed));
  inspection.difficulty(contact && negative > 0 && speed < kCriterionVelocity, "slow_impact", speed,
                        fmt::format("no contact moves faster than {:.3g} m/s: absolute tolerances near 1e-3 m/s accept "
                                    "any answer",
                                    speed));
  inspection.difficulty(zero > 0 && negative > 0, "zero_q", static_cast<double>(zero),
                        fmt::format("entries of q (N'v + b) that are exactly 0: {}. They tie in the ratio tests of "
                                    "pivoting methods",
                                    zero));
  inspection.difficulty(ties > 1, "tied_q", static_cast<double>(ties),
                        fmt::format("{} entries of q (N'v + b) share the least value, {:.3g}: the first ratio test of "
                                    "Lemke's method ties",
                                    ties, least));
}

std::string value_text(const Json& value) {
  if (value.is_null()) return "not computed";
  if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array()) return fmt::to_string(value.size());
  if (!value.is_object()) return value.dump();
  std::string text;
  for (const auto& [key, part] : value.items()) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", key, value_text(part));
  }
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace

void Inspection::data(bool holds, const char* code, double value, std::string text) {
  if (holds) warnings.push_back({code, "data", value, std::move(text)});
}

void Inspection::difficulty(bool holds, const char* code, double value, std::string text) {
  if (holds) warnings.push_back({code, "difficulty", value, std::move(text)});
}

std::pair<Index, Index> island_sizes(const RowIslands& islands, Index rows) {
  std::vector<Index> sizes(static_cast<std::size_t>(islands.count), 0);
  for (Index row = 0; row < rows; ++row) {
    ++sizes[static_cast<std::size_t>(islands.of_row[static_cast<std::size_t>(row)])];
  }
  return {islands.count, sizes.empty() ? 0 : *std::max_element(sizes.begin(), sizes.end())};
}

namespace {

/// Whether a warning holds for z >= 0 alone, and not on other bounds.
bool asks_for_nonnegative(const Warning& warning) {
  constexpr std::array kCodes{"negative_semidefinite", "negative_diagonal", "transposed", "impossible_rows",
                              "trivial",               "zero_q",            "tied_q"};
  return std::find(kCodes.begin(), kCodes.end(), std::string_view(warning.code)) != kCodes.end();
}

}  // namespace

Inspection inspect(const Problem& problem) {
  Inspection inspection;
  const ContactProblem* contact = problem.contact();
  const bool dense = problem.size() <= kLargestDense && (contact == nullptr || contact->ngc() <= kLargestDense);
  inspection.facts = {{"problem", problem_summary_json(problem, "")},
                      {"contact", nullptr},
                      {"matrix", nullptr},
                      {"velocity", nullptr}};
  if (contact != nullptr) {
    inspect_contact(*contact, problem.scene(), inspection);
    if (dense) inspect_matrix(problem.lcp(), independent_rows(*contact), true, inspection);
    inspect_velocities(approach_velocities(*contact), true, inspection);
    if (contact->has_rows()) {  // which may ask for impulses where no contact does
      std::erase_if(inspection.warnings, [](const Warning& warning) { return warning.code == "trivial"; });
    }
  } else {
    if (dense) inspect_matrix(problem.lcp(), all_indices(problem.size()), false, inspection);
    inspect_velocities(problem.lcp().q, false, inspection);
    const Index dropped = problem.lcp().dropped_bounds;
    inspection.data(dropped > 0, "huge_bounds", static_cast<double>(dropped),
                    fmt::format("bounds of {:g} and more: {}. They are taken as none", LcpBounds::kNoBound, dropped));
    if (problem.lcp().is_mixed()) std::erase_if(inspection.warnings, asks_for_nonnegative);
  }
  std::stable_partition(inspection.warnings.begin(), inspection.warnings.end(),
                        [](const Warning& warning) { return warning.concern == "data"; });
  return inspection;
}

Json inspection_json(const Inspection& inspection) {
  Json json = inspection.facts;
  json["warnings"] = Json::array();
  for (const Warning& warning : inspection.warnings) {
    json["warnings"].push_back({{"code", warning.code},
                                {"concern", warning.concern},
                                {"value", json_number(warning.value)},
                                {"message", warning.text}});
  }
  return json;
}

std::string inspection_text(const Inspection& inspection, int width) {
  TextTable table({{"", TextTable::Align::kLeft, 0, 20}, {"", TextTable::Align::kLeft}});
  const bool bare = inspection.facts["contact"].is_null();
  for (const auto& [section, facts] : inspection.facts.items()) {
    if (facts.is_null()) continue;
    const std::string heading = section == "velocity" && bare ? "q" : section;
    if (!table.empty()) table.add_line("");
    for (const auto& [key, value] : facts.items()) {
      std::string label = section == "problem" ? key : heading + ": " + key;
      std::replace(label.begin(), label.end(), '_', ' ');
      if (key != "edges" && !(key == "name" && value.get<std::string>().empty())) {
        table.add_row({label, value_text(value)});
      }
    }
  }
  std::string text = table.text(width);
  if (inspection.warnings.empty()) text += "nothing to warn of\n";
  std::string concern;
  for (const Warning& warning : inspection.warnings) {
    if (concern != warning.concern) {
      text += warning.concern == "data" ? "is this what was meant?\n" : "hard on solvers:\n";
    }
    concern = warning.concern;
    text += folded(fmt::format("  {} [{}]\n", warning.text, warning.code), width);
  }
  return text;
}

}  // namespace lcpbench
