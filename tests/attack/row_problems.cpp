#include <algorithm>
#include <limits>

#include "tests/attack/problems.h"

// Bounded rows beside contacts. All data are small integers or multiples of 1/8, in units that powers of two change.
namespace lcpbench::attack {
namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

double eighths(int size, Draw& draw) { return draw.small(8 * size) / 8; }

/// A A' and as much more on the diagonal.
Matrix small_inertia(Index n, Draw& draw) {
  Matrix A(n, n);
  for (double& x : A.reshaped()) x = draw.small(1);
  Matrix G = product(A, A.transpose());
  for (Index i = 0; i < n; ++i) G(i, i) += static_cast<double>(draw.integer(1, 4));
  return G;
}

void add_contacts(ContactProblem& problem, Index nc, int largest_edges, Draw& draw) {
  const Index ngc = problem.ngc();
  Matrix N(ngc, nc);
  std::vector<Vector> directions;
  problem.mu = Vector::Zero(nc);
  for (Index c = 0; c < nc; ++c) {
    for (Index k = 0; k < ngc; ++k) N(k, c) = draw.chance(1, 3) ? 0 : draw.small(2);
    const int edges = 2 * static_cast<int>(draw.integer(0, largest_edges / 2));
    problem.edges.push_back(edges);
    if (edges == 0) continue;
    problem.mu(c) = static_cast<double>(draw.integer(0, 6)) / 4;
    std::vector<Vector> half(static_cast<std::size_t>(edges / 2), Vector(ngc));
    for (Vector& direction : half) {
      for (double& x : direction) x = draw.small(2);
    }
    for (const double sign : {1.0, -1.0}) {
      for (const Vector& direction : half) directions.push_back(sign * direction);
    }
  }
  Matrix D(ngc, static_cast<Index>(directions.size()));
  for (Index t = 0; t < D.cols(); ++t) D.col(t) = directions[static_cast<std::size_t>(t)];
  problem.N = N;
  problem.D = D;
  if (draw.chance(1, 3)) {
    problem.b.resize(nc);
    for (double& b : problem.b) b = draw.chance(1, 4) ? eighths(2, draw) : static_cast<double>(draw.integer(0, 2));
  }
}

/// Bounds and offset of a row, but for those of friction.
void draw_row(BoundedRows& rows, Index i, Draw& draw) {
  double &lower = rows.bounds.lower(i), &upper = rows.bounds.upper(i);
  lower = -kNoBound;
  upper = kNoBound;
  switch (draw.integer(0, 5)) {
    case 0: break;  // an equality
    case 1: lower = 0; break;
    case 2: upper = 0; break;
    case 3:  // dry friction
      upper = std::max(0.125, std::abs(eighths(2, draw)));
      lower = -upper;
      break;
    case 4:  // a motor
      lower = -std::abs(eighths(2, draw));
      upper = std::max(0.125, std::abs(eighths(2, draw)));
      break;
    default:  // with one bound, away from zero
      (draw.chance(1, 2) ? lower : upper) = 0.25;
      if (lower > 0) lower = -lower;
  }
  rows.b(i) = draw.chance(1, 2) ? 0 : eighths(1, draw);
  rows.compliance(i) = draw.chance(1, 4) ? std::abs(eighths(1, draw)) : 0;
}

/// How rows depend on one another.
enum class Relation { kNone, kRedundant, kContradicting };

/// The direction of an earlier row, or of a contact, once more; its offset with it, or another one.
void depend(BoundedRows& rows, Matrix& R, Index i, const ContactProblem& problem, Relation relation, Draw& draw) {
  double factor = draw.sign();
  factor *= static_cast<double>(draw.integer(1, 2));
  if (i == 0 || (problem.nc() > 0 && draw.chance(1, 4))) {
    if (problem.nc() == 0) return;
    const Index c = draw.index(0, problem.nc() - 1);
    R.col(i) = factor * to_dense(problem.N).col(c);
    rows.b(i) = factor * problem.offset(c);
  } else {
    const Index source = draw.index(0, i - 1);
    R.col(i) = factor * R.col(source);
    rows.b(i) = factor * rows.b(source);
    if (i > 1 && draw.chance(1, 2)) {
      const Index other = draw.index(0, i - 1);
      R.col(i) += R.col(other);
      rows.b(i) += rows.b(other);
    }
  }
  if (relation == Relation::kContradicting) rows.b(i) += eighths(1, draw);
  if (draw.chance(2, 3)) {
    rows.bounds.lower(i) = -kNoBound;
    rows.bounds.upper(i) = kNoBound;
    rows.compliance(i) = 0;
  }
}

void add_rows(ContactProblem& problem, Relation relation, Draw& draw) {
  const Index ngc = problem.ngc(), m = draw.index(relation == Relation::kNone ? 1 : 2, 4);
  BoundedRows& rows = problem.rows;
  rows.bounds = LcpBounds::nonnegative(m);
  rows.b = rows.compliance = Vector::Zero(m);
  Matrix R(ngc, m);
  for (Index i = 0; i < m; ++i) {
    for (Index k = 0; k < ngc; ++k) R(k, i) = draw.chance(1, 3) ? 0 : draw.small(2);
    if (draw.chance(1, 20)) R.col(i).setZero();
    draw_row(rows, i, draw);
    if (relation != Relation::kNone && draw.chance(2, 3)) depend(rows, R, i, problem, relation, draw);
    rows.is_angle.push_back(draw.chance(1, 2) ? 1 : 0);
  }
  for (Index i = 0; i < m; ++i) {  // friction of a row whose impulse is none below zero
    const Index load = draw.index(0, m - 1);
    if (!draw.chance(1, 3) || load == i || rows.bounds.friction_of[static_cast<std::size_t>(load)] >= 0) continue;
    const auto& of = rows.bounds.friction_of;
    if (std::find(of.begin(), of.end(), static_cast<int>(i)) != of.end()) continue;
    rows.bounds.lower(load) = 0;
    if (rows.bounds.upper(load) == 0) rows.bounds.upper(load) = draw.chance(1, 2) ? 1 : kNoBound;
    rows.bounds.lower(i) = -kNoBound;
    rows.bounds.upper(i) = kNoBound;
    rows.bounds.friction_of[static_cast<std::size_t>(i)] = static_cast<int>(load);
    rows.bounds.mu(i) = static_cast<double>(draw.integer(0, 6)) / 4;
  }
  for (Vector* numbers : {&rows.b, &rows.compliance}) {
    if (numbers->isZero(0)) numbers->resize(0);
  }
  rows.R = R;
  if (draw.chance(1, 3)) {
    rows.R = SparseMatrix(R.sparseView());
    problem.N = SparseMatrix(to_dense(problem.N).sparseView());
    problem.D = SparseMatrix(to_dense(problem.D).sparseView());
  }
}

ContactProblem with_rows(Relation relation, Index largest_nc, int largest_edges, Draw& draw) {
  ContactProblem problem;
  problem.v.resize(draw.index(1, 6));
  for (double& x : problem.v) x = draw.small(3);
  if (draw.chance(1, 20)) problem.v.setZero();
  add_contacts(problem, draw.index(0, largest_nc), largest_edges, draw);
  add_rows(problem, relation, draw);
  problem.inertia = DenseInertia{small_inertia(problem.ngc(), draw)};
  return problem;
}

ContactProblem joints(Draw& draw) { return with_rows(Relation::kNone, 0, 0, draw); }
ContactProblem beside_contacts(Draw& draw) { return with_rows(Relation::kNone, 3, 0, draw); }
ContactProblem beside_friction(Draw& draw) { return with_rows(Relation::kNone, 3, 4, draw); }
ContactProblem redundant(Draw& draw) { return with_rows(Relation::kRedundant, 2, 2, draw); }
ContactProblem contradicting(Draw& draw) { return with_rows(Relation::kContradicting, 2, 2, draw); }

ContactProblem soft_contacts(Draw& draw) {
  ContactProblem problem = with_rows(draw.chance(1, 2) ? Relation::kNone : Relation::kContradicting, 2, 4, draw);
  const Index nc = problem.nc();
  problem.compliance_n = problem.compliance_t = Vector::Zero(nc);
  for (Index c = 0; c < nc; ++c) {
    problem.compliance_n(c) = std::abs(eighths(1, draw));
    if (problem.edges[static_cast<std::size_t>(c)] > 0) problem.compliance_t(c) = std::abs(eighths(1, draw));
  }
  for (Vector* numbers : {&problem.compliance_n, &problem.compliance_t}) {
    if (numbers->isZero(0)) numbers->resize(0);
  }
  return problem;
}

/// R = G X with a sparse X: rows that move few coordinates, of which rounding makes all.
ContactProblem few_coordinates(Draw& draw) {
  ContactProblem problem = with_rows(Relation::kNone, 3, 2, draw);
  problem.rows.R = product(dense_inertia(problem.inertia), to_dense(problem.rows.R));
  return problem;
}

/// Bodies of their own, some coupled by rows.
ContactProblem bodies(Draw& draw) {
  ContactProblem problem = with_rows(Relation::kRedundant, 3, 2, draw);
  BlockInertia blocks;
  for (Index left = problem.ngc(); left > 0;) {
    const Index size = std::min(left, draw.index(1, 2));
    blocks.blocks.push_back(small_inertia(size, draw));
    left -= size;
  }
  problem.inertia = blocks;
  return problem;
}

/// Fewer rank-one terms than coordinates, or G* alone.
ContactProblem singular(Draw& draw) {
  ContactProblem problem = with_rows(Relation::kRedundant, 2, 2, draw);
  const Index ngc = problem.ngc(), terms = draw.index(1, ngc);
  FactoredInertia inertia{Matrix(ngc, terms), Vector::Ones(terms)};
  for (double& x : inertia.X.reshaped()) x = draw.small(2);
  if (draw.chance(1, 2)) {
    problem.inertia = InverseInertia{product(inertia.X, inertia.X.transpose())};
  } else {
    problem.inertia = inertia;
  }
  return problem;
}

/// Metres, seconds and kilograms scaled by powers of two; the angles of the rows are scaled by another length.
ContactProblem other_units(Draw& draw) {
  ContactProblem problem = with_rows(Relation::kRedundant, 2, 2, draw);
  Matrix R = to_dense(problem.rows.R);
  BoundedRows& rows = problem.rows;
  const double radius = draw.power_of_two(-8, 8), speed = draw.power_of_two(-40, 10);
  for (Index i = 0; i < rows.size(); ++i) {
    if (rows.is_angle[static_cast<std::size_t>(i)] == 0) continue;
    R.col(i) *= radius;
    if (rows.b.size() > 0) rows.b(i) *= radius;
    rows.bounds.lower(i) /= radius;
    rows.bounds.upper(i) /= radius;
    if (rows.compliance.size() > 0) rows.compliance(i) *= radius * radius;
  }
  rows.R = R;
  problem.v *= speed;
  problem.b *= speed;
  rows.b *= speed;
  rows.bounds.lower *= speed;
  rows.bounds.upper *= speed;
  return problem;
}

struct Kind {
  const char* name;
  ContactProblem (*make)(Draw&);
};

constexpr Kind kKinds[] = {{"joints", joints},
                           {"beside-contacts", beside_contacts},
                           {"beside-friction", beside_friction},
                           {"redundant", redundant},
                           {"contradicting", contradicting},
                           {"soft-contacts", soft_contacts},
                           {"few-coordinates", few_coordinates},
                           {"bodies", bodies},
                           {"singular", singular},
                           {"other-units", other_units}};

}  // namespace

const std::vector<std::string>& row_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

ContactProblem make_rows_of_kind(std::size_t kind, Draw& draw) { return kKinds[kind].make(draw); }

}  // namespace lcpbench::attack
