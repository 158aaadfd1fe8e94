#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/compliance.h"
#include "core/entries.h"
#include "core/quad_inertia.h"
#include "core/selection.h"
#include "study/inspect/inspection.h"
#include "study/inspect/rigid_bodies.h"
#include "study/inspect/spectra.h"
#include "study/output/json_output.h"

namespace lcpbench {
namespace {

constexpr double kVisible = 0x1p-26;        // sqrt(eps): smaller ones are lost when M = J'G*J squares them in double
constexpr double kNearDuplicate = 0x1p-10;  // contacts of one face lie further apart; three digits of M agree below it
constexpr double kOpposed = 0x1p-48;        // unit normals whose sum is shorter are opposite to rounding
constexpr Index kMostPairs = 2000;          // contacts: above it their pairs are not compared
constexpr double kTinyNormal = 1e-9;        // of a column of N: a lever arm of a nanometre on a hinge
constexpr double kMassRatio = 1e6;
constexpr double kHugeFriction = 10;  // rubber on rock is below 5

/// A copy; of a dense J without its zeros.
SparseMatrix to_sparse(const Jacobian& J) {
  if (const auto* sparse = std::get_if<SparseMatrix>(&J)) return *sparse;
  return std::get<Matrix>(J).sparseView();
}

/// G, or its inverse where that is given.
Matrix given_matrix(const Inertia& inertia) {
  const auto* inverse = std::get_if<InverseInertia>(&inertia);
  return inverse != nullptr ? inverse->Ginv : dense_inertia(inertia);
}

/// The same in 113 bits, up to kLargestQuad: rounded to double, G of dependent factors would be regular.
struct GivenInQuad {
  explicit GivenInQuad(const Inertia& inertia) : matrix(0, 0) {
    const auto* factors = std::get_if<FactoredInertia>(&inertia);
    if (factors == nullptr || factors->X.rows() > kLargestQuad) {
      matrix = QuadMatrix(given_matrix(inertia));
    } else {
      matrix = weighted_gram(QuadMatrix(factors->X), {factors->alpha.begin(), factors->alpha.end()});
      formation_error = static_cast<double>(factors->X.cols() + 2) * kQuadUnitRoundoff;
    }
  }
  double condition() const { return nonzero_condition(spectrum_of(matrix, formation_error)); }
  double scaled_condition() const { return nonzero_condition(spectrum_of(unit_diagonal(matrix), formation_error)); }

