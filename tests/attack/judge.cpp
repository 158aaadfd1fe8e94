#include "tests/attack/judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/answer/lcp_error.h"
#include "study/evaluation/evaluation.h"
#include "tests/attack/truth.h"

namespace lcpbench::attack {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// Numbers of groups of things that belong together.
class Groups {
 public:
  explicit Groups(Index count) : of_(at(count)) { std::iota(of_.begin(), of_.end(), Index{0}); }
  Index of(Index i) const { return of_[at(i)]; }
  void join(Index i, Index j) {
    const Index kept = of(i);
    std::replace(of_.begin(), of_.end(), Index{of(j)}, kept);
  }
  /// The members of every group, each group once.
  std::vector<std::vector<Index>> members() const {
    std::vector<std::vector<Index>> by_number(of_.size());
    for (std::size_t i = 0; i < of_.size(); ++i) by_number[at(of_[i])].push_back(static_cast<Index>(i));
    std::erase_if(by_number, [](const auto& group) { return group.empty(); });
    return by_number;
  }

 private:
  std::vector<Index> of_;
};

/// Joins the rows in which a column of A is not zero.
void join_columns(const DyadicMatrix& A, Index row_offset, Index column_offset, Groups& groups) {
  for (Index j = 0; j < A.cols; ++j) {
    for (Index i = 0; i < A.rows; ++i) {
      if (A(i, j).sign() != 0) groups.join(row_offset + i, column_offset + j);
    }
  }
}

DyadicMatrix coupling(const Inertia& inertia) {
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) return exact(given->Ginv);
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) return exact(factors->X);
  return exact(dense_inertia(inertia));
}

/// What nothing couples to the rest.
struct Part {
  std::vector<Index> coordinates;  ///< contact problems only
  std::vector<Index> rows;
};

/// Coordinates, factors and contacts that nothing couples are apart.
std::vector<Part> islands(const ContactProblem& contact, const ContactLayout& layout) {
  const DyadicMatrix inertia = coupling(contact.inertia);
  const bool factored = std::holds_alternative<FactoredInertia>(contact.inertia);
  const Index ngc = contact.ngc();
  const Index factors = factored ? inertia.cols : 0;
  Groups groups(ngc + factors + layout.size());
  join_columns(inertia, 0, factored ? ngc : 0, groups);
  const Index row = ngc + factors;
  join_columns(exact(to_dense(contact.N)), 0, row, groups);
  join_columns(exact(to_dense(contact.D)), 0, row + layout.friction_offset(), groups);
  if (contact.has_rows()) join_columns(exact(to_dense(contact.rows.R)), 0, row + layout.row_offset(), groups);
  for (Index i = 0; i < layout.rows; ++i) {
    const int of = contact.rows.bounds.friction_of[at(i)];
    if (of >= 0) groups.join(row + layout.row_offset() + i, row + layout.row_offset() + of);
  }
  for (Index c = 0; c < contact.nc(); ++c) {
    for (Index t = layout.friction_begin[at(c)]; t < layout.friction_begin[at(c) + 1]; ++t) {
      groups.join(row + c, row + layout.friction_offset() + t);
    }
    if (layout.lambda[at(c)] >= 0) groups.join(row + c, row + layout.lambda_offset() + layout.lambda[at(c)]);
  }
  std::vector<Part> result(1);  // the first: what no contact moves
  for (const std::vector<Index>& group : groups.members()) {
    const bool moved = group.back() >= row;
    if (moved) result.emplace_back();
    Part& part = moved ? result.back() : result.front();
    for (const Index member : group) {
      if (member < ngc) part.coordinates.push_back(member);
      if (member >= row) part.rows.push_back(member - row);
    }
  }
  return result;
}

/// a / b for b > 0, to 2^-200 of it.
Dyadic divided(const Dyadic& a, const Dyadic& b) {
  return {Integer((a.numerator() << 512) / b.numerator()), a.exponent() - b.exponent() - 512};
}

