#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "study/inspect/inspection.h"

// Every threshold is a ratio, or says what physical quantity it is.

namespace lcpbench {
namespace {

constexpr double kFarFromSymmetric = 1e-6;     // closer than this, asymmetry is lost digits, not another matrix
constexpr double kNearlySemidefinite = 1e-10;  // an eigenvalue so far below zero, relative to the largest, is rounding
constexpr double kIllConditioned = 1e8;        // half of the digits of a double
constexpr double kWideSpread = 1e8;            // no absolute tolerance suits both ends
constexpr double kMassRatio = 1e6;
constexpr double kHugeFriction = 10;         // rubber on rock is below 5
constexpr double kFastestImpact = 100;       // [m/s] a fall of 500 m: rather mm/s
constexpr double kCriterionVelocity = 1e-3;  // [m/s] the paper's tolerance
constexpr double kSmallestSafe = 1e-290;     // products of two such numbers with moderate ones underflow
constexpr double kLargestSafe = 1e290;

class Collector {
 public:
  void data(bool fires, const char* code, double value, std::string text) {
    add(fires, code, Concern::kData, value, std::move(text));
  }
  void difficulty(bool fires, const char* code, double value, std::string text) {
    add(fires, code, Concern::kDifficulty, value, std::move(text));
  }
  std::vector<Warning> sorted() && {
    std::stable_partition(warnings_.begin(), warnings_.end(),
                          [](const Warning& warning) { return warning.concern == Concern::kData; });
    return std::move(warnings_);
  }

 private:
  void add(bool fires, const char* code, Concern concern, double value, std::string text) {
    if (fires) warnings_.push_back({code, concern, value, std::move(text)});
  }

  std::vector<Warning> warnings_;
};

/// "1 row of M is", "3 rows of M are".
std::string are(Index count, const char* one, const char* more) {
  return count == 1 ? fmt::format("1 {} is", one) : fmt::format("{} {} are", count, more);
}

/// "1-4, 2-3 and 5 more pairs".
std::string pairs_text(const std::vector<ContactPair>& pairs) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, pairs.size()); ++i) {
    text += fmt::format("{}{} and {}", i == 0 ? "" : ", ", pairs[i].first, pairs[i].second);
  }
  return pairs.size() <= kShown ? text : text + fmt::format(" and {} more pairs", pairs.size() - kShown);
}

bool trivial(const Inspection& inspection) {
  return inspection.velocity.negative == 0 && inspection.velocity.zero + inspection.velocity.positive > 0;
}

void warn_of_bare_signs(const Inspection& inspection, Collector& warnings) {
  const MatrixFacts& matrix = inspection.matrix;
  const Spectrum& spectrum = matrix.symmetric;
  const bool negated = spectrum.rank > 0 && spectrum.largest <= spectrum.rounding;
  warnings.data(
      negated, "negative_semidefinite", spectrum.largest,
      fmt::format("-M is positive semidefinite (the largest eigenvalue of the symmetric part of M is {:.3g}): "
                  "M has the wrong sign?",
                  spectrum.largest));
  warnings.data(!negated && matrix.negative_diagonal > 0, "negative_diagonal", matrix.least_diagonal,
                fmt::format("{} negative (least {:.3g}), which no contact problem has: a slip in the sign?",
                            are(matrix.negative_diagonal, "diagonal entry of M", "diagonal entries of M"),
                            matrix.least_diagonal));
  warnings.data(trivial(inspection), "trivial", inspection.velocity.least,
                fmt::format("q >= 0 (least entry {:.3g}): z = 0 solves it whatever M is; if that is not meant, q has "
                            "the wrong sign",
                            inspection.velocity.least));
}

