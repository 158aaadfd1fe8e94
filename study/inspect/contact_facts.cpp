#include "study/inspect/contact_facts.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/quad_inertia.h"
#include "study/inspect/matrix_facts.h"
#include "study/inspect/rigid_bodies.h"

namespace lcpbench {
namespace {

constexpr double kVisible = 0x1p-26;        // sqrt(eps): see Rank
constexpr double kNearDuplicate = 0x1p-10;  // contacts of one face lie further apart; three digits of M agree below it
constexpr double kParallel = 0x1p-48;
constexpr Index kMostPairs = 2000;  // contacts

const char* kind_of(const Inertia& inertia) {
  constexpr const char* kKinds[]{"dense G", "blocks of G", "factors of G", "G inverse only"};
  return kKinds[inertia.index()];
}

/// sqrt(G_ii), or 1/sqrt(Ginv_ii): with these, coordinates of any unit are measured alike. 1 where that is no number.
Vector coordinate_scale(const Inertia& inertia) {
  const auto* inverse = std::get_if<InverseInertia>(&inertia);
  const Vector diagonal =
      inverse != nullptr ? Vector(inverse->Ginv.diagonal()) : Vector(dense_inertia(inertia).diagonal());
  Vector scale(diagonal.size());
  for (Index i = 0; i < diagonal.size(); ++i) {
    const double root = std::sqrt(diagonal(i));
    scale(i) = root > 0 && std::isfinite(root) ? (inverse != nullptr ? 1 / root : root) : 1;
  }
  return scale;
}

void add_inertia(const ContactProblem& problem, const QuadInertia& quad, ContactFacts& facts) {
  const auto* inverse = std::get_if<InverseInertia>(&problem.inertia);
  const Matrix G = inverse != nullptr ? inverse->Ginv : dense_inertia(problem.inertia);
  facts.proven_definite = quad.proven_positive_definite();
  if (const auto* factors = std::get_if<FactoredInertia>(&problem.inertia)) {
    facts.inertia_rank = rank_of_doubles(factors->X);
  } else {
    facts.inertia_rank = facts.proven_definite ? G.rows() : rank_of_doubles(G);
  }
  // Of singular factors the eigenvalues beyond the rank are rounding.
  const auto condition = [&facts](const Matrix& A) {
    if (facts.inertia_rank == 0) return 1.0;
    Vector values = Eigen::SelfAdjointEigenSolver<Matrix>(A, Eigen::EigenvaluesOnly).eigenvalues().cwiseAbs();
    std::sort(values.begin(), values.end());
    return values(values.size() - 1) / values(values.size() - facts.inertia_rank);
  };
  facts.inertia_condition = condition(G);
  facts.scaled_condition = condition(unit_diagonal(G));
}

SparseMatrix to_sparse(const Jacobian& J) {
  if (const auto* sparse = std::get_if<SparseMatrix>(&J)) return *sparse;
  return to_dense(J).sparseView();
}

std::vector<BodyBlock> bodies_of(const ContactProblem& problem, const RigidScene* scene) {
  if (scene == nullptr) return rigid_bodies(problem.inertia);
  std::vector<BodyBlock> bodies;
  for (const RigidBody& body : scene->bodies) bodies.push_back({body.mass, body.inertia});
  return bodies;
}

void add_bodies(const ContactProblem& problem, const RigidScene* scene, ContactFacts& facts) {
  const std::vector<BodyBlock> bodies = bodies_of(problem, scene);
  facts.bodies = static_cast<Index>(bodies.size());
  if (bodies.empty()) return;
  std::vector<double> arms(bodies.size(), 0);
  for (const Jacobian* jacobian : {&problem.N, &problem.D}) {
    const SparseMatrix J = to_sparse(*jacobian);
    for (Index j = 0; j < J.cols(); ++j) {
      std::vector<double> squares(bodies.size(), 0);
      for (SparseMatrix::InnerIterator entry(J, j); entry; ++entry) {
        if (entry.row() % 6 >= 3) squares[static_cast<std::size_t>(entry.row() / 6)] += entry.value() * entry.value();
      }
      for (std::size_t b = 0; b < bodies.size(); ++b) arms[b] = std::max(arms[b], std::sqrt(squares[b]));
    }
  }
  const bool given_inverse = std::holds_alternative<InverseInertia>(problem.inertia);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    facts.masses.add(given_inverse ? 1 / bodies[b].mass : bodies[b].mass);
    const std::optional<bool> inverse = reads_as_inverse(bodies[b], arms[b]);
    if (inverse) ++facts.bodies_judged;
    if (inverse && *inverse != given_inverse) {
      ++facts.bodies_as_inverse;
      continue;
    }
    const BodyBlock body = given_inverse ? BodyBlock{1 / bodies[b].mass, bodies[b].inertia.inverse()} : bodies[b];
    if (lengths_look_too_large(body, arms[b])) ++facts.bodies_too_long;
  }
}

/// Columns scaled to length 1; zero columns stay.
Matrix unit_columns(const Matrix& A, const Vector& row_scale) {
  Matrix scaled = row_scale.asDiagonal() * A;
  for (Index j = 0; j < scaled.cols(); ++j) {
    const double length = scaled.col(j).stableNorm();
    if (length > 0) scaled.col(j) /= length;
  }
  return scaled;
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

void add_pairs(const Matrix& N, const Matrix& units, ContactFacts& facts) {
  facts.pairs_compared = N.cols() <= kMostPairs;
  if (!facts.pairs_compared || N.rows() == 0) return;
  for (Index j = 0; j < N.cols(); ++j) {
    if (N.col(j).isZero(0)) continue;
    for (Index i = 0; i < j; ++i) {
      if (N.col(i).isZero(0)) continue;
      const double same = (units.col(i) - units.col(j)).norm();
      const double opposite = (units.col(i) + units.col(j)).norm();
      if (opposite <= kParallel) facts.opposed.push_back({i, j, opposite, true});
      if (!(same <= kNearDuplicate)) continue;
      if (exactly_parallel(N.col(i), N.col(j))) {
        facts.duplicates.push_back({i, j, 0, false});
      } else {
        facts.near_duplicates.push_back({i, j, same, false});
      }
    }
  }
}

void add_friction(const ContactProblem& problem, ContactFacts& facts) {
  const ContactLayout layout = contact_layout(problem);
  facts.frictional_contacts = layout.cones;
  for (const Index contact : layout.cone_contact) {
    if (problem.mu(contact) == 0) ++facts.zero_mu;
    facts.largest_mu = std::max(facts.largest_mu, problem.mu(contact));
  }
}

void add_directions(const ContactProblem& problem, const Matrix& normals, const Matrix& directions,
                    ContactFacts& facts) {
  const ContactLayout layout = contact_layout(problem);
  for (const Index contact : layout.cone_contact) {
    const auto c = static_cast<std::size_t>(contact);
    for (Index t = layout.friction_begin[c]; t < layout.friction_begin[c + 1]; ++t) {
      if (directions.col(t).isZero(0)) {
        ++facts.zero_directions;
        continue;
      }
      const double distance = std::min((directions.col(t) - normals.col(contact)).norm(),
                                       (directions.col(t) + normals.col(contact)).norm());
      if (distance <= kVisible) ++facts.directions_along_normal;
    }
  }
}

QuadMatrix response_matrix(const Matrix& J, const QuadInertia& inertia) {
  const QuadMatrix columns(J);
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
  return A;
}

Matrix rounded(const QuadMatrix& A) {
  Matrix doubles(static_cast<Index>(A.rows), static_cast<Index>(A.cols));
  for (std::size_t i = 0; i < A.rows; ++i) {
    for (std::size_t j = 0; j < A.cols; ++j) {
      doubles(static_cast<Index>(i), static_cast<Index>(j)) = to_double(A(i, j));
    }
  }
  return doubles;
}

void add_truth(const Matrix& J, const QuadInertia& inertia, ContactFacts& facts) {
  if (!inertia.well_defined()) return;
  const QuadMatrix A = response_matrix(J, inertia);
  // The relative error of a solve with G is its condition times the unit roundoff, a few times ngc.
  const double conditioning = std::isfinite(facts.scaled_condition) ? facts.scaled_condition : 1e16;
  const double formation = 8 * static_cast<double>(J.rows() + 1) * conditioning * kQuadUnitRoundoff;
  const auto spectrum = [formation](const QuadMatrix& B) {
    return B.rows <= kLargestQuad ? spectrum_of(B, formation) : spectrum_of(rounded(B));
  };
  facts.truth = spectrum(A);
  const Spectrum scaled = spectrum(unit_diagonal(A));
  facts.condition = scaled.largest / scaled.smallest_nonzero;
}

/// Whether G* x is zero to rounding, for x other than zero.
bool moves_nothing(const Vector& x, const QuadInertia& inertia) {
  const QuadVector column(x.begin(), x.end());
  const Quad size = x.cwiseAbs().maxCoeff();
  QuadVector effect = column;
  QuadVector scale(column.size(), size);
  if (inertia.has_inertia()) {
    const QuadVector outside = inertia.outside_range(column);
    for (std::size_t i = 0; i < column.size(); ++i) effect[i] -= outside[i];
  } else {
    scale = inertia.scale(scale);
    inertia.solve(effect);
  }
  for (std::size_t i = 0; i < effect.size(); ++i) {
    if (!(abs(effect[i]) <= kParallel * scale[i])) return false;
  }
  return true;
}

void add_columns(const Matrix& N, const QuadInertia& inertia, ContactFacts& facts) {
  for (Index j = 0; j < N.cols(); ++j) {
    if (N.col(j).isZero(0)) {
      ++facts.zero_normals;
    } else if (inertia.well_defined() && moves_nothing(N.col(j), inertia)) {
      ++facts.immovable;
    }
  }
}

void add_dense(const ContactProblem& problem, ContactFacts& facts) {
  const QuadInertia inertia(problem.inertia);
  add_inertia(problem, inertia, facts);
  const Vector scale = coordinate_scale(problem.inertia);
  const Matrix N = to_dense(problem.N);
  const Matrix D = to_dense(problem.D);
  Matrix J(problem.ngc(), N.cols() + D.cols());
  J.leftCols(N.cols()) = N;
  J.rightCols(D.cols()) = D;
  const Matrix normals = unit_columns(N, scale);
  facts.normals = {rank_of_doubles(N), numerical_rank(normals, kVisible)};
  facts.jacobian = {rank_of_doubles(J), numerical_rank(unit_columns(J, scale), kVisible)};
  facts.normals_by_rows = facts.bodies > 0 && N.rows() == N.cols() && !columns_are_unit_normals(N) &&
                          columns_are_unit_normals(N.transpose());
  add_pairs(N, normals, facts);
  add_directions(problem, normals, unit_columns(D, scale), facts);
  add_truth(J(Eigen::all, independent_rows(problem)), inertia, facts);
  add_columns(N, inertia, facts);
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

ContactFacts contact_facts(const ContactProblem& problem, const RigidScene* scene) {
  ContactFacts facts;
  facts.inertia = kind_of(problem.inertia);
  add_friction(problem, facts);
  add_bodies(problem, scene, facts);
  for (const double r : problem.compliance_n) facts.compliance_n.add(r);
  for (const double r : problem.compliance_t) facts.compliance_t.add(r);
  std::tie(facts.islands, facts.largest_island) = island_sizes(row_islands(problem), problem.nc());
  if (problem.ngc() <= kLargestDense && lcp_size(problem) <= kLargestDense) add_dense(problem, facts);
  return facts;
}

}  // namespace lcpbench