/// The root of a >= 0 from above, to 2^-120 of it.
Dyadic root(const Dyadic& a) {
  if (a.sign() == 0) return a;
  const long exponent = a.exponent() - 256 - (a.exponent() % 2 != 0 ? 1 : 0);
  return {boost::multiprecision::sqrt(a.over(exponent)) + 1, exponent / 2};
}

/// The largest number that the verdict, which rounds rho and eta to double, takes for `limit`.
Dyadic rounded_to(double limit) { return Dyadic(0.5) * (Dyadic(limit) + Dyadic(std::nextafter(limit, 1.0))); }

DyadicMatrix beside(const DyadicMatrix& A, const DyadicMatrix& B) {
  DyadicMatrix result(A.rows, A.cols + B.cols);
  for (Index i = 0; i < A.rows; ++i) {
    for (Index j = 0; j < A.cols; ++j) result(i, j) = A(i, j);
    for (Index j = 0; j < B.cols; ++j) result(i, A.cols + j) = B(i, j);
  }
  return result;
}

}  // namespace

struct Judge::Data {
  // Bare LCP
  DyadicMatrix M;
  DyadicVector q;
  bool mixed = false;
  LcpBounds bounds;  // of contacts with bounded rows those of z
  std::vector<Part> parts;  // islands or blocks

  // Contact problem
  bool contacts = false;
  ContactLayout layout;
  std::vector<Index> contact_of_friction;
  DyadicMatrix J;         // ngc x impulses: [N D R]
  DyadicVector mu;        // nc
  Inverse response;       // G*
  DyadicVector diagonal;  // M_ii of the impulse rows, times the denominator of G*
  DyadicVector speed;     // of the impulse rows: |J_i'v|
  DyadicVector rounding;  // of the impulse rows: (k + 1) (2^-53 |J_i|'|v| + 2^-1074)
  DyadicVector velocity;  // ngc: before the impact
  DyadicMatrix softness;  // of the impulse rows: r_n, and r_t C'C
  DyadicMatrix G;         // none if only G* is given
  DyadicVector levers;    // of the bounded rows

  /// Where the impulse of a column of J stands in z.
  Index row_of(Index column) const { return column < layout.lambda_offset() ? column : column + layout.cones; }
  bool is_cone(Index row) const { return row >= layout.lambda_offset() && row < layout.row_offset(); }
  /// @pre not a cone
  Index column_of(Index row) const { return row < layout.lambda_offset() ? row : row - layout.cones; }
  DyadicVector impulses(const DyadicVector& z) const {
    DyadicVector f;
    for (Index column = 0; column < J.cols; ++column) f.push_back(z[at(row_of(column))]);
    return f;
  }

  explicit Data(const Problem& problem) {
    if (problem.contact() != nullptr) {
      load(*problem.contact());
      return;
    }
    M = exact(problem.lcp().M);
    q = exact(problem.lcp().q);
    mixed = problem.lcp().is_mixed();
    bounds = problem.lcp().bounds;
    Groups groups(problem.size());
    join_columns(M, 0, 0, groups);
    for (std::vector<Index>& rows : groups.members()) parts.push_back({{}, std::move(rows)});
  }

  /// p_j: the number within the bounds of z_j that is nearest to zero.
  Dyadic nearest_to_zero(Index j) const {
    if (!mixed || bounds.friction_of[at(j)] >= 0) return {};
    return Dyadic(bounds.lower(j) > 0 ? bounds.lower(j) : bounds.upper(j) < 0 ? bounds.upper(j) : 0.0);
  }

  /// The middle one of c (z_i - lower), c (z_i - upper) and w.
  Dyadic violation(Index i, const DyadicVector& z, const Dyadic& c, const Dyadic& w) const {
    const auto within = [&](const Dyadic& lower, const Dyadic& upper) {  // not of friction: lower <= upper
      return max(c * (z[at(i)] - upper), min(w, c * (z[at(i)] - lower)));
    };
    if (!mixed) return min(c * z[at(i)], w);
    if (const int of = bounds.friction_of[at(i)]; of >= 0) {
      const Dyadic limit = abs(Dyadic(bounds.mu(i)) * z[at(of)]);
      return within(-limit, limit);
    }
    const bool has_lower = std::isfinite(bounds.lower(i)), has_upper = std::isfinite(bounds.upper(i));
    if (has_lower && has_upper) return within(Dyadic(bounds.lower(i)), Dyadic(bounds.upper(i)));
    if (has_lower) return min(w, c * (z[at(i)] - Dyadic(bounds.lower(i))));
    return has_upper ? max(w, c * (z[at(i)] - Dyadic(bounds.upper(i)))) : w;
  }

