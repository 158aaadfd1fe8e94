#include "core/compliance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/added_coordinates.h"

namespace lcpbench {
namespace {

using Entries = AddedCoordinates::Entries;

/// The coordinate that gives way by r f: its entry of J and its inertia, about `mass`. entry^2 / inertia is r exactly.
struct Yielding {
  Yielding(double r, double mass) {
    const int half = (std::ilogb(mass) - std::ilogb(r)) / 2;
    entry = std::ldexp(r, half);
    inertia = std::ldexp(r, 2 * half);
  }
  double entry, inertia;
};

double unit_at(double size) { return std::ldexp(1.0, std::ilogb(size)); }

/// As large as any mass that the inertia has. Where only G* is given, the least that its diagonal shows.
double largest_mass(const Inertia& inertia) {
  double largest = 0;
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    for (Index i = 0; i < factors->X.rows(); ++i) {
      largest = std::max(largest, factors->X.row(i).cwiseAbs2().dot(factors->alpha));
    }
  } else if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) {
    if (inverse->Ginv.rows() > 0) largest = 1 / inverse->Ginv.diagonal().maxCoeff();
  } else {
    for_each_matrix(inertia, [&](const Matrix& G, Index) {
      if (G.rows() > 0) largest = std::max(largest, G.diagonal().maxCoeff());
    });
  }
  return std::isnormal(largest) ? largest : 1.0;
}

/// The smallest of the largest entries of these columns that have any; 1 where none has.
double least_size(const Jacobian& J, Index begin, Index end) {
  double least = std::numeric_limits<double>::infinity();
  for (Index column = begin; column < end; ++column) {
    double size = 0;
    for_each_entry(J, column, [&](Index, double entry) { size = std::max(size, std::abs(entry)); });
    if (size > 0) least = std::min(least, size);
  }
  return std::isfinite(least) ? least : 1.0;
}

/// Two edges go along the first tangent alone.
bool has_coordinate(const ContactProblem& problem, Index contact, int tangent) {
  const int edges = problem.edges[static_cast<std::size_t>(contact)];
  const bool acts = problem.tangential_compliance(contact) != 0 || problem.tangential_offset(contact, tangent) != 0;
  return acts && edges > 0 && (edges > 2 || tangent == 0);
}

}  // namespace

std::array<double, 2> edge_direction(Index k, Index edges) {
  const double sign = 2 * k < edges ? 1.0 : -1.0;
  if (2 * k >= edges) k -= edges / 2;
  if (k == 0) return {sign, 0.0};
  if (4 * k == edges) return {0.0, sign};
  const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges);
  const auto rounded = [](double x) { return std::nearbyint(std::ldexp(x, 40)) * 0x1p-40; };
  return {sign * rounded(std::cos(angle)), sign * rounded(std::sin(angle))};
}

bool every_contact_yields(const ContactProblem& problem) {
  return problem.nc() > 0 && problem.compliance_n.size() > 0 && (problem.compliance_n.array() > 0).all() &&
         problem.compliance_n.allFinite() && problem.offset_t.allFinite() &&
         problem.compliance_t.allFinite() && (problem.compliance_t.array() >= 0).all();
}

void select_softness(const ContactProblem& from, const std::vector<Index>& contacts, ContactProblem& to) {
  const auto select = [&](const Vector& values, Index each) -> Vector {
    if (values.size() == 0) return {};
    return values.reshaped(each, values.size() / each)(Eigen::all, contacts).reshaped();
  };
  to.compliance_n = select(from.compliance_n, 1);
  to.compliance_t = select(from.compliance_t, 1);
  to.offset_t = select(from.offset_t, 2);
}

ContactProblem rigid_equivalent(const ContactProblem& problem) {
  if (!problem.is_soft()) return problem;
  AddedCoordinates added(problem);
  const double mass = largest_mass(problem.inertia);
  Entries normal, friction;
  Index column = 0;
  for (Index contact = 0; contact < problem.nc(); ++contact) {
    const Index edges = problem.edges[static_cast<std::size_t>(contact)];
    const auto add = [&](Entries& to, Index coordinate, Index of, double entry) {
      if (entry != 0) to.emplace_back(coordinate, of, entry);
    };
    if (const double r = problem.normal_compliance(contact); r != 0) {
      const Yielding own(r, mass);
      add(normal, added.add(own.inertia, 0), contact, own.entry);
    }
    const double r = problem.tangential_compliance(contact);
    Yielding own(r != 0 ? r : 1.0, mass);
    if (r == 0) {  // A tangential offset alone has a coordinate that impulses move by less than the rounding of M.
      own.entry = std::ldexp(unit_at(least_size(problem.D, column, column + edges)), -25);
      // Nothing bounds the mass behind a given G*: this one is infinite there.
      const bool is_given = std::holds_alternative<InverseInertia>(problem.inertia);
      own.inertia = is_given ? std::numeric_limits<double>::infinity() : mass;
    }
    for (const int tangent : {0, 1}) {
      if (!has_coordinate(problem, contact, tangent)) continue;
      const Index coordinate = added.add(own.inertia, problem.tangential_offset(contact, tangent) / own.entry);
      for (Index k = 0; k < edges; ++k) {
        add(friction, coordinate, column + k, own.entry * edge_direction(k, edges)[static_cast<std::size_t>(tangent)]);
      }
    }
    column += edges;
  }
  ContactProblem rigid;
  rigid.v = added.velocity(problem.v);
  rigid.N = added.jacobian(problem.N, cols(problem.N), std::move(normal));
  rigid.D = added.jacobian(problem.D, cols(problem.D), std::move(friction));
  rigid.edges = problem.edges;
  rigid.mu = problem.mu;
  rigid.inertia = added.inertia(problem.inertia);
  rigid.b = problem.b;
  return rigid;
}

}  // namespace lcpbench