  QuadMatrix matrix;
  double formation_error = 0;  ///< see spectrum_of()
};

/// The largest lever arm |r x d| on each body, over all columns [d; r x d] of N and D.
std::vector<double> longest_arms(const ContactProblem& problem, std::size_t bodies) {
  std::vector<double> arms(bodies, 0);
  if (bodies == 0) return arms;
  for (const Jacobian* jacobian : {&problem.N, &problem.D}) {
    const SparseMatrix J = to_sparse(*jacobian);
    for (Index j = 0; j < J.cols(); ++j) {
      std::vector<double> squares(bodies, 0);
      for (SparseMatrix::InnerIterator entry(J, j); entry; ++entry) {
        if (entry.row() % 6 >= 3) squares[static_cast<std::size_t>(entry.row() / 6)] += entry.value() * entry.value();
      }
      for (std::size_t b = 0; b < bodies; ++b) arms[b] = std::max(arms[b], std::sqrt(squares[b]));
    }
  }
  return arms;
}

void inspect_bodies(const ContactProblem& problem, const RigidScene* scene, Inspection& inspection) {
  std::vector<BodyBlock> bodies = rigid_bodies(problem.inertia);
  if (scene != nullptr) {
    bodies.clear();
    for (const RigidBody& body : scene->bodies) bodies.push_back({body.mass, body.inertia});
  }
  const bool given_inverse = std::holds_alternative<InverseInertia>(problem.inertia);
  const std::vector<double> arms = longest_arms(problem, bodies.size());
  Range masses;
  Index judged = 0;
  Index inverted = 0;
  Index too_long = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    masses.add(given_inverse ? 1 / bodies[b].mass : bodies[b].mass);
    const std::optional<bool> inverse = reads_as_inverse(bodies[b], arms[b]);
    if (inverse) ++judged;
    if (inverse && *inverse != given_inverse) {
      ++inverted;
      continue;
    }
    const BodyBlock body = given_inverse ? BodyBlock{1 / bodies[b].mass, bodies[b].inertia.inverse()} : bodies[b];
    if (lengths_look_too_large(body, arms[b])) ++too_long;
  }
  const auto count = static_cast<Index>(bodies.size());
  inspection.facts["contact"]["bodies"] = count;
  if (count > 0) inspection.facts["contact"]["masses_kg"] = range_json(masses);
  inspection.data(2 * inverted > judged, "inertia_inverted", static_cast<double>(inverted),
                  fmt::format("{} of {} bodies have moments that fit the inverse of an inertia: {}", inverted, judged,
                              given_inverse ? "G was given as Ginv?" : "the inverse was given as G?"));
  inspection.data(count > 0 && too_long == count, "length_units", static_cast<double>(too_long),
                  fmt::format("every body ({}) is lighter than a thousandth of the air in its place, or is touched at "
                              "over 100 radii of gyration: are lengths in millimetres?",
                              count));
  inspection.difficulty(masses.spread() > kMassRatio, "mass_ratio", masses.spread(),
                        fmt::format("masses spread from {:.3g} to {:.3g} kg: iterative methods converge slowly, and "
                                    "kg may be mixed with g",
                                    masses.low, masses.high));
}

void inspect_inertia(const ContactProblem& problem, Inspection& inspection) {
  const GivenInQuad given(problem.inertia);
  const auto* factors = std::get_if<FactoredInertia>(&problem.inertia);
  const Index rank = rank_of_doubles(factors != nullptr ? factors->X : given_matrix(problem.inertia));
  const double condition = given.condition();
  const double scaled = given.scaled_condition();
  Json& facts = inspection.facts["contact"];
  facts["inertia_rank"] = rank;
  facts["inertia_condition"] = json_number(condition);
  facts["inertia_condition_scaled"] = json_number(scaled);
  inspection.difficulty(rank < problem.ngc(), "singular_inertia", static_cast<double>(rank),
                        fmt::format("the inertia has rank {} of {}: impulses in its null space move nothing, so "
                                    "{}energy is not z'q + 1/2 z'Mz",
                                    rank, problem.ngc(),
                                    every_contact_yields(problem) ? "" : "the problem may have no solution, and "));
  inspection.difficulty(scaled > kIllConditioned, "ill_conditioned_inertia", scaled,
                        fmt::format("the condition of the inertia with unit diagonal is {:.3g}: M as formed in double "
                                    "keeps about {:.0f} of 16 digits of the lightest direction",
                                    scaled, std::max(0.0, 16 - std::log10(scaled))));
}

/// a_i b_j = a_j b_i for all i, j, in 113 bits: products of doubles are exact there.
bool exactly_parallel(const Vector& a, const Vector& b) {
  Index pivot = 0;
  a.cwiseAbs().maxCoeff(&pivot);
  for (Index i = 0; i < a.size(); ++i) {
    if (Quad{a(i)} * Quad{b(pivot)} != Quad{a(pivot)} * Quad{b(i)}) return false;
  }
  return true;
}

/// @param units  N with columns of length 1 in coordinates that no change of units moves
void inspect_pairs(const ContactProblem& problem, const Matrix& N, const Matrix& units, Inspection& inspection) {
  if (N.cols() > kMostPairs) return;
  Json duplicates = Json::array();
  Json near = Json::array();
  Json opposed = Json::array();
  double nearest = kNearDuplicate;
  for (Index j = 0; j < N.cols(); ++j) {
    for (Index i = 0; i < j; ++i) {
      if (N.col(i).isZero(0) || N.col(j).isZero(0)) continue;
      const double same = (units.col(i) - units.col(j)).norm();
      const double opposite = (units.col(i) + units.col(j)).norm();
      const bool parallel = same <= kNearDuplicate && exactly_parallel(N.col(i), N.col(j));
      const Json pair{{"first", i}, {"second", j}, {"distance", parallel ? 0.0 : std::min(same, opposite)}};
      const bool yields = problem.normal_compliance(i) != 0 || problem.normal_compliance(j) != 0;
      if (opposite <= kOpposed && !yields) opposed.push_back(pair);
      if (parallel) {
        duplicates.push_back(pair);
      } else if (same <= kNearDuplicate) {
        near.push_back(pair);
        nearest = std::min(nearest, same);
      }
    }
  }
  const auto first = [](const Json& pairs) {
    if (pairs.empty()) return std::string();
    return fmt::format("{} and {}{}", pairs[0]["first"].get<Index>(), pairs[0]["second"].get<Index>(),
                       pairs.size() > 1 ? fmt::format(" and {} more pairs", pairs.size() - 1) : "");
  };
  inspection.difficulty(!duplicates.empty(), "duplicate_contacts", static_cast<double>(duplicates.size()),
                        "contacts " + first(duplicates) + " have the same direction exactly");
  inspection.difficulty(!near.empty(), "near_duplicate_contacts", nearest,
                        fmt::format("contacts {} have almost the same direction (nearest: {:.3g} apart)", first(near),
                                    nearest));
  inspection.difficulty(!opposed.empty(), "opposed_contacts", static_cast<double>(opposed.size()),
                        "contacts " + first(opposed) + " push against each other: where neither has a gap, internal forces are "
                        "free, and interior points have no centre");
  Json& facts = inspection.facts["contact"];
  facts["duplicates"] = std::move(duplicates);
  facts["near_duplicates"] = std::move(near);
  facts["opposed"] = std::move(opposed);
}

void inspect_jacobian(const ContactProblem& problem, Inspection& inspection) {
  // M = J'G*J measures row i of J in 1 / sqrt(G_ii), which no change of its unit moves; 1 where that is no number.
  Vector scale = given_matrix(problem.inertia).diagonal().cwiseSqrt();
  if (!std::holds_alternative<InverseInertia>(problem.inertia)) scale = scale.cwiseInverse();
  for (double& each : scale) each = each > 0 && std::isfinite(each) ? each : 1;
  const Matrix N = to_dense(problem.N);
  Matrix J(problem.ngc(), N.cols() + cols(problem.D));
  J << N, to_dense(problem.D);
  const Matrix scaled = scale.asDiagonal() * J;
  const Matrix normals = scaled.leftCols(N.cols());
  Json& facts = inspection.facts["contact"];
  facts["rank_N"] = rank_json(N, normals, kVisible);
  facts["rank_J"] = rank_json(J, scaled, kVisible);
  ContactProblem without_offsets = select_rows(problem, {});
  without_offsets.offset_t.resize(0);
  facts["condition"] = json_number(response_condition(rigid_equivalent(without_offsets)));
  std::vector<Index> rigid;  // what yields along its normal depends on no other: M has its r_n on the diagonal
  for (Index i = 0; i < problem.nc(); ++i) {
    if (problem.normal_compliance(i) == 0) rigid.push_back(i);
  }
  const Index count = std::ssize(rigid);
  const Json rank = count == problem.nc() ? facts["rank_N"]
                                          : rank_json(N(Eigen::all, rigid), normals(Eigen::all, rigid), kVisible);
  const Index exact = rank["exact"];
  const Index visible = rank["visible"].is_null() ? exact : rank["visible"].get<Index>();
  inspection.difficulty(exact < count, "redundant_contacts", static_cast<double>(count - exact),
                        fmt::format("{} of {} rigid contacts depend on the others (rank of their N is {}): impulses "
                                    "may not be unique, and M is singular",
                                    count - exact, count, exact));
  inspection.difficulty(visible < exact, "nearly_redundant_contacts", static_cast<double>(exact - visible),
                        fmt::format("{} of {} rigid contacts depend on the others but for a part below 1.5e-8, which "
                                    "M formed in double cannot show",
                                    exact - visible, count));
  const auto zeros = [](const Matrix& A) { return (A.cwiseAbs().colwise().sum().array() == 0).count(); };
  const Index zero_normals = N.size() > 0 ? zeros(N) : 0;
  const Index zero_directions = J.size() > 0 ? zeros(J) - zero_normals : 0;
  inspection.data(zero_normals > 0, "zero_normals", static_cast<double>(zero_normals),
                  fmt::format("columns of N that are zero: {}. Such a contact pushes nothing", zero_normals));
  Range lengths;
  for (Index i = 0; i < N.cols(); ++i) {
    if (!N.col(i).isZero(0)) lengths.add(N.col(i).stableNorm());
  }
  inspection.data(lengths.low < kTinyNormal, "tiny_normals", lengths.low,
                  fmt::format("a column of N has length {:.3g}, where normals have 1: rounding, which an impulse of 1 "
                              "over that makes up for?",
                              lengths.low));
  inspection.data(zero_directions > 0, "zero_directions", static_cast<double>(zero_directions),
                  fmt::format("columns of D that are zero: {}. Friction there does nothing", zero_directions));
  inspect_pairs(problem, N, unit_columns(normals), inspection);
}

/// Kinds of bounded rows, and equalities that depend on each other.
void inspect_rows(const ContactProblem& problem, Inspection& inspection) {
  const BoundedRows& rows = problem.rows;
  if (!problem.has_rows()) return;
  Index equalities = 0, one_bound = 0, two_bounds = 0, friction = 0, angles = 0, soft = 0;
  std::vector<Index> rigid;  // equalities without compliance
  for (Index row = 0; row < rows.size(); ++row) {
    const auto count_of = [](double bound) { return std::isfinite(bound) ? 1 : 0; };
    const int bounds = count_of(rows.bounds.lower(row)) + count_of(rows.bounds.upper(row));
    const bool is_friction = rows.bounds.friction_of[static_cast<std::size_t>(row)] >= 0;
    Index& kind = is_friction ? friction : bounds == 0 ? equalities : bounds == 1 ? one_bound : two_bounds;
    ++kind;
    angles += rows.is_angle[static_cast<std::size_t>(row)] != 0 ? 1 : 0;
    soft += rows.yields(row) > 0 ? 1 : 0;
    if (!is_friction && bounds == 0 && !(rows.yields(row) > 0)) rigid.push_back(row);
  }
  Json& facts = inspection.facts["contact"];
  facts["bounded_rows"] = {{"equalities", equalities}, {"one_bound", one_bound}, {"two_bounds", two_bounds},
                           {"friction", friction},     {"angles", angles},       {"soft", soft}};
  Index zero = 0;
  for (Index row = 0; row < rows.size(); ++row) {
    bool is_zero = true;
    for_each_entry(rows.R, row, [&](Index, double entry) { is_zero = is_zero && entry == 0; });
    zero += is_zero ? 1 : 0;
  }
  inspection.data(zero > 0, "zero_rows", static_cast<double>(zero),
                  fmt::format("columns of R that are zero: {}. Such a bounded row moves nothing", zero));
  const Index count = std::ssize(rigid);
  if (problem.ngc() > kLargestDense || count > kLargestDense) return;
  const Index rank = rank_of_doubles(to_dense(rows.R)(Eigen::all, rigid));
  inspection.difficulty(rank < count, "redundant_equalities", static_cast<double>(count - rank),
                        fmt::format("{} of {} rigid equalities depend on the others (their rank is {}): their impulses "
                                    "are not unique, and where their offsets contradict each other there is no "
                                    "solution",
                                    count - rank, count, rank));
}

void inspect_friction(const ContactProblem& problem, Inspection& inspection) {
  const ContactLayout layout = contact_layout(problem);
  Index zero = 0;
  double largest = 0;
  for (const Index contact : layout.cone_contact) {
    zero += problem.mu(contact) == 0 ? 1 : 0;
    largest = std::max(largest, problem.mu(contact));
  }
  Json& facts = inspection.facts["contact"];
  facts["frictional_contacts"] = layout.cones;
  facts["largest_mu"] = json_number(largest);
  inspection.difficulty(zero > 0, "frictionless_edges", static_cast<double>(zero),
                        fmt::format("{} of {} contacts with friction edges have mu = 0: their rows only make the "
                                    "problem larger and degenerate",
                                    zero, layout.cones));
  inspection.data(largest > kHugeFriction, "huge_friction", largest,
                  fmt::format("the largest mu is {:.3g}: an angle in degrees, or meant as infinite?", largest));
  if (!problem.is_soft()) return;
  Range normal;
  Range tangential;
  for (const double r : problem.compliance_n) normal.add(r);
  for (const double r : problem.compliance_t) tangential.add(r);
  facts["compliance_n"] = range_json(normal);
  facts["compliance_t"] = range_json(tangential);
}

}  // namespace