  void load(const ContactProblem& contact) {
    contacts = true;
    layout = contact_layout(contact);
    J = beside(exact(to_dense(contact.N)), exact(to_dense(contact.D)));
    mixed = contact.has_rows();
    if (mixed) J = beside(J, exact(to_dense(contact.rows.R)));
    if (mixed) bounds = bounds_of_impulses(contact);
    mu = exact(contact.mu);
    response = exact_response(contact.inertia);
    if (!std::holds_alternative<InverseInertia>(contact.inertia)) G = exact_inertia(contact.inertia);
    const DyadicVector v = exact(contact.v);
    q.resize(at(layout.size()));
    const DyadicVector velocities = product(transposed(J), v);
    for (Index column = 0; column < J.cols; ++column) {
      speed.push_back(abs(velocities[at(column)]));
      q[at(row_of(column))] = velocities[at(column)];
    }
    for (Index i = 0; i < layout.rows; ++i) {
      q[at(layout.row_offset() + i)] = q[at(layout.row_offset() + i)] + Dyadic(contact.rows.offset(i));
    }
    for (Index i = 0; i < contact.b.size(); ++i) q[at(i)] = q[at(i)] + Dyadic(contact.b(i));
    velocity = v;
    add_softness(contact);
    const DyadicMatrix moved = product(response.numerator, J);
    for (Index i = 0; i < J.cols; ++i) {
      Dyadic square = softness(i, i) * response.denominator;
      Dyadic magnitude;
      double terms = 1;
      for (Index k = 0; k < J.rows; ++k) {
        square = square + J(k, i) * moved(k, i);
        magnitude = magnitude + abs(J(k, i) * v[at(k)]);
        if (J(k, i).sign() != 0) ++terms;
      }
      diagonal.push_back(square);
      rounding.push_back(Dyadic(terms) * (Dyadic(0x1p-53) * magnitude + Dyadic(0x1p-1074)));
    }
    for (Index c = 0; c < layout.nc; ++c) {
      for (Index t = layout.friction_begin[at(c)]; t < layout.friction_begin[at(c) + 1]; ++t) {
        contact_of_friction.push_back(c);
      }
    }
    parts = islands(contact, layout);
    for (Index i = 0; i < layout.rows; ++i) levers.push_back(lever(contact, i, moved));
  }

  /// What turns the residual of a bounded row into m/s. @param moved  G* J, times the denominator of G*
  Dyadic lever(const ContactProblem& contact, Index i, const DyadicMatrix& moved) const {
    const auto along = [&](Index a, Index b) {  // J_a'G*J_b
      Dyadic sum;
      for (Index k = 0; k < J.rows; ++k) sum = sum + J(k, a) * moved(k, b);
      return sum;
    };
    const Index own = column_of(layout.row_offset() + i);
    const Dyadic inertia = along(own, own);
    if (contact.rows.is_angle[at(i)] == 0 || inertia.sign() == 0) return Dyadic(1.0);
    DyadicVector of_moved, of_island, of_rows;
    const auto part = std::find_if(parts.begin(), parts.end(), [&](const Part& candidate) {
      return std::find(candidate.rows.begin(), candidate.rows.end(), layout.row_offset() + i) != candidate.rows.end();
    });
    for (const Index row : part->rows) {
      if (row >= layout.nc && row < layout.row_offset()) continue;
      const Dyadic size = along(column_of(row), column_of(row));
      if (size.sign() == 0) continue;
      if (row >= layout.row_offset()) {
        if (contact.rows.is_angle[at(row - layout.row_offset())] == 0) of_rows.push_back(size);
        continue;
      }
      of_island.push_back(size);
      const Dyadic coupling = along(row, own);
      if ((coupling * coupling - Dyadic(1e-18) * (size * inertia)).sign() > 0) of_moved.push_back(size);
    }
    DyadicVector& sizes = !of_moved.empty() ? of_moved : !of_island.empty() ? of_island : of_rows;
    if (sizes.empty()) return Dyadic(1.0);
    std::sort(sizes.begin(), sizes.end());
    const std::size_t middle = sizes.size() / 2;
    const Dyadic median = sizes.size() % 2 == 1 ? sizes[middle] : Dyadic(0.5) * (sizes[middle - 1] + sizes[middle]);
    return root(divided(median, inertia));
  }

