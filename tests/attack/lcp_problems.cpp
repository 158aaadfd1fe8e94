#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "tests/attack/problems.h"

namespace lcpbench::attack {
namespace {

Matrix small_matrix(Index n, int size, int zeros_of_ten, Draw& draw) {
  Matrix M(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) M(i, j) = draw.chance(zeros_of_ten, 10) ? 0 : draw.small(size);
  }
  return M;
}

Vector small_vector(Index n, int size, Draw& draw) {
  Vector q(n);
  for (Index i = 0; i < n; ++i) q(i) = draw.small(size);
  return q;
}

/// q of a small complementary solution, with ties: exact where M is small integers.
Vector planted(const Matrix& M, Draw& draw) {
  const Index n = M.rows();
  Vector z = Vector::Zero(n);
  Vector q = Vector::Zero(n);
  for (Index i = 0; i < n; ++i) {
    const auto value = static_cast<double>(draw.integer(0, 3));
    (draw.chance(1, 2) ? z : q)(i) = value;
  }
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) q(i) -= M(i, j) * z(j);
  }
  return q;
}

Vector some_q(const Matrix& M, Draw& draw) {
  return draw.chance(1, 2) ? planted(M, draw) : small_vector(M.rows(), 3, draw);
}

template <class Change>
void change_entries(Lcp& lcp, Draw& draw, Change&& change) {
  for (double& x : lcp.M.reshaped()) {
    if (draw.chance(1, 3)) x = change(x);
  }
  for (double& x : lcp.q) {
    if (draw.chance(1, 3)) x = change(x);
  }
}

/// As it is, or an ulp or the tenth digit away.
void perturb(Lcp& lcp, Draw& draw) {
  switch (draw.integer(0, 3)) {
    case 0: change_entries(lcp, draw, [&](double x) { return draw.neighbour(x); }); break;
    case 1: change_entries(lcp, draw, [&](double x) { return draw.nearly(x, 1e-10); }); break;
    case 2: change_entries(lcp, draw, [&](double x) { return draw.nearly(x, 1e-16); }); break;
    default: break;
  }
}

void scale_rows_and_columns(Lcp& lcp, int bits, Draw& draw) {
  const Index n = lcp.size();
  const bool symmetric = draw.chance(1, 3);
  for (Index i = 0; i < n; ++i) {
    const double row = draw.power_of_two(-bits, bits);
    const double column = symmetric ? row : draw.power_of_two(-bits, bits);
    for (Index j = 0; j < n; ++j) lcp.M(i, j) *= row;
    for (Index j = 0; j < n; ++j) lcp.M(j, i) *= column;
    lcp.q(i) *= row;
  }
}

Lcp small_integers(Draw& draw) {
  const Index n = draw.index(1, 8);
  Lcp lcp{small_matrix(n, static_cast<int>(draw.integer(1, 4)), static_cast<int>(draw.integer(1, 6)), draw), {}};
  lcp.q = some_q(lcp.M, draw);
  return lcp;
}

Lcp ulp_away(Draw& draw) {
  Lcp lcp = small_integers(draw);
  change_entries(lcp, draw, [&](double x) { return draw.neighbour(x); });
  return lcp;
}

Lcp tenth_digit(Draw& draw) {
  Lcp lcp = small_integers(draw);
  const double size = draw.chance(1, 2) ? 1e-10 : 1e-11;
  change_entries(lcp, draw, [&](double x) { return draw.nearly(x, size); });
  return lcp;
}

Lcp near_singular(Draw& draw) {
  const Index n = draw.index(2, 8);
  const Index rank = draw.index(1, n - 1);
  Matrix A(n, rank);
  Matrix B(rank, n);
  for (double& x : A.reshaped()) x = draw.small(3);
  for (double& x : B.reshaped()) x = draw.small(3);
  if (draw.chance(1, 3)) B = Matrix(A.transpose());
  Lcp lcp{product(A, B), {}};
  lcp.q = some_q(lcp.M, draw);
  const double size = draw.power_of_two(-52, -20);
  for (Index i = 0; i < n; ++i) lcp.M(i, i) += draw.chance(1, 2) ? size * draw.small(3) : 0;
  perturb(lcp, draw);
  return lcp;
}

