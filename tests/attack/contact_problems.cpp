#include <algorithm>
#include <cmath>

#include "tests/attack/problems.h"

namespace lcpbench::attack {
namespace {

/// Contacts in the generator's usual sizes.
ContactProblem contacts(Index least_ngc, Index largest_ngc, Draw& draw) {
  const Index ngc = draw.index(least_ngc, largest_ngc);
  return make_contacts(ngc, draw.index(1, draw.chance(1, 4) ? 8 : 4), 4, draw);
}

/// Rounding may leave A indefinite: then its diagonal grows by units in the last place until the caller's check passes.
Matrix symmetric(Matrix A, Draw& draw) {
  const double growth = draw.chance(1, 2) ? 0 : draw.power_of_two(-53, -44);
  const double largest = A.diagonal().cwiseAbs().maxCoeff();
  for (Index i = 0; i < A.rows(); ++i) {
    for (Index j = 0; j < i; ++j) A(j, i) = A(i, j);
    A(i, i) += growth * largest;
  }
  return A;
}

/// Q diag(2^e) Q' with Q a product of reflections: condition 2^bits.
Matrix with_condition(Index n, int bits, Draw& draw) {
  Matrix Q = Matrix::Identity(n, n);
  for (Index k = 0; k < 2; ++k) {
    Vector x(n);
    for (double& value : x) value = draw.signed_unit();
    const double square = dot(x, x);
    if (!(square > 0)) continue;
    for (Index row = 0; row < n; ++row) {
      const double along = 2 * dot(Q.row(row), x) / square;
      for (Index j = 0; j < n; ++j) Q(row, j) -= along * x(j);
    }
  }
  Matrix scaled = Q;
  for (Index j = 0; j < n; ++j) {
    const bool end = j == 0 || j == n - 1;
    const int exponent = end ? (j == 0 ? 0 : -bits) : -static_cast<int>(draw.integer(0, bits));
    for (Index i = 0; i < n; ++i) scaled(i, j) *= std::ldexp(1.0, exponent);
  }
  return symmetric(product(scaled, Q.transpose()), draw);
}

ContactProblem dense_conditioned(int low_bits, int high_bits, Draw& draw) {
  ContactProblem contact = contacts(2, 8, draw);
  contact.inertia =
      DenseInertia{with_condition(contact.ngc(), static_cast<int>(draw.integer(low_bits, high_bits)), draw)};
  return contact;
}

ContactProblem dense(Draw& draw) { return dense_conditioned(0, 30, draw); }
ContactProblem ill_conditioned(Draw& draw) { return dense_conditioned(30, 46, draw); }
ContactProblem worst_conditioned(Draw& draw) { return dense_conditioned(44, 53, draw); }

/// x x' of small integers, more of them, and next to nothing on the diagonal.
Matrix nearly_singular_matrix(Index n, Draw& draw) {
  const Index rank = draw.chance(2, 3) ? 1 : draw.index(1, n);
  Matrix X(n, rank);
  for (double& x : X.reshaped()) x = static_cast<double>(draw.integer(-9, 9));
  Matrix G = product(X, X.transpose());
  const double size = draw.chance(1, 2) ? 1e-13 : draw.power_of_two(-50, -30);
  for (Index i = 0; i < n; ++i) {
    if (draw.chance(2, 3)) G(i, i) += size * static_cast<double>(draw.integer(1, 9));
    if (draw.chance(1, 2)) G(i, i) = std::nextafter(G(i, i), 1e300);
  }
  return G;
}

ContactProblem nearly_singular(Draw& draw) {
  ContactProblem contact = contacts(2, draw.chance(2, 3) ? 3 : 8, draw);
  contact.inertia = DenseInertia{nearly_singular_matrix(contact.ngc(), draw)};
  return contact;
}

/// R'R with Kahan's triangular R: singular beyond what its pivots show.
ContactProblem kahan(Draw& draw) {
  ContactProblem contact = contacts(3, 8, draw);
  const Index n = contact.ngc();
  const double sine = static_cast<double>(draw.integer(2, 9)) / 10;
  const double cosine = std::sqrt(1 - sine * sine);
  Matrix R = Matrix::Zero(n, n);
  double row_scale = 1;
  for (Index i = 0; i < n; ++i) {
    R(i, i) = row_scale;
    for (Index j = i + 1; j < n; ++j) R(i, j) = -cosine * row_scale;
    row_scale *= sine;
  }
  contact.inertia = DenseInertia{symmetric(product(R.transpose(), R), draw)};
  return contact;
}

/// L L' with unit triangular integers: determinant 1 and entries up to 2^40, exact.
Matrix unimodular(Index n, Draw& draw) {
  const int size = static_cast<int>(draw.integer(1, 1 << draw.integer(1, 20 / static_cast<int>(n))));
  Matrix L = Matrix::Identity(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < i; ++j) L(i, j) = draw.small(size);
  }
  return product(L, L.transpose());
}

ContactProblem integer_inertia(Draw& draw) {
  ContactProblem contact = contacts(2, 8, draw);
  contact.inertia = DenseInertia{unimodular(contact.ngc(), draw)};
  return contact;
}

/// Masses 1e+-12 on the diagonal.
ContactProblem masses(Draw& draw) {
  ContactProblem contact = contacts(1, 8, draw);
  const int bits = draw.chance(1, 4) ? 100 : 40;
  Matrix G = Matrix::Zero(contact.ngc(), contact.ngc());
  for (Index i = 0; i < G.rows(); ++i) G(i, i) = std::abs(draw.mantissa()) * draw.power_of_two(-bits, bits);
  contact.inertia = DenseInertia{G};
  return contact;
}

/// D A D with powers of two: as well conditioned as A once it is scaled.
ContactProblem scaled_coordinates(Draw& draw) {
  ContactProblem contact = contacts(2, 8, draw);
  Matrix G = with_condition(contact.ngc(), static_cast<int>(draw.integer(0, 20)), draw);
  for (Index i = 0; i < G.rows(); ++i) {
    const double unit = draw.power_of_two(-26, 26);
    G.row(i) *= unit;
    G.col(i) *= unit;
  }
  contact.inertia = DenseInertia{G};
  return contact;
}

Matrix block_diagonal(const std::vector<Matrix>& blocks) {
  Index n = 0;
  for (const Matrix& block : blocks) n += block.rows();
  Matrix G = Matrix::Zero(n, n);
  n = 0;
  for (const Matrix& block : blocks) {
    G.block(n, n, block.rows(), block.rows()) = block;
    n += block.rows();
  }
  return G;
}

std::vector<Matrix> random_blocks(Index n, Draw& draw) {
  std::vector<Matrix> blocks;
  while (n > 0) {
    const Index size = draw.index(1, std::min<Index>(n, 3));
    Matrix block = draw.chance(1, 3) && size > 1 ? nearly_singular_matrix(size, draw)
                                                 : with_condition(size, static_cast<int>(draw.integer(0, 45)), draw);
    block *= draw.power_of_two(-30, 30);
    blocks.push_back(std::move(block));
    n -= size;
  }
  return blocks;
}

/// Bodies of very different mass, their contacts anywhere between them.
ContactProblem bodies(Draw& draw) {
  ContactProblem contact = contacts(2, 8, draw);
  contact.inertia = BlockInertia{random_blocks(contact.ngc(), draw)};
  return contact;
}

/// A sum of fewer rank-one terms than coordinates, or as many: some problems have no solution.
ContactProblem factored(Draw& draw) {
  ContactProblem contact = contacts(1, 8, draw);
  const Index terms = draw.index(draw.chance(1, 20) ? 0 : 1, contact.ngc());
  FactoredInertia inertia{Matrix(contact.ngc(), terms), Vector(terms)};
  const bool sparse = draw.chance(1, 2);
  for (double& x : inertia.X.reshaped()) x = sparse && draw.chance(1, 2) ? 0 : draw.small(3);
  for (double& x : inertia.alpha) x = draw.chance(1, 2) ? 1 : draw.power_of_two(-20, 20);
  contact.inertia = inertia;
  return contact;
}

/// Only G* is given: definite, semidefinite or zero.
ContactProblem given_inverse(Draw& draw) {
  ContactProblem contact = contacts(1, 8, draw);
  const Index n = contact.ngc();
  Matrix X(n, draw.index(draw.chance(1, 20) ? 0 : 1, n));
  for (double& x : X.reshaped()) x = draw.small(3);
  Matrix inverse = product(X, X.transpose());
  if (X.cols() == 0) inverse = Matrix::Zero(n, n);
  if (draw.chance(1, 3)) inverse = with_condition(n, static_cast<int>(draw.integer(0, 46)), draw);
  contact.inertia = InverseInertia{inverse};
  return contact;
}

/// A planted push without any mass behind it that v meets by nothing, or by next to nothing: barely unsolvable or not.
ContactProblem barely_solvable(Draw& draw) {
  ContactProblem contact = contacts(2, 6, draw);
  const Index ngc = contact.ngc();
  const Index light = draw.index(0, ngc - 1);
  const Index terms = draw.index(1, ngc);
  FactoredInertia inertia{Matrix(ngc, terms), Vector::Ones(terms)};
  for (double& x : inertia.X.reshaped()) x = draw.small(2);
  inertia.X.row(light).setZero();
  const double speeds[] = {0, 1, -1, -0x1p-52, 0x1p-52, -1e-10, -1e-5, -1e-20, -1e-12, -2e-4};
  contact.v(light) = speeds[draw.integer(0, 9)];
  Matrix N = to_dense(contact.N);
  const Index planted = draw.index(0, N.cols() - 1);
  N.col(planted).setZero();
  if (N.cols() > 1 && draw.chance(1, 2)) {  // two pushes that cancel but for the massless coordinate
    N.col(planted) = -N.col((planted + 1) % N.cols());
    N(light, planted) += 1;
  } else {
    N(light, planted) = 1;
  }
  contact.N = N;
  contact.inertia = inertia;
  if (draw.chance(1, 4)) contact.inertia = InverseInertia{product(inertia.X, inertia.X.transpose())};
  return contact;
}

using Maker = ContactProblem (*)(Draw&);
struct Kind {
  const char* name;
  Maker make;
};

Matrix stacked(const Matrix& A, const Matrix& B) {
  Matrix all = Matrix::Zero(A.rows() + B.rows(), A.cols() + B.cols());
  all.topLeftCorner(A.rows(), A.cols()) = A;
  all.bottomRightCorner(B.rows(), B.cols()) = B;
  return all;
}

/// Problems that nothing couples, of different scale, in one dense G, in one block, or each with its own.
ContactProblem islands(Draw& draw) {
  ContactProblem all;
  std::vector<Matrix> blocks;
  Matrix N(0, 0);
  Matrix D(0, 0);
  const std::int64_t parts = draw.integer(2, 3);
  for (std::int64_t part = 0; part < parts; ++part) {
    const Index ngc = draw.index(1, 3);
    ContactProblem contact = make_contacts(ngc, draw.index(1, 3), 4, draw);
    const double scales[] = {1, 1, 1e-4, 1e-10, 20000, 0x1p-60, 0x1p40, 0};
    contact.v *= scales[draw.integer(0, 7)];
    blocks.push_back(with_condition(ngc, static_cast<int>(draw.integer(0, 46)), draw) * draw.power_of_two(-20, 20));
    N = stacked(N, to_dense(contact.N));
    D = stacked(D, to_dense(contact.D));
    all.edges.insert(all.edges.end(), contact.edges.begin(), contact.edges.end());
    all.mu.conservativeResize(all.mu.size() + contact.mu.size());
    all.mu.tail(contact.mu.size()) = contact.mu;
    all.v.conservativeResize(all.v.size() + ngc);
    all.v.tail(ngc) = contact.v;
  }
  all.N = N;
  all.D = D;
  switch (draw.integer(0, 3)) {
    case 0: all.inertia = DenseInertia{block_diagonal(blocks)}; break;
    case 1: all.inertia = BlockInertia{{block_diagonal(blocks)}}; break;
    case 2: all.inertia = InverseInertia{block_diagonal(blocks)}; break;
    default: all.inertia = BlockInertia{blocks}; break;
  }
  return all;
}

/// No contact, no coordinate, zero velocity, minus zero, denormal velocity.
ContactProblem trivial(Draw& draw) {
  ContactProblem contact = make_contacts(draw.index(0, 2), draw.index(0, 3), 2, draw);
  const Index n = contact.ngc();
  switch (draw.integer(0, 4)) {
    case 0: contact.v.setConstant(-0.0); break;
    case 1: contact.v *= 0x1p-1074; break;
    case 2: contact.v *= 0x1p-1060; break;
    case 3: contact.v *= 0x1p900; break;
    default: break;
  }
  Matrix G = Matrix::Identity(n, n);
  if (draw.chance(1, 2)) G *= draw.power_of_two(-1000, 1000);
  contact.inertia = DenseInertia{G};
  if (draw.chance(1, 3)) contact.inertia = InverseInertia{G};
  return contact;
}

ContactProblem other_units(Draw& draw);

constexpr Kind kKinds[] = {{"dense", dense},
                           {"ill-conditioned", ill_conditioned},
                           {"worst-conditioned", worst_conditioned},
                           {"nearly-singular", nearly_singular},
                           {"kahan", kahan},
                           {"integer-inertia", integer_inertia},
                           {"masses", masses},
                           {"scaled-coordinates", scaled_coordinates},
                           {"bodies", bodies},
                           {"factored", factored},
                           {"given-inverse", given_inverse},
                           {"barely-solvable", barely_solvable},
                           {"islands", islands},
                           {"trivial", trivial},
                           {"other-units", other_units}};

ContactProblem other_units(Draw& draw) {
  ContactProblem contact = kKinds[draw.integer(0, 12)].make(draw);
  change_units(contact, draw.chance(1, 2) ? 30 : 100, draw);
  return contact;
}

}  // namespace