  /// Contacts have 0, 2 or 4 edges: directions along the tangents.
  void add_softness(const ContactProblem& contact) {
    softness = DyadicMatrix(J.cols, J.cols);
    Index first = layout.nc;
    for (Index c = 0; c < layout.nc; ++c) {
      softness(c, c) = Dyadic(contact.normal_compliance(c));
      const int edges = contact.edges[at(c)];
      for (int k = 0; k < edges; ++k) {
        q[at(first + k)] = q[at(first + k)] + slip_offset(contact, c, k);
        const Dyadic r(contact.tangential_compliance(c));
        softness(first + k, first + k) = r;
        softness(first + k, first + (k + edges / 2) % edges) = -r;
      }
      first += edges;
    }
    for (Index i = 0; i < layout.rows; ++i) softness(first + i, first + i) = Dyadic(contact.rows.yields(i));
  }

  /// w times the denominators of z and of G*.
  DyadicVector complement(const DyadicVector& z, const Dyadic& denominator) const {
    if (!contacts) {
      DyadicVector w = product(M, z);
      for (std::size_t i = 0; i < w.size(); ++i) w[i] = w[i] + q[i] * denominator;
      return w;
    }
    const DyadicVector f = impulses(z), moved = product(response.numerator, product(J, f));
    const DyadicVector yielding = product(softness, f);
    DyadicVector w(z.size());
    const Dyadic& of_response = response.denominator;
    for (Index i = 0; i < J.cols; ++i) {
      Dyadic& row = w[at(row_of(i))] = (q[at(row_of(i))] * denominator + yielding[at(i)]) * of_response;
      for (Index k = 0; k < J.rows; ++k) row = row + J(k, i) * moved[at(k)];
    }
    for (Index c = 0; c < layout.cones; ++c) {
      const Index contact = layout.cone_contact[at(c)];
      w[at(layout.lambda_offset() + c)] = mu[at(contact)] * z[at(contact)] * of_response;
    }
    for (Index t = 0; t < layout.friction; ++t) {
      const Index cone = layout.lambda_offset() + layout.lambda[at(contact_of_friction[at(t)])];
      const Index row = layout.friction_offset() + t;
      w[at(row)] = w[at(row)] + z[at(cone)] * of_response;
      w[at(cone)] = w[at(cone)] - z[at(row)] * of_response;
    }
    return w;
  }

  /// What velocity_holds() compares, times the denominator of G*.
  struct Moved {
    DyadicVector velocity;  // v(z)
    DyadicVector bound;
  };