Lcp indefinite(Draw& draw) {
  const Index n = draw.index(2, 8);
  Lcp lcp{Matrix(n, n), Vector(n)};
  for (double& x : lcp.M.reshaped()) x = draw.signed_unit();
  if (draw.chance(1, 2))
    lcp.M =
        Matrix(lcp.M.transpose().triangularView<Eigen::Lower>()) + Matrix(lcp.M.triangularView<Eigen::StrictlyUpper>());
  for (double& x : lcp.q) x = draw.signed_unit();
  return lcp;
}

/// Every entry of another size, between 1e-300 and 1e300 at most.
Lcp extreme_range(Draw& draw) {
  const Index n = draw.index(1, 4);
  const int bits = draw.chance(1, 3) ? 990 : draw.chance(1, 2) ? 400 : 60;
  Lcp lcp{Matrix(n, n), Vector(n)};
  const auto entry = [&](int zeros_of_ten) {
    if (draw.chance(zeros_of_ten, 10)) return 0.0;
    const double value = draw.chance(1, 2) ? draw.sign() : draw.mantissa();
    return value * draw.power_of_two(-bits, bits);
  };
  for (double& x : lcp.M.reshaped()) x = entry(3);
  for (double& x : lcp.q) x = entry(1);
  return lcp;
}

Lcp denormals(Draw& draw) {
  Lcp lcp = small_integers(draw);
  const double matrix_scale = draw.power_of_two(-1074, 0);
  const double vector_scale = draw.power_of_two(-1074, draw.chance(1, 2) ? -1000 : 0);
  if (draw.chance(1, 2)) lcp.M *= matrix_scale;
  lcp.q *= vector_scale;
  if (draw.chance(1, 3)) change_entries(lcp, draw, [&](double) { return 0x1p-1074 * draw.small(3); });
  return lcp;
}

Lcp badly_scaled(Draw& draw) {
  Lcp lcp = draw.chance(1, 2) ? small_integers(draw) : near_singular(draw);
  scale_rows_and_columns(lcp, draw.chance(1, 2) ? 20 : 100, draw);
  perturb(lcp, draw);
  return lcp;
}

/// [P -A'; A Q] with P, Q positive semidefinite or zero.
Lcp game(Draw& draw) {
  const Index n = draw.index(2, 8);
  const Index half = draw.index(1, n - 1);
  Matrix M = small_matrix(n, 2, 4, draw);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) M(j, i) = -M(i, j);
    M(i, i) = draw.chance(1, 4) ? static_cast<double>(draw.integer(0, 2)) : 0;
  }
  for (Index i = 0; i < half; ++i) {
    for (Index j = 0; j < half; ++j) {
      if (i != j) M(i, j) = 0;
    }
  }
  Lcp lcp{M, {}};
  lcp.q = some_q(M, draw);
  perturb(lcp, draw);
  return lcp;
}

Matrix gram(Index n, Index rank, int size, Draw& draw) {
  Matrix A(n, rank);
  for (double& x : A.reshaped()) x = draw.small(size);
  return product(A, A.transpose());
}

Lcp semidefinite(Draw& draw) {
  const Index n = draw.index(2, 8);
  Lcp lcp{gram(n, draw.index(1, n), 3, draw), {}};
  if (draw.chance(1, 2)) {
    const Matrix S = small_matrix(n, 2, 4, draw);
    lcp.M += Matrix(S - S.transpose());
  }
  lcp.q = some_q(lcp.M, draw);
  perturb(lcp, draw);
  return lcp;
}

/// Triangular with a positive diagonal, its rows and columns in another order: a P-matrix; negated an N-like one.
Lcp p_or_n_matrix(Draw& draw) {
  const Index n = draw.index(1, 8);
  Matrix M = small_matrix(n, 3, 2, draw).triangularView<Eigen::Lower>();
  for (Index i = 0; i < n; ++i) M(i, i) = static_cast<double>(draw.integer(1, 3));
  if (draw.chance(1, 3)) M = -M;
  if (draw.chance(1, 3)) M = Matrix(M.transpose());
  Lcp lcp{M, {}};
  lcp.q = some_q(M, draw);
  perturb(lcp, draw);
  return lcp;
}

Lcp copositive(Draw& draw) {
  const Index n = draw.index(2, 8);
  Matrix M = gram(n, draw.index(1, 3), 2, draw);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) M(i, j) += draw.chance(1, 3) ? static_cast<double>(draw.integer(0, 3)) : 0;
  }
  Lcp lcp{M, {}};
  lcp.q = some_q(M, draw);
  perturb(lcp, draw);
  return lcp;
}