void warn_of_layout(const MatrixFacts& matrix, Collector& warnings) {
  const bool cones = matrix.cone_rows_transposed > 0 && matrix.cone_rows == 0;
  const bool rows = matrix.impossible_rows > 0 && matrix.impossible_rows_transposed == 0 && matrix.asymmetry > 0;
  warnings.data(cones, "transposed", static_cast<double>(matrix.cone_rows_transposed),
                fmt::format("{} transposed (+1 along the row, -1 down the column): M was stored by columns and read by "
                            "rows?",
                            are(matrix.cone_rows_transposed, "row of a friction cone", "rows of friction cones")));
  warnings.data(!cones && rows, "transposed", static_cast<double>(matrix.impossible_rows),
                fmt::format("{} impossible to satisfy, and M transposed has no such row: M was stored by columns and "
                            "read by rows?",
                            are(matrix.impossible_rows, "row", "rows")));
  warnings.data(matrix.impossible_rows > 0, "impossible_rows", static_cast<double>(matrix.impossible_rows),
                fmt::format("{} without a positive entry but q_i < 0: no z >= 0 makes w_i >= 0, so there is no "
                            "solution{}",
                            are(matrix.impossible_rows, "row", "rows"),
                            matrix.impossible_rows_negated == 0 ? "; -M has none such: a slip in the sign?" : ""));
  warnings.data(matrix.asymmetry > 0 && matrix.asymmetry <= kFarFromSymmetric, "nearly_symmetric", matrix.asymmetry,
                fmt::format("M differs from its transpose by {:.3g} of its largest entry: symmetric but for lost "
                            "digits, and solvers for symmetric M may refuse it or read one half of it",
                            matrix.asymmetry));
}

void warn_of_bare_difficulties(const Inspection& inspection, Collector& warnings) {
  const MatrixFacts& matrix = inspection.matrix;
  const Spectrum& spectrum = matrix.symmetric;
  const double relative = spectrum.smallest / spectrum.largest;
  warnings.difficulty(
      spectrum.has_negative() && spectrum.largest > 0 && relative >= -kNearlySemidefinite, "rounded_indefinite",
      spectrum.smallest,
      fmt::format("M is positive semidefinite but for rounding: the smallest eigenvalue of its symmetric "
                  "part is {:.3g} (+- {:.1g}), the largest {:.3g}",
                  spectrum.smallest, spectrum.rounding, spectrum.largest));
  if (matrix.not_copositive_at && matrix.negative_diagonal == 0) {
    const auto [i, j] = *matrix.not_copositive_at;
    warnings.difficulty(true, "not_copositive", static_cast<double>(i),
                        fmt::format("M is not copositive (rows {} and {}): Lemke's method may end on a ray though a "
                                    "solution exists",
                                    j, i));
  }
  warnings.difficulty(matrix.zero_rows > 0, "zero_rows", static_cast<double>(matrix.zero_rows),
                      fmt::format("{} zero: w_i = q_i whatever z is", are(matrix.zero_rows, "row of M", "rows of M")));
}

/// Rows and columns of a contact problem mix units: of one only the diagonal is looked at.
void warn_of_scaling(const Inspection& inspection, Collector& warnings) {
  const MatrixFacts& matrix = inspection.matrix;
  const auto spread = [](const Range& range) { return std::isnan(range.low) ? 1.0 : range.spread(); };
  const double rows = inspection.contact ? 1.0 : spread(matrix.row_sizes);
  const double columns = inspection.contact ? 1.0 : spread(matrix.column_sizes);
  const double diagonal = spread(matrix.diagonal);
  const double widest = std::max({rows, columns, diagonal});
  warnings.difficulty(widest > kWideSpread, "scaling_spread", widest,
                      fmt::format("the {} of M spread over a factor of {:.3g}: no absolute tolerance suits all of them",
                                  widest == diagonal ? "diagonal entries"
                                  : widest == rows   ? "rows"
                                                     : "columns",
                                  widest));
  const bool tiny = matrix.entries.low < kSmallestSafe;
  warnings.difficulty(tiny || matrix.entries.high > kLargestSafe, "extreme_magnitude",
                      tiny ? matrix.entries.low : matrix.entries.high,
                      fmt::format("M has an entry of {:.3g}: products underflow or overflow",
                                  tiny ? matrix.entries.low : matrix.entries.high));
  const double condition = inspection.contact ? inspection.contact->condition : matrix.condition;
  warnings.difficulty(condition > kIllConditioned, "ill_conditioned_matrix", condition,
                      fmt::format("the nonzero eigenvalues of M with unit diagonal spread over a factor of {:.3g}: an "
                                  "answer in double may have {:.0f} of its 16 digits wrong",
                                  condition, std::min(16.0, std::log10(condition))));
}

