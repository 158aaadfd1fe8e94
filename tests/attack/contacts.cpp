#include <cmath>

#include "tests/attack/problems.h"

// The contacts of the attack: v, N, D, mu, edges. Their inertia stands in contact_problems.cpp.
namespace lcpbench::attack {
namespace {

struct Columns {
  Matrix N;               ///< ngc x nc
  std::vector<Matrix> D;  ///< per contact, ngc x edges/2: one of each pair
};

double entry(int style, Draw& draw) {
  switch (style) {
    case 0: return draw.small(4);
    case 1: return draw.chance(1, 2) ? 0 : draw.small(2);
    default: return draw.signed_unit();
  }
}

double noisy(double x, int noise, Draw& draw) {
  switch (noise) {
    case 0: return x;
    case 1: return draw.neighbour(x);
    case 2: return draw.nearly(x, 1e-10);
    default: return draw.nearly(x, 1e-14);
  }
}

/// A contact becomes the copy, the multiple or a combination of earlier ones, exactly or nearly.
void make_redundant(Columns& columns, Index contact, Draw& draw) {
  const Index source = draw.index(0, contact - 1);
  const Index other = draw.index(0, contact - 1);
  const auto factor = static_cast<double>(draw.integer(1, 3));
  const double weight = draw.chance(1, 2) ? 0 : draw.small(2);
  const int noise = static_cast<int>(draw.integer(0, 4)) % 4;
  for (Index k = 0; k < columns.N.rows(); ++k) {
    columns.N(k, contact) = noisy(factor * columns.N(k, source) + weight * columns.N(k, other), noise, draw);
  }
  Matrix& D = columns.D[static_cast<std::size_t>(contact)];
  const Matrix& source_D = columns.D[static_cast<std::size_t>(source)];
  for (Index t = 0; t < std::min(D.cols(), source_D.cols()); ++t) {
    for (Index k = 0; k < D.rows(); ++k) D(k, t) = noisy(factor * source_D(k, t), noise, draw);
  }
}

/// Turns a column so that its product with v is nothing but rounding.
template <class Column>
void cancel(Column&& column, const Vector& v) {
  const double square = dot(v, v);
  if (!(square > 0)) return;
  const double along = dot(column, v) / square;
  if (!std::isfinite(along)) return;
  for (Index k = 0; k < v.size(); ++k) column(k) -= along * v(k);
}

double friction_coefficient(Draw& draw) {
  switch (draw.integer(0, 9)) {
    case 0: return 0;
    case 1: return draw.power_of_two(-60, -20);
    case 2: return draw.power_of_two(4, 33);
    case 3: return 1;
    default: return static_cast<double>(draw.integer(1, 8)) / 8;
  }
}

void cancel_some(Columns& columns, const Vector& v, Draw& draw) {
  const bool all = draw.chance(1, 2);
  for (Index c = 0; c < columns.N.cols(); ++c) {
    if (!all && draw.chance(1, 2)) continue;
    cancel(columns.N.col(c), v);
    Matrix& D = columns.D[static_cast<std::size_t>(c)];
    for (Index t = 0; t < D.cols(); ++t) cancel(D.col(t), v);
  }
}

Jacobian jacobian(Matrix dense, bool sparse) {
  if (sparse) return SparseMatrix(dense.sparseView());
  return dense;
}

}  // namespace

ContactProblem make_contacts(Index ngc, Index nc, int largest_edges, Draw& draw) {
  const int style = static_cast<int>(draw.integer(0, 2));
  ContactProblem contact;
  contact.v.resize(ngc);
  for (double& x : contact.v) x = draw.chance(1, 2) ? draw.small(3) : draw.signed_unit();
  if (draw.chance(1, 20)) contact.v.setZero();
  const bool frictionless = largest_edges == 0 || draw.chance(1, 2);
  const int common = largest_edges > 2 && draw.chance(1, 2) ? 4 : 2;
  const bool mixed = draw.chance(1, 3);
  Columns columns{Matrix(ngc, nc), {}};
  Index directions = 0;
  for (Index c = 0; c < nc; ++c) {
    const int edges = frictionless ? 0 : mixed ? 2 * static_cast<int>(draw.integer(0, largest_edges / 2)) : common;
    contact.edges.push_back(edges);
    directions += edges;
    for (Index k = 0; k < ngc; ++k) columns.N(k, c) = entry(style, draw);
    Matrix& D = columns.D.emplace_back(ngc, edges / 2);
    for (double& x : D.reshaped()) x = entry(style, draw);
    if (c > 0 && draw.chance(1, 4)) make_redundant(columns, c, draw);
    if (draw.chance(1, 40)) columns.N.col(c).setZero();
    if (draw.chance(1, 60)) D.setZero();
  }
  if (draw.chance(1, 6)) cancel_some(columns, contact.v, draw);
  contact.mu.resize(nc);
  Matrix D(ngc, directions);
  Index column = 0;
  for (Index c = 0; c < nc; ++c) {
    const Matrix& half = columns.D[static_cast<std::size_t>(c)];
    contact.mu(c) = half.cols() > 0 ? friction_coefficient(draw) : 0;
    for (const double sign : {1.0, -1.0}) {
      for (Index t = 0; t < half.cols(); ++t) D.col(column++) = sign * half.col(t);
    }
  }
  const bool sparse = draw.chance(1, 4);
  contact.N = jacobian(columns.N, sparse);
  contact.D = jacobian(D, sparse);
  return contact;
}

}  // namespace lcpbench::attack