void change_units(ContactProblem& contact, int bits, Draw& draw) {
  const double speed = draw.power_of_two(-bits, bits);
  contact.v *= speed;
  const double length = draw.power_of_two(-bits, bits);
  contact.b *= speed;
  contact.b *= length;
  std::visit([&](auto& J) { J *= length; }, contact.N);
  std::visit([&](auto& J) { J *= length; }, contact.D);
  const double mass = draw.power_of_two(-bits, bits);
  if (auto* given = std::get_if<DenseInertia>(&contact.inertia)) given->G *= mass;
  if (auto* given = std::get_if<InverseInertia>(&contact.inertia)) given->Ginv *= mass;
  if (auto* given = std::get_if<FactoredInertia>(&contact.inertia)) given->alpha *= mass;
  if (auto* given = std::get_if<BlockInertia>(&contact.inertia)) {
    for (Matrix& block : given->blocks) block *= mass;
  }
}

void soften(ContactProblem& contact, Draw& draw) {
  const bool everywhere = draw.chance(1, 3);
  const auto compliance = [&] {
    if (!everywhere && draw.chance(1, 2)) return 0.0;
    return draw.chance(1, 2) ? draw.power_of_two(-40, 40) : std::abs(draw.mantissa()) * draw.power_of_two(-10, 4);
  };
  const bool offsets = draw.chance(1, 3);
  contact.compliance_n = Vector::Zero(contact.nc());
  contact.compliance_t = Vector::Zero(contact.nc());
  contact.offset_t = Vector::Zero(2 * contact.nc());
  for (Index c = 0; c < contact.nc(); ++c) {
    contact.compliance_n(c) = compliance();
    if (contact.edges[static_cast<std::size_t>(c)] == 0) continue;
    contact.compliance_t(c) = compliance();
    for (Index k = 0; offsets && k < 2; ++k) contact.offset_t(2 * c + k) = draw.chance(1, 2) ? 0.0 : draw.signed_unit();
  }
  if (draw.chance(1, 3)) {
    contact.b = Vector::Zero(contact.nc());
    for (double& b : contact.b) b = draw.chance(1, 2) ? 0.0 : draw.signed_unit();
  }
  for (Vector* values : {&contact.compliance_n, &contact.compliance_t, &contact.offset_t}) {
    if (values->isZero(0)) values->resize(0);
  }
}

const std::vector<std::string>& contact_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : kKinds) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

ContactProblem make_contact_of_kind(std::size_t kind, Draw& draw) { return kKinds[kind].make(draw); }

}  // namespace lcpbench::attack