  Moved moved(const DyadicVector& z) const {
    const DyadicVector f = impulses(z);
    DyadicMatrix sizes = J;
    for (Dyadic& entry : sizes.entries) entry = abs(entry);
    DyadicMatrix response_sizes = response.numerator;
    for (Dyadic& entry : response_sizes.entries) entry = abs(entry);
    DyadicVector f_sizes;
    for (const Dyadic& entry : f) f_sizes.push_back(abs(entry));
    Moved result{product(response.numerator, product(J, f)), product(response_sizes, product(sizes, f_sizes))};
    DyadicVector solving(result.velocity.size());  // |G*| |G| |c|, times the denominator of G* as the others are
    DyadicVector change(result.velocity.size());   // c = v(z) - v, rounded to double
    if (G.rows > 0) {
      DyadicMatrix inertia_sizes = G;
      for (Dyadic& entry : inertia_sizes.entries) entry = abs(entry);
      for (std::size_t i = 0; i < change.size(); ++i) {
        change[i] = Dyadic(quotient(abs(result.velocity[i]), response.denominator));
      }
      solving = product(response_sizes, product(inertia_sizes, change));
    }
    for (const Part& part : parts) {
      double terms = 1;
      Dyadic energy;
      for (const Index i : part.coordinates) {
        for (const Index j : part.coordinates) {
          if (G.rows > 0) energy = energy + velocity[at(i)] * G(i, j) * velocity[at(j)];
        }
      }
      Dyadic largest;  // sqrt(G_jj) |c_j|
      for (const Index j : part.coordinates) {
        if (G.rows > 0) largest = max(largest, root(G(j, j)) * change[at(j)]);
      }
      Dyadic pushed = root(energy * response.denominator);  // sqrt(v'G v) + ..., times the denominator's root
      for (const Index j : part.rows) {
        if (is_cone(j) || z[at(j)].sign() == 0) continue;
        ++terms;
        pushed = pushed + root(diagonal[at(column_of(j))]) * f_sizes[at(column_of(j))];
      }
      for (const Index i : part.coordinates) {
        const Dyadic v = velocity[at(i)] * response.denominator;
        const Dyadic size = root(response.numerator(i, i)) * pushed;
        const Dyadic of_terms = Dyadic(0x1p-53) * size + Dyadic(0x1p-1074) * response.denominator;
        Dyadic of_solving = Dyadic(0x1p-53 * static_cast<double>(part.coordinates.size())) * solving[at(i)];
        const Dyadic most = Dyadic(kSolvedVelocityResidual) * largest;
        if (G.rows > 0 && most * response.denominator < of_solving * root(G(i, i))) {
          of_solving = Dyadic(quotient(most, root(G(i, i)))) * response.denominator;  // which may be beyond double
        }
        const Dyadic least = Dyadic(1e-8) * max(response.denominator, root(response.numerator(i, i) * energy * response.denominator));
        const Dyadic tolerance(kSolvedReturnedVelocity);
        result.velocity[at(i)] = result.velocity[at(i)] + v;
        result.bound[at(i)] = max(tolerance * (result.bound[at(i)] + abs(v)) + Dyadic(terms) * of_terms + of_solving,
                                  tolerance * least);
      }
    }
    return result;
  }

  /// What no impulses leave of the convex model's conditions: |P(-w)|, P the nearest point of |f_t| <= mu f_N.
  Dyadic convex_without(Index contact) const {
    const std::size_t row = at(layout.friction_offset() + layout.friction_begin[at(contact)]);
    const Dyadic &slope = mu[at(contact)], aim = -q[at(contact)];
    const Dyadic reach = q[row] * q[row] + q[row + 1] * q[row + 1], square = slope * slope;
    if (aim.sign() >= 0 && reach <= square * aim * aim) return root(aim * aim + reach);
    if (aim.sign() <= 0 && square * reach <= aim * aim) return {};
    return divided(aim + slope * root(reach), root(Dyadic(1.0) + square));
  }

  /// scale_I of an island.
  Dyadic scale(const std::vector<Index>& island, bool convex) const {
    Dyadic scale(1e-8);
    for (const Index i : island) {
      if (is_cone(i)) continue;
      const auto column = at(column_of(i));
      const Dyadic floor =
          max(Dyadic(1e-6) * speed[column], divided(rounding[column], Dyadic(kSolvedVelocityResidual)));
      if (i >= layout.row_offset()) {
        const Dyadic& lever = levers[at(i - layout.row_offset())];
        const Dyadic without = violation(i, DyadicVector(q.size()), diagonal[column], q[at(i)] * response.denominator);
        scale = max(scale, lever * max(floor, divided(abs(without), response.denominator)));
        continue;
      }
      scale = max(scale, floor);
      if (i >= layout.nc) continue;
      scale = max(scale, convex && layout.lambda[at(i)] >= 0 ? convex_without(i) : -q[at(i)]);
    }
    return scale;
  }

  /// A vector along the two tangents of a contact, times the square of the denominator of G*.
  struct Tangential {
    Dyadic first;
    Dyadic second;
    Dyadic square() const { return first * first + second * second; }
  };