void warn_of_degeneracy(const Inspection& inspection, Collector& warnings) {
  const VelocityFacts& velocity = inspection.velocity;
  const char* row = inspection.contact ? "contact" : "row";
  const char* symbol = inspection.contact ? "N'v" : "q";
  warnings.difficulty(velocity.zero > 0 && velocity.negative > 0, "zero_q", static_cast<double>(velocity.zero),
                      fmt::format("{} of {} {}s have {} = 0 exactly: ties in the ratio tests of pivoting methods",
                                  velocity.zero, velocity.negative + velocity.zero + velocity.positive, row, symbol));
  warnings.difficulty(velocity.ties > 0, "tied_q", static_cast<double>(velocity.ties),
                      fmt::format("{} {}s share the least {} of {:.3g}: the first ratio test of Lemke's method ties",
                                  velocity.ties, row, symbol, velocity.least));
}

void warn_of_velocities(const Inspection& inspection, Collector& warnings) {
  const VelocityFacts& velocity = inspection.velocity;
  warnings.data(
      trivial(inspection), "trivial", velocity.least,
      fmt::format("no contact approaches (least N'v {:.3g} m/s): nothing happens; if that is not meant, v or N "
                  "has the wrong sign",
                  velocity.least));
  const double speed = velocity.largest_magnitude;
  warnings.data(speed > kFastestImpact, "fast_impact", speed,
                fmt::format("a contact moves at {:.3g} m/s: are lengths in millimetres?", speed));
  warnings.difficulty(velocity.negative > 0 && speed < kCriterionVelocity, "slow_impact", speed,
                      fmt::format("no contact moves faster than {:.3g} m/s: absolute tolerances near 1e-3 m/s accept "
                                  "any answer",
                                  speed));
}

void warn_of_inertia(const ContactFacts& contact, Index ngc, Collector& warnings) {
  const bool inverse_given = contact.inertia == "G inverse only";
  warnings.data(
      2 * contact.bodies_as_inverse > contact.bodies_judged, "inertia_inverted",
      static_cast<double>(contact.bodies_as_inverse),
      fmt::format("{} of {} bodies have moments that fit the inverse of an inertia: {}", contact.bodies_as_inverse,
                  contact.bodies_judged, inverse_given ? "G was given as Ginv?" : "the inverse was given as G?"));
  warnings.data(
      contact.bodies > 0 && contact.bodies_too_long == contact.bodies, "length_units",
      static_cast<double>(contact.bodies_too_long),
      fmt::format("every body ({}) is lighter than a thousandth of the air in its place, or is touched at over 100 "
                  "radii of gyration: are lengths in millimetres?",
                  contact.bodies));
  if (contact.inertia_rank < 0) return;
  warnings.difficulty(contact.inertia_rank < ngc, "singular_inertia", static_cast<double>(contact.inertia_rank),
                      fmt::format("the inertia has rank {} of {}: impulses in its null space move nothing, so the "
                                  "problem may have no solution, and energy is not z'q + 1/2 z'Mz",
                                  contact.inertia_rank, ngc));
  warnings.difficulty(contact.scaled_condition > kIllConditioned, "ill_conditioned_inertia", contact.scaled_condition,
                      fmt::format("the condition of the inertia with unit diagonal is {:.3g}: M as formed in double "
                                  "keeps about {:.0f} of 16 digits of the lightest direction",
                                  contact.scaled_condition, std::max(0.0, 16 - std::log10(contact.scaled_condition))));
  warnings.difficulty(
      contact.masses.spread() > kMassRatio, "mass_ratio", contact.masses.spread(),
      fmt::format("masses spread from {:.3g} to {:.3g} kg: iterative methods converge slowly, and kg may "
                  "be mixed with g",
                  contact.masses.low, contact.masses.high));
}

void warn_of_redundancy(const ContactFacts& contact, Index nc, Collector& warnings) {
  const Index dependent = nc - contact.normals.exact;
  const Index hidden = contact.normals.exact - contact.normals.visible;
  warnings.difficulty(dependent > 0, "redundant_contacts", static_cast<double>(dependent),
                      fmt::format("{} of {} contacts depend on the others (rank of N is {}): impulses are not unique, "
                                  "and M is singular",
                                  dependent, nc, contact.normals.exact));
  warnings.difficulty(
      hidden > 0, "nearly_redundant_contacts", static_cast<double>(hidden),
      fmt::format("{} of {} contacts depend on the others but for a part below 1.5e-8, which M formed in "
                  "double cannot show (rank of N {} exactly, {} visibly)",
                  hidden, nc, contact.normals.exact, contact.normals.visible));
  warnings.difficulty(!contact.duplicates.empty(), "duplicate_contacts", static_cast<double>(contact.duplicates.size()),
                      fmt::format("contacts {} have the same direction exactly", pairs_text(contact.duplicates)));
  if (!contact.near_duplicates.empty()) {
    const auto nearest = std::min_element(contact.near_duplicates.begin(), contact.near_duplicates.end(),
                                          [](const auto& a, const auto& b) { return a.distance < b.distance; });
    warnings.difficulty(true, "near_duplicate_contacts", nearest->distance,
                        fmt::format("contacts {} have almost the same direction (nearest: {:.3g} apart)",
                                    pairs_text(contact.near_duplicates), nearest->distance));
  }
  warnings.difficulty(!contact.opposed.empty(), "opposed_contacts", static_cast<double>(contact.opposed.size()),
                      fmt::format("contacts {} push against each other: internal forces are free, and interior points "
                                  "have no centre",
                                  pairs_text(contact.opposed)));
}

