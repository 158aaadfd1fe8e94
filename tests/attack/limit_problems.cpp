#include <algorithm>
#include <cmath>

#include "tests/attack/problems.h"

// Contact problems at the limits of what 113 bits tell of a reduced rank, and of the scales of the verdict.
namespace lcpbench::attack {
namespace {

using Maker = ContactProblem (*)(Draw&);
struct Kind {
  const char* name;
  Maker make;
};

Vector direction(Index size, Draw& draw) {
  Vector x(size);
  for (double& value : x) value = draw.chance(1, 3) ? draw.small(9) : draw.signed_unit();
  return x;
}

/// Factors within 2^-bits of each other, or of a combination of those before them.
FactoredInertia close_factors(Index ngc, Index count, int bits, Draw& draw) {
  FactoredInertia inertia{Matrix(ngc, count), Vector::Ones(count)};
  const Vector first = direction(ngc, draw);
  for (Index k = 0; k < count; ++k) {
    Vector of = k == 0 ? first : Vector(first + std::ldexp(1.0, -bits) * direction(ngc, draw));
    if (k > 1 && draw.chance(1, 2)) of += draw.small(2) * inertia.X.col(k - 1);
    inertia.X.col(k) = of;
    if (draw.chance(1, 3)) inertia.alpha(k) = draw.power_of_two(-6, 6);
  }
  return inertia;
}

/// Normals that are long, and directions: in the range, almost so, or anywhere.
void lengthen(ContactProblem& contact, const Matrix& X, int bits, Draw& draw) {
  Matrix N = to_dense(contact.N);
  for (Index c = 0; c < N.cols(); ++c) {
    if (draw.chance(1, 4)) continue;
    Vector inside = Vector::Zero(X.rows());
    for (Index k = 0; k < X.cols(); ++k) inside += draw.small(3) * X.col(k);
    if (!inside.isZero(0)) N.col(c) = draw.chance(1, 3) ? inside : Vector(inside + std::ldexp(1.0, -bits) * N.col(c));
    N.col(c) *= draw.chance(1, 3) ? 1 : draw.power_of_two(0, 12);
  }
  contact.N = N;
}

ContactProblem with_close_factors(int largest_edges, Draw& draw) {
  const Index ngc = draw.index(2, 5);
  ContactProblem contact = make_contacts(ngc, draw.index(1, 3), largest_edges, draw);
  const int bits = static_cast<int>(draw.integer(14, 48));
  FactoredInertia inertia = close_factors(ngc, draw.index(2, std::max<Index>(2, ngc - 1)), bits, draw);
  lengthen(contact, inertia.X, bits, draw);
  contact.inertia = std::move(inertia);
  if (draw.chance(1, 2)) {
    contact.b = Vector::Zero(contact.nc());
    for (double& b : contact.b) b = draw.chance(1, 2) ? 0 : draw.signed_unit() * draw.power_of_two(-3, 5);
  }
  return contact;
}

ContactProblem frictionless_factors(Draw& draw) { return with_close_factors(0, draw); }
ContactProblem frictional_factors(Draw& draw) { return with_close_factors(4, draw); }

/// A given G of reduced rank: the sum of such factors' squares, in double.
ContactProblem close_inertia(Draw& draw) {
  const Index ngc = draw.index(2, 4);
  ContactProblem contact = make_contacts(ngc, draw.index(1, 3), 4, draw);
  const int bits = static_cast<int>(draw.integer(4, 24));
  const FactoredInertia inertia = close_factors(ngc, ngc, bits, draw);
  lengthen(contact, inertia.X, bits, draw);
  contact.inertia = DenseInertia{product(inertia.X, inertia.X.transpose())};
  return contact;
}

/// Independent factors, and normals far longer than they, in their range but for rounding.
ContactProblem long_normals(Draw& draw) {
  const Index ngc = draw.index(2, 6);
  ContactProblem contact = make_contacts(ngc, draw.index(1, 4), 4, draw);
  FactoredInertia inertia{Matrix(ngc, draw.index(1, ngc - 1)), {}};
  for (double& x : inertia.X.reshaped()) x = draw.signed_unit();
  inertia.alpha = Vector::Ones(inertia.X.cols());
  lengthen(contact, inertia.X, static_cast<int>(draw.integer(0, 50)), draw);
  std::visit([&](auto& N) { N *= draw.power_of_two(0, 40); }, contact.N);
  contact.inertia = std::move(inertia);
  return contact;
}

constexpr Kind kRankKinds[] = {{"close-factors", frictionless_factors},
                               {"close-factors-friction", frictional_factors},
                               {"close-inertia", close_inertia},
                               {"long-normals", long_normals}};

/// Any kind of contact problem, but for units far from 1.
ContactProblem ordinary(Draw& draw) { return make_contact_of_kind(static_cast<std::size_t>(draw.integer(0, 12)), draw); }

/// Rows that stay open, whatever the others do: their offset is what is left of a gap in a time step.
ContactProblem open_rows(Draw& draw) {
  ContactProblem contact = ordinary(draw);
  const Index nc = contact.nc(), added = draw.index(1, 3);
  Matrix N(contact.ngc(), nc + added);
  N.leftCols(nc) = to_dense(contact.N);
  if (contact.b.size() == 0) contact.b = Vector::Zero(nc);
  contact.b.conservativeResize(nc + added);
  contact.mu.conservativeResize(nc + added);
  for (Index c = nc; c < nc + added; ++c) {
    for (Index i = 0; i < N.rows(); ++i) N(i, c) = draw.signed_unit();
    const double gaps[] = {5, 1e3, 1e6, 1e12};
    contact.b(c) = gaps[draw.integer(0, 3)];
    contact.mu(c) = 0;
    contact.edges.push_back(0);
  }
  contact.N = N;
  return contact;
}

/// Compliance and offsets that are large beside the speeds.
ContactProblem large_offsets(Draw& draw) {
  ContactProblem contact = ordinary(draw);
  soften(contact, draw);
  const double offset = draw.chance(1, 2) ? draw.power_of_two(0, 10) : draw.power_of_two(10, 40);
  contact.offset_t *= offset;
  if (draw.chance(1, 2)) contact.b *= draw.power_of_two(-10, 20);
  if (draw.chance(2, 3)) contact.v *= draw.power_of_two(-50, 0);
  return contact;
}

/// Speeds about the smallest that count.
ContactProblem tiny_speeds(Draw& draw) {
  ContactProblem contact = ordinary(draw);
  contact.v *= draw.power_of_two(-54, -18);
  if (draw.chance(1, 3)) contact.b = contact.v.size() > 0 ? Vector(contact.v(0) * Vector::Ones(contact.nc())) : Vector();
  return contact;
}

/// Bodies that rest but for rounding and a step of gravity along a coordinate.
ContactProblem at_rest(Draw& draw) {
  ContactProblem contact = ordinary(draw);
  for (double& v : contact.v) v = draw.chance(1, 4) ? 0 : draw.signed_unit() * 1e-15;
  if (contact.ngc() > 0) contact.v(draw.index(0, contact.ngc() - 1)) = -0.02;
  return contact;
}

/// Heavy beside light, coupled by the contacts alone.
ContactProblem heavy_and_light(Draw& draw) {
  const Index ngc = draw.index(2, 6);
  ContactProblem contact = make_contacts(ngc, draw.index(1, 4), 4, draw);
  Matrix G = Matrix::Zero(ngc, ngc);
  for (Index i = 0; i < ngc; ++i) G(i, i) = draw.chance(1, 2) ? 1 : draw.power_of_two(10, 40);
  contact.inertia = DenseInertia{G};
  return contact;
}

constexpr Kind kLimitKinds[] = {{"open-rows", open_rows},
                                {"large-offsets", large_offsets},
                                {"tiny-speeds", tiny_speeds},
                                {"at-rest", at_rest},
                                {"heavy-and-light", heavy_and_light}};

template <std::size_t Count>
std::vector<std::string> names_of(const Kind (&kinds)[Count]) {
  std::vector<std::string> names;
  for (const Kind& kind : kinds) names.emplace_back(kind.name);
  return names;
}

}  // namespace

const std::vector<std::string>& rank_kinds() {
  static const std::vector<std::string> names = names_of(kRankKinds);
  return names;
}

const std::vector<std::string>& limit_kinds() {
  static const std::vector<std::string> names = names_of(kLimitKinds);
  return names;
}

ContactProblem make_rank_of_kind(std::size_t kind, Draw& draw) { return kRankKinds[kind].make(draw); }
ContactProblem make_limit_of_kind(std::size_t kind, Draw& draw) { return kLimitKinds[kind].make(draw); }

}  // namespace lcpbench::attack