  /// Whether | M_tt f_t - P(M_tt f_t - u_t) | <= limit, P the nearest point of the disc of radius mu M_tt max(f_N, 0).
  /// @param w  of complement(): lambda is in its friction rows @param limit  times the square of the denominator of G*
  bool cone_holds(Index contact, const DyadicVector& z, const DyadicVector& w, const Dyadic& limit) const {
    const Index row = layout.friction_offset() + layout.friction_begin[at(contact)];
    const Dyadic& lambda = z[at(layout.lambda_offset() + layout.lambda[at(contact)])];
    const Dyadic& denominator = response.denominator;
    const auto slip = [&](Index k) { return (w[at(row + k)] - lambda * denominator) * denominator; };
    const auto impulse = [&](Index k) { return z[at(row + k)] - z[at(row + k + 2)]; };
    const Dyadic diagonal_tt = max(diagonal[at(row)], diagonal[at(row + 1)]) * denominator;
    const Tangential held{diagonal_tt * impulse(0), diagonal_tt * impulse(1)};
    const Tangential aim{held.first - slip(0), held.second - slip(1)};
    const Dyadic radius = mu[at(contact)] * diagonal_tt * max(z[at(contact)], Dyadic());
    const Dyadic allowed = limit * limit;
    if (aim.square() <= radius * radius) return Tangential{slip(0), slip(1)}.square() <= allowed;
    // |held - radius aim / |aim||^2 <= limit^2, as excess |aim| <= gain
    const Dyadic excess = held.square() + radius * radius - allowed;
    const Dyadic gain = Dyadic(2.0) * radius * (held.first * aim.first + held.second * aim.second);
    const Dyadic left = excess * excess * aim.square();
    const Dyadic right = gain * gain;
    if (excess.sign() <= 0) return gain.sign() >= 0 || right <= left;
    return gain.sign() >= 0 && left <= right;
  }

  /// Whether m | f - P(f - w / m) | <= limit, P the nearest point of the cone |f_t| <= mu f_N, m the larger of M_nn
  /// and M_tt. @param w, limit  as of cone_holds()
  bool convex_holds(Index contact, const DyadicVector& z, const DyadicVector& w, const Dyadic& limit) const {
    const Index row = layout.friction_offset() + layout.friction_begin[at(contact)];
    const Dyadic& lambda = z[at(layout.lambda_offset() + layout.lambda[at(contact)])];
    const Dyadic& denominator = response.denominator;
    const auto slip = [&](Index k) { return (w[at(row + k)] - lambda * denominator) * denominator; };
    const auto impulse = [&](Index k) { return z[at(row + k)] - z[at(row + k + 2)]; };
    const Dyadic m = max(diagonal[at(contact)], max(diagonal[at(row)], diagonal[at(row + 1)])) * denominator;
    const Dyadic normal = w[at(contact)] * denominator, held = m * z[at(contact)], aim = held - normal;
    const Tangential held_t{m * impulse(0), m * impulse(1)};
    const Tangential aim_t{held_t.first - slip(0), held_t.second - slip(1)};
    const Dyadic& slope = mu[at(contact)];
    const Dyadic square = slope * slope, reach = aim_t.square(), allowed = limit * limit;
    if (aim.sign() >= 0 && reach <= square * aim * aim) {
      return normal * normal + Tangential{slip(0), slip(1)}.square() <= allowed;
    }
    if (aim.sign() <= 0 && square * reach <= aim * aim) return held * held + held_t.square() <= allowed;
    // With s = |aim_t|, (1 + mu^2) s (|m f - P|^2 - limit^2) is even + odd s.
    const Dyadic one(1.0), two(2.0);
    const Dyadic along = held_t.first * aim_t.first + held_t.second * aim_t.second;
    const Dyadic even = two * slope * (aim * reach - aim * along - held * reach);
    const Dyadic odd = aim * aim + square * reach - two * aim * held - two * square * along +
                       (one + square) * (held * held + held_t.square() - allowed);
    const Dyadic left = even * even, right = odd * odd * reach;
    if (even.sign() <= 0) return odd.sign() <= 0 || right <= left;
    return odd.sign() <= 0 && left <= right;
  }
};