/// A planted y >= 0 with M'y <= 0 and q'y negative, zero or positive by little or nothing: infeasible or barely not.
Lcp barely_feasible(Draw& draw) {
  const Index n = draw.index(2, 8);
  Lcp lcp{small_matrix(n, 3, 3, draw), small_vector(n, 3, draw)};
  const Index last = draw.index(0, n - 1);
  const double margin[] = {0, 0, 1, 0x1p-52, -0x1p-52, 1e-10, -1e-10, 1e-20, 1e-9, 1e-8};
  lcp.M.row(last).setZero();
  lcp.q(last) = 0;
  for (Index i = 0; i < n; ++i) {
    if (i == last) continue;
    const auto y = static_cast<double>(draw.integer(0, 3));
    for (Index j = 0; j < n; ++j) lcp.M(last, j) -= y * lcp.M(i, j);
    lcp.q(last) -= y * lcp.q(i);
  }
  for (Index j = 0; j < n; ++j) {
    if (draw.chance(1, 3)) lcp.M(last, j) -= static_cast<double>(draw.integer(0, 2));
  }
  lcp.q(last) -= margin[draw.integer(0, 9)];
  perturb(lcp, draw);
  return lcp;
}

/// Singular small blocks of one sign pattern in an otherwise feasible problem: degenerate bases with singular blocks.
Lcp degenerate_basis(Draw& draw) {
  const Index n = draw.index(3, 8);
  Lcp lcp{small_matrix(n, 2, 5, draw), {}};
  const Index twin = draw.index(1, n - 1);
  const double factor = draw.sign() * static_cast<double>(draw.integer(1, 2));
  for (Index j = 0; j < n; ++j) lcp.M(twin, j) = factor * lcp.M(0, j);
  lcp.q = planted(lcp.M, draw);
  lcp.q(twin) += draw.chance(1, 2) ? draw.small(1) : 0;
  perturb(lcp, draw);
  return lcp;
}

/// (q, M) of frictional contacts with small integers: exact, singular, copositive.
Lcp frictional(Draw& draw) {
  const ContactProblem contact = make_contacts(draw.index(1, 4), draw.index(1, 2), 2, draw);
  const ContactLayout layout = contact_layout(contact);
  const Index impulses = layout.nc + layout.friction;
  Matrix J(contact.ngc(), impulses);
  J << to_dense(contact.N), to_dense(contact.D);
  const Index n = layout.size();
  Lcp lcp{Matrix::Zero(n, n), Vector::Zero(n)};
  Matrix scaled = J;
  for (Index k = 0; k < J.rows(); ++k) {
    const double inverse_mass = draw.chance(1, 2) ? 1 : draw.power_of_two(-20, 20);
    for (Index j = 0; j < J.cols(); ++j) scaled(k, j) *= inverse_mass;
  }
  lcp.M.topLeftCorner(impulses, impulses) = product(J.transpose(), scaled);
  for (Index i = 0; i < impulses; ++i) lcp.q(i) = dot(J.col(i), contact.v);
  for (Index c = 0; c < layout.nc; ++c) {
    const Index lambda = layout.lambda[static_cast<std::size_t>(c)];
    if (lambda < 0) continue;
    lcp.M(layout.lambda_offset() + lambda, c) = contact.mu(c);
    for (Index t = layout.friction_begin[static_cast<std::size_t>(c)];
         t < layout.friction_begin[static_cast<std::size_t>(c) + 1]; ++t) {
      lcp.M(layout.friction_offset() + t, layout.lambda_offset() + lambda) = 1;
      lcp.M(layout.lambda_offset() + lambda, layout.friction_offset() + t) = -1;
    }
  }
  perturb(lcp, draw);
  return lcp;
}

/// 0, -0, 1, the least and the largest doubles; n = 0 and 1 are frequent.
Lcp edges_of_the_type(Draw& draw) {
  const Index n = draw.chance(1, 8) ? 0 : draw.index(1, 3);
  const double values[] = {0,
                           -0.0,
                           1,
                           -1,
                           1,
                           -1,
                           0x1p-1074,
                           -0x1p-1074,
                           0x1p-1022,
                           0x1.fffffffffffffp-1023,
                           0x1p1000,
                           -0x1p1000,
                           0x1.fffffffffffffp1023,
                           -0x1.fffffffffffffp1023,
                           1e-300,
                           1e20};
  const std::int64_t last = draw.chance(1, 2) ? 5 : 15;
  Lcp lcp{Matrix(n, n), Vector(n)};
  for (double& x : lcp.M.reshaped()) x = values[draw.integer(0, last)];
  for (double& x : lcp.q) x = values[draw.integer(0, last)];
  return lcp;
}