void warn_of_columns(const ContactFacts& contact, Collector& warnings) {
  warnings.data(
      contact.normals_by_rows, "normals_by_rows", 1,
      "the rows of N are unit normals of rigid bodies and its columns are not: N was stored by rows and read by "
      "columns?");
  warnings.data(
      contact.zero_normals > 0, "zero_normals", static_cast<double>(contact.zero_normals),
      fmt::format("{} zero: such a contact pushes nothing", are(contact.zero_normals, "column of N", "columns of N")));
  warnings.difficulty(contact.immovable > 0, "immovable_contacts", static_cast<double>(contact.immovable),
                      fmt::format("{} in the null space of the inertia: no impulse there moves anything",
                                  are(contact.immovable, "column of N", "columns of N")));
}

void warn_of_friction(const ContactFacts& contact, Collector& warnings) {
  warnings.difficulty(contact.zero_mu > 0, "frictionless_edges", static_cast<double>(contact.zero_mu),
                      fmt::format("{} of {} contacts with friction edges have mu = 0: their rows only make the problem "
                                  "larger and degenerate",
                                  contact.zero_mu, contact.frictional_contacts));
  warnings.data(
      contact.largest_mu > kHugeFriction, "huge_friction", contact.largest_mu,
      fmt::format("the largest mu is {:.3g}: an angle in degrees, or meant as infinite?", contact.largest_mu));
  warnings.data(
      contact.zero_directions > 0, "zero_directions", static_cast<double>(contact.zero_directions),
      fmt::format("{} zero: friction there does nothing", are(contact.zero_directions, "column of D", "columns of D")));
  warnings.data(contact.directions_along_normal > 0, "directions_along_normal",
                static_cast<double>(contact.directions_along_normal),
                fmt::format("{} parallel to the normal of the contact",
                            are(contact.directions_along_normal, "column of D", "columns of D")));
}

void warn_of_rounded_matrix(const Inspection& inspection, Collector& warnings) {
  const Spectrum& rounded = inspection.matrix.symmetric;
  const bool exact_is_semidefinite = inspection.contact->truth.known();
  warnings.difficulty(
      exact_is_semidefinite && rounded.has_negative(), "rounded_indefinite", rounded.smallest,
      fmt::format("M as formed in double is not positive semidefinite, though the data's own is: smallest "
                  "eigenvalue {:.3g} (+- {:.1g}), largest {:.3g}; exact methods may end on a ray",
                  rounded.smallest, rounded.rounding, rounded.largest));
}

}  // namespace

std::vector<Warning> warnings_of(const Inspection& inspection) {
  Collector warnings;
  if (inspection.contact) {
    const ContactFacts& contact = *inspection.contact;
    warn_of_velocities(inspection, warnings);
    warn_of_inertia(contact, inspection.ngc, warnings);
    if (contact.inertia_rank >= 0) {
      warn_of_redundancy(contact, inspection.nc, warnings);
      warn_of_columns(contact, warnings);
      warn_of_rounded_matrix(inspection, warnings);
      warn_of_scaling(inspection, warnings);
    }
    warn_of_friction(contact, warnings);
  } else if (inspection.matrix.dense) {
    warn_of_bare_signs(inspection, warnings);
    warn_of_layout(inspection.matrix, warnings);
    warn_of_bare_difficulties(inspection, warnings);
    warn_of_scaling(inspection, warnings);
  }
  warn_of_degeneracy(inspection, warnings);
  return std::move(warnings).sorted();
}

}  // namespace lcpbench