Judge::Judge(const Problem& problem) : data_(std::make_unique<Data>(problem)) {}
Judge::~Judge() = default;

bool Judge::contacts_solved(const DyadicVector& z, Friction friction) const {
  const Data& data = *data_;
  const Dyadic& denominator = data.response.denominator;
  const Dyadic square = denominator * denominator;
  const DyadicVector w = data.complement(z, Dyadic(1.0));
  const Dyadic tolerance = rounded_to(kSolvedVelocityResidual);
  bool solved = true;
  for (const auto& [coordinates, island] : data.parts) {
    Dyadic residual;
    std::vector<Index> cones;
    for (const Index i : island) {
      Dyadic a;
      Dyadic b;
      if (i >= data.layout.row_offset()) {
        const Dyadic& size = data.diagonal[at(data.column_of(i))];
        const Dyadic left = data.violation(i, z, size * denominator, w[at(i)] * denominator);
        residual = max(residual, data.levers[at(i - data.layout.row_offset())] * abs(left));
        continue;
      }
      if (!data.is_cone(i)) {
        a = data.diagonal[at(i)] * z[at(i)] * denominator;
        b = w[at(i)] * denominator;
      } else {
        const Index contact = data.layout.cone_contact[at(i - data.layout.lambda_offset())];
        a = z[at(i)] * square;
        b = w[at(i)] * data.diagonal[at(contact)];
      }
      const bool convex = friction == Friction::kConvex && i < data.layout.nc && data.layout.lambda[at(i)] >= 0;
      if (!convex && (friction == Friction::kPyramid || i < data.layout.nc)) {
        residual = max(residual, abs(min(a, b)));
      } else if (data.is_cone(i)) {
        cones.push_back(data.layout.cone_contact[at(i - data.layout.lambda_offset())]);
      }
    }
    const Dyadic scale = data.scale(island, friction == Friction::kConvex);
    const Dyadic limit = tolerance * scale * square;
    solved = solved && residual <= limit && std::all_of(cones.begin(), cones.end(), [&](Index contact) {
               return friction == Friction::kConvex ? data.convex_holds(contact, z, w, limit)
                                                    : data.cone_holds(contact, z, w, limit);
             });
    measure_ = std::max(measure_, quotient(residual, scale * square));
  }
  return solved;
}

bool Judge::block_solved(const DyadicVector& z, const std::vector<Index>& block) const {
  struct Row {
    Dyadic w, terms, norm, size;
  };
  const Data& data = *data_;
  std::vector<Row> rows;
  Dyadic largest;        // size
  std::size_t most = 0;  // the row of the largest size / norm
  for (const Index i : block) {
    const Dyadic& q = data.q[at(i)];
    Row row{q, abs(q), {}, abs(q)};
    for (const Index j : block) {
      const Dyadic entry = abs(data.M(i, j));
      row.w = row.w + data.M(i, j) * z[at(j)];
      row.terms = row.terms + entry * abs(z[at(j)]);
      row.norm = row.norm + entry;
      row.size = row.size + entry * abs(data.nearest_to_zero(j));
    }
    if (row.norm.sign() == 0) row.norm = Dyadic(1.0);
    largest = max(largest, row.size);
    rows.push_back(std::move(row));
    if (rows[most].size * rows.back().norm < rows.back().size * rows[most].norm) most = rows.size() - 1;
  }
  const Dyadic tolerance = rounded_to(kSolvedBackwardError), share(kLcpFloorShare);
  bool solved = true;
  for (std::size_t k = 0; k < block.size(); ++k) {
    const Row& row = rows[k];
    const Dyadic violation = abs(data.violation(block[k], z, row.norm, row.w));
    const Dyadic floor = share * largest;
    const Dyadic shared = share * row.norm * rows[most].size, of_shared = violation * rows[most].norm;
    const bool by_floor = violation <= tolerance * floor && of_shared <= tolerance * shared;
    solved = solved && (violation <= tolerance * row.terms || by_floor);
    measure_ = std::max(measure_, std::min(quotient(violation, row.terms),
                                           std::max(quotient(violation, floor), quotient(of_shared, shared))));
  }
  return solved;
}

