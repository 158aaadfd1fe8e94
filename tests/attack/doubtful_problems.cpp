#include <algorithm>
#include <cmath>

#include "tests/attack/problems.h"

// Contact problems whose rank, scale or solvability is in doubt when it is computed in double.
namespace lcpbench::attack {
namespace {

/// Contacts in the usual sizes; in a fifth of the problems with offsets.
ContactProblem contacts(Index least_ngc, Index largest_ngc, Draw& draw) {
  const Index ngc = draw.index(least_ngc, largest_ngc);
  ContactProblem contact = make_contacts(ngc, draw.index(1, draw.chance(1, 4) ? 6 : 3), 4, draw);
  if (!draw.chance(1, 5)) return contact;
  contact.b.resize(contact.nc());
  for (double& b : contact.b) b = draw.chance(1, 2) ? 0 : draw.small(2) * draw.power_of_two(-3, 1);
  return contact;
}

Matrix small_integers(Index rows, Index cols, int size, Draw& draw) {
  Matrix X(rows, cols);
  for (double& x : X.reshaped()) x = draw.small(size);
  return X;
}

FactoredInertia factors(Matrix X, Draw& draw) {
  Vector alpha(X.cols());
  const bool ones = draw.chance(2, 3);
  for (double& a : alpha) a = ones ? 1 : draw.power_of_two(-10, 10);
  return {std::move(X), std::move(alpha)};
}

/// Factors that are small in one direction, or zero: a coordinate, or the sum of two.
ContactProblem light_direction(Draw& draw) {
  ContactProblem contact = contacts(1, 5, draw);
  const Index ngc = contact.ngc();
  Matrix X = small_integers(ngc, draw.index(1, ngc + 2), draw.chance(1, 2) ? 1 : 4, draw);
  if (draw.chance(1, 2)) {
    for (Index i = 0; i < std::min(ngc, X.cols()); ++i) X(i, i) += 5;  // independent but for the light row
  }
  const Index light = draw.index(0, ngc - 1);
  const double sizes[] = {1e-12, 1e-13, 1e-14, 1e-15, 1e-16, 1e-17, 1e-18, 0x1p-46, 0x1p-48, 0x1p-52, 0x1p-26, 0};
  X.row(light) *= sizes[draw.integer(0, 11)];
  if (ngc > 1 && draw.chance(1, 3)) X.row(light) += X.row((light + 1) % ngc);
  contact.inertia = factors(std::move(X), draw);
  return contact;
}

/// x some units in the last place on.
double shifted(double x, int units, Draw& draw) {
  for (int k = 0; k < units; ++k) x = draw.neighbour(x);
  return x;
}

/// Columns or rows that are combinations of the others but for a few units in the last place.
ContactProblem nearly_dependent(Draw& draw) {
  ContactProblem contact = contacts(2, 5, draw);
  const Index ngc = contact.ngc();
  const bool integers = draw.chance(1, 2);
  Matrix X = small_integers(ngc, draw.index(2, ngc + 1), 3, draw);
  if (!integers) {
    for (double& x : X.reshaped()) x = draw.signed_unit();
  }
  const auto factor = static_cast<double>(draw.integer(1, 3));
  const int units = 1 << draw.integer(0, 4);
  const bool rows = draw.chance(1, 2);
  const Index count = rows ? ngc : X.cols();
  const Index from = draw.index(0, count - 1);
  const Index to = (from + 1) % count;
  for (Index k = 0; k < (rows ? X.cols() : ngc); ++k) {
    double& x = rows ? X(to, k) : X(k, to);
    x = factor * (rows ? X(from, k) : X(k, from));
    if (draw.chance(2, 3)) x = shifted(x, static_cast<int>(draw.integer(0, units)), draw);
  }
  contact.inertia = factors(std::move(X), draw);
  return contact;
}

/// A product of small integers of reduced rank: exactly singular.
Matrix reduced_rank(Index rows, Index cols, Draw& draw) {
  const Index rank = draw.index(1, std::max<Index>(1, std::min(rows, cols) - 1));
  return product(small_integers(rows, rank, 2, draw), small_integers(rank, cols, 2, draw));
}

/// At least as many factors as coordinates, of less rank; sometimes one entry is a unit in the last place off.
ContactProblem deficient_factors(Draw& draw) {
  ContactProblem contact = contacts(2, 5, draw);
  Matrix X = reduced_rank(contact.ngc(), draw.index(contact.ngc(), contact.ngc() + 2), draw);
  if (draw.chance(1, 3)) X *= draw.nearly(1, 0.01);
  if (draw.chance(1, 5)) X(0, 0) = draw.neighbour(X(0, 0));
  contact.inertia = factors(std::move(X), draw);
  return contact;
}

/// Weighted Laplacians of small graphs, or X X': singular, semidefinite and exact.
Matrix semidefinite(Index n, Draw& draw) {
  Matrix A = Matrix::Zero(n, n);
  if (draw.chance(1, 2)) {
    for (Index i = 0; i < n; ++i) {
      const Index j = draw.index(0, n - 1);
      const auto weight = static_cast<double>(draw.integer(0, 9));
      A(i, i) += weight;
      if (j == i) continue;
      const double sign = draw.sign();
      A(j, j) += weight;
      A(i, j) -= sign * weight;
      A(j, i) -= sign * weight;
    }
  } else {
    const Matrix X = reduced_rank(n, n, draw);
    A = product(X, X.transpose());
  }
  return A * draw.power_of_two(-3, 3);
}

ContactProblem semidefinite_inverse(Draw& draw) {
  ContactProblem contact = contacts(1, 6, draw);
  contact.inertia = InverseInertia{semidefinite(contact.ngc(), draw)};
  return contact;
}

/// Of these G only those are kept that Cholesky takes for definite, as the reader of problem files does.
ContactProblem semidefinite_inertia(Draw& draw) {
  ContactProblem contact = contacts(1, 6, draw);
  Matrix G = semidefinite(contact.ngc(), draw);
  if (draw.chance(1, 2)) G = 3 * G + (draw.chance(1, 2) ? 0 : 0x1p-40) * Matrix::Identity(G.rows(), G.rows());
  contact.inertia = DenseInertia{G};
  return contact;
}

/// Two walls against each other whose offsets ask for nothing, or for some units in the last place more or less.
ContactProblem closing_walls(Draw& draw) {
  const Index ngc = draw.index(1, 4);
  ContactProblem contact = make_contacts(ngc, draw.index(2, 5), draw.chance(1, 2) ? 4 : 0, draw);
  Matrix N = to_dense(contact.N);
  const Index wall = draw.index(0, contact.nc() - 1);
  const Index opposite = (wall + 1) % contact.nc();
  const auto factor = static_cast<double>(draw.integer(1, 3));
  N.col(opposite) = -factor * N.col(wall);
  contact.N = N;
  contact.b = Vector::Zero(contact.nc());
  for (double& b : contact.b) b = draw.chance(1, 2) ? 0 : draw.small(2);
  const double gap = draw.chance(1, 3) ? draw.mantissa() : static_cast<double>(draw.integer(-3, 3)) / 4;
  contact.b(wall) = gap;
  const double extra[] = {0, 0, 1e-12, -1e-12, 1e-5, -1e-5, -1e-4, -3e-4};
  contact.b(opposite) = -factor * gap + extra[draw.integer(0, 7)];
  if (draw.chance(2, 3)) contact.b(opposite) = shifted(contact.b(opposite), static_cast<int>(draw.integer(1, 3)), draw);
  if (draw.chance(1, 2)) contact.v.setZero();
  Matrix G = Matrix::Identity(ngc, ngc);
  if (draw.chance(1, 2)) {
    const Matrix L = small_integers(ngc, ngc, 2, draw).triangularView<Eigen::StrictlyLower>();
    G = product(L + G, (L + G).transpose());
  }
  contact.inertia = DenseInertia{G};
  if (draw.chance(1, 4)) contact.inertia = InverseInertia{G};
  return contact;
}

using Maker = ContactProblem (*)(Draw&);
constexpr Maker kMakers[] = {light_direction,      nearly_dependent,     deficient_factors,
                             semidefinite_inverse, semidefinite_inertia, closing_walls};

/// Any of the others, or of the kinds of contact problems, in units of up to 2^+-140.
ContactProblem extreme_units(Draw& draw) {
  ContactProblem contact = draw.chance(2, 3)
                               ? kMakers[draw.integer(0, 5)](draw)
                               : make_contact_of_kind(static_cast<std::size_t>(draw.integer(0, 12)), draw);
  change_units(contact, 140, draw);
  return contact;
}

/// Friction of 4 edges everywhere, which solvers of the round cone take.
ContactProblem with_friction(Draw& draw, Maker maker) {
  ContactProblem contact = maker(draw);
  Matrix D(contact.ngc(), 4 * contact.nc());
  for (Index c = 0; c < contact.nc(); ++c) {
    const Matrix half = small_integers(contact.ngc(), 2, 3, draw);
    D.middleCols(4 * c, 4) << half, -half;
    contact.mu(c) = draw.chance(1, 8) ? 0 : draw.power_of_two(-4, 2);
  }
  contact.D = D;
  contact.edges.assign(contact.edges.size(), 4);
  return contact;
}

ContactProblem round_friction(Draw& draw) {
  const Maker makers[] = {light_direction, nearly_dependent, deficient_factors, semidefinite_inverse, closing_walls};
  ContactProblem contact = with_friction(draw, makers[draw.integer(0, 4)]);
  if (draw.chance(1, 4)) change_units(contact, 140, draw);
  return contact;
}

struct Kind {
  const char* name;
  Maker make;
};

constexpr Kind kKinds[] = {{"light-direction", light_direction},
                           {"nearly-dependent", nearly_dependent},
                           {"deficient-factors", deficient_factors},
                           {"semidefinite-inverse", semidefinite_inverse},
                           {"semidefinite-inertia", semidefinite_inertia},
                           {"closing-walls", closing_walls},
                           {"extreme-units", extreme_units},
                           {"round-friction", round_friction}};

}  // namespace

const std::vector<std::string>& doubtful_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

ContactProblem make_doubtful_of_kind(std::size_t kind, Draw& draw) { return kKinds[kind].make(draw); }

}  // namespace lcpbench::attack