std::vector<Index> independent_rows(const ContactProblem& problem) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Index> rows;
  for (Index i = 0; i < layout.nc; ++i) rows.push_back(i);
  for (std::size_t i = 0; i + 1 < layout.friction_begin.size(); ++i) {
    const Index half = (layout.friction_begin[i + 1] - layout.friction_begin[i]) / 2;
    for (Index t = 0; t < half; ++t) rows.push_back(layout.friction_offset() + layout.friction_begin[i] + t);
  }
  return rows;
}

double response_condition(const ContactProblem& problem) {
  if (problem.ngc() > kLargestDense || lcp_size(problem) > kLargestDense) return Spectrum::kNone;
  const QuadInertia inertia(problem.inertia);
  if (!inertia.well_defined()) return Spectrum::kNone;
  Matrix J(problem.ngc(), problem.nc() + cols(problem.D));
  J << to_dense(problem.N), to_dense(problem.D);
  const QuadMatrix columns(J(Eigen::all, independent_rows(problem)));
  QuadMatrix A(columns.cols, columns.cols);
  for (std::size_t j = 0; j < columns.cols; ++j) {
    QuadVector y(columns.rows);
    for (std::size_t i = 0; i < columns.rows; ++i) y[i] = columns(i, j);
    inertia.solve(y);
    for (std::size_t i = j; i < columns.cols; ++i) {
      Quad sum = 0;
      for (std::size_t row = 0; row < columns.rows; ++row) sum += columns(row, i) * y[row];
      A(i, j) = A(j, i) = sum;
    }
  }
  // The relative error of a solve with G is its condition times the unit roundoff, a few times ngc.
  const double conditioning = GivenInQuad(problem.inertia).scaled_condition();
  const double error = 8 * static_cast<double>(J.rows() + 1) * kQuadUnitRoundoff *
                       (std::isfinite(conditioning) ? conditioning : 1e16);
  return nonzero_condition(spectrum_of(unit_diagonal(A), error));
}

void inspect_contact(const ContactProblem& problem, const RigidScene* scene, Inspection& inspection) {
  constexpr const char* kKinds[]{"dense G", "blocks of G", "factors of G", "G inverse only"};
  Json& facts = inspection.facts["contact"];
  const auto [islands, largest] = island_sizes(row_islands(problem), problem.nc());
  facts = {{"inertia", kKinds[problem.inertia.index()]}, {"islands", islands}, {"largest_island", largest}};
  inspect_bodies(problem, scene, inspection);
  if (problem.ngc() <= kLargestDense && lcp_size(problem) <= kLargestDense) {
    inspect_inertia(problem, inspection);
    inspect_jacobian(problem, inspection);
  }
  inspect_friction(problem, inspection);
  inspect_rows(problem, inspection);
}

}  // namespace lcpbench