bool Judge::solves(const Vector& z, Friction friction) const {
  measure_ = 0;
  if (z.size() != static_cast<Index>(data_->q.size()) || !z.allFinite()) {
    measure_ = std::numeric_limits<double>::infinity();
    return false;
  }
  const DyadicVector numbers = exact(z);
  if (data_->contacts) return contacts_solved(numbers, friction);
  bool solved = true;
  for (const Part& block : data_->parts) solved = block_solved(numbers, block.rows) && solved;
  return solved;
}

bool Judge::velocity_holds(const Vector& z, const Vector& u) const {
  if (u.size() != static_cast<Index>(data_->velocity.size()) || !u.allFinite()) return false;
  const Data::Moved moved = data_->moved(exact(z));
  for (Index k = 0; k < u.size(); ++k) {
    const Dyadic error = abs(Dyadic(u(k)) * data_->response.denominator - moved.velocity[at(k)]);
    if (!(error <= moved.bound[at(k)])) return false;
  }
  return true;
}

Vector Judge::velocity(const Vector& z) const {
  const Data::Moved moved = data_->moved(exact(z));
  Vector result(static_cast<Index>(moved.velocity.size()));
  for (Index k = 0; k < result.size(); ++k) {
    const Dyadic& velocity = moved.velocity[at(k)];
    result(k) = (velocity.sign() < 0 ? -1 : 1) * quotient(abs(velocity), data_->response.denominator);
  }
  return result;
}

Vector Judge::beyond_velocity(const Vector& z) const {
  const Data::Moved moved = data_->moved(exact(z));
  Vector result(static_cast<Index>(moved.bound.size()));
  for (Index k = 0; k < result.size(); ++k) {
    result(k) = std::max(2 * quotient(moved.bound[at(k)], data_->response.denominator), 0x1p-1060);
  }
  return result;
}

DyadicMatrix Judge::rows() const {
  const Index n = static_cast<Index>(data_->q.size());
  DyadicMatrix result(n, n + 1);
  const DyadicVector q = data_->complement(DyadicVector(at(n)), Dyadic(1.0));
  for (Index i = 0; i < n; ++i) result(i, 0) = q[at(i)];
  for (Index j = 0; j < n; ++j) {
    DyadicVector unit(at(n));
    unit[at(j)] = Dyadic(1.0);
    const DyadicVector column = data_->complement(unit, Dyadic());
    for (Index i = 0; i < n; ++i) result(i, j + 1) = column[at(i)];
  }
  return result;
}

bool Judge::is_exact_solution(const Integers& numerators, const Integer& denominator) const {
  if (numerators.size() != data_->q.size() || denominator <= 0) return false;
  DyadicVector z;
  for (const Integer& numerator : numerators) z.emplace_back(numerator, 0);
  const DyadicVector w = data_->complement(z, Dyadic(denominator, 0));
  const Dyadic scale(denominator, 0);
  for (std::size_t i = 0; i < z.size(); ++i) {
    std::optional<Dyadic> lower = Dyadic(), upper;
    if (data_->mixed) {
      const double least = data_->bounds.lower(static_cast<Index>(i)), most = data_->bounds.upper(static_cast<Index>(i));
      if (!std::isfinite(least)) lower.reset();
      if (std::isfinite(least)) lower = Dyadic(least) * scale;
      if (std::isfinite(most)) upper = Dyadic(most) * scale;
      if (const int of = data_->bounds.friction_of[i]; of >= 0) {
        upper = Dyadic(data_->bounds.mu(static_cast<Index>(i))) * z[at(of)];
        lower = -*upper;
      }
    }
    if ((lower && z[i] < *lower) || (upper && *upper < z[i])) return false;
    const bool is_above = !lower || *lower < z[i], is_below = !upper || z[i] < *upper;
    if ((is_above && w[i].sign() > 0) || (is_below && w[i].sign() < 0)) return false;
  }
  return true;
}

}  // namespace lcpbench::attack