using Maker = Lcp (*)(Draw&);
struct Kind {
  const char* name;
  Maker make;
};

Lcp blocks(Draw& draw);

constexpr Kind kKinds[] = {{"small-integers", small_integers},
                           {"ulp-away", ulp_away},
                           {"tenth-digit", tenth_digit},
                           {"near-singular", near_singular},
                           {"indefinite", indefinite},
                           {"game", game},
                           {"semidefinite", semidefinite},
                           {"p-or-n-matrix", p_or_n_matrix},
                           {"copositive", copositive},
                           {"barely-feasible", barely_feasible},
                           {"degenerate-basis", degenerate_basis},
                           {"frictional", frictional},
                           {"extreme-range", extreme_range},
                           {"denormals", denormals},
                           {"badly-scaled", badly_scaled},
                           {"blocks", blocks},
                           {"edges-of-the-type", edges_of_the_type}};

/// Several problems that nothing couples, of different scale, in a random order.
Lcp blocks(Draw& draw) {
  Lcp all{Matrix(0, 0), Vector(0)};
  for (int block = 0; block < 3; ++block) {
    const Lcp part = kKinds[draw.integer(0, 11)].make(draw);
    const Index before = all.size();
    const Index n = before + part.size();
    if (n > 8) continue;
    const double matrix_scale = draw.chance(1, 2) ? 1 : draw.power_of_two(-40, 40);
    const double vector_scale = draw.chance(1, 2) ? 1 : draw.power_of_two(-40, 40);
    Lcp joined{Matrix::Zero(n, n), Vector(n)};
    joined.M.topLeftCorner(before, before) = all.M;
    joined.M.bottomRightCorner(part.size(), part.size()) = part.M * matrix_scale;
    joined.q.head(before) = all.q;
    joined.q.tail(part.size()) = part.q * vector_scale;
    all = std::move(joined);
  }
  std::vector<Index> order(static_cast<std::size_t>(all.size()));
  std::iota(order.begin(), order.end(), Index{0});
  for (Index i = all.size() - 1; i > 0; --i) {
    std::swap(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(draw.index(0, i))]);
  }
  return {Matrix(all.M(order, order)), Vector(all.q(order))};
}

}  // namespace

const std::vector<std::string>& lcp_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

Lcp make_lcp_of_kind(std::size_t kind, Draw& draw) { return kKinds[kind].make(draw); }

/// One of that kind, with other bounds.
Lcp make_mixed_of_kind(std::size_t kind, Draw& draw) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Lcp lcp = make_lcp_of_kind(kind, draw);
  while (lcp.size() == 0 || lcp.size() > 4) lcp = make_lcp_of_kind(kind, draw);
  const Index n = lcp.size();
  lcp.bounds = LcpBounds::nonnegative(n);
  const int bits = draw.chance(3, 4) ? 0 : draw.chance(3, 4) ? 30 : 900;
  const auto bound = [&] {
    const double size = draw.small(3);
    return size * draw.power_of_two(-bits, bits);
  };
  for (Index i = 0; i < n; ++i) {
    double &lower = lcp.bounds.lower(i), &upper = lcp.bounds.upper(i);
    switch (draw.integer(0, 4)) {
      case 0: lower = -kNone; break;
      case 1: lower = bound(); break;
      case 2: lower = -kNone, upper = bound(); break;
      case 3: std::tie(lower, upper) = std::minmax({bound(), bound()}); break;
      default: break;
    }
  }
  const Index of = draw.index(0, n - 1);
  const bool has_friction = draw.chance(1, 3);
  if (has_friction && lcp.bounds.upper(of) >= 0) lcp.bounds.lower(of) = std::max(lcp.bounds.lower(of), 0.0);
  for (Index i = 0; has_friction && lcp.bounds.lower(of) >= 0 && i < n; ++i) {
    if (i == of || draw.chance(1, 3)) continue;
    lcp.bounds.lower(i) = -kNone;
    lcp.bounds.upper(i) = kNone;
    lcp.bounds.friction_of[static_cast<std::size_t>(i)] = static_cast<int>(of);
    lcp.bounds.mu(i) = std::abs(bound()) / 2;
  }
  lcp.bounds.simplify();
  return lcp;
}

}  // namespace lcpbench::attack
