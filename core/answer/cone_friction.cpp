#include "core/answer/cone_friction.h"

#include <cmath>
#include <numbers>

#include "core/answer/measures.h"
#include "core/round_cone.h"
#include "core/selection.h"

namespace lcpbench {

std::string why_no_cone(const ContactProblem& problem) {
  std::vector<Index> in_space;
  for (Index i = 0; i < problem.nc(); ++i) {
    if (problem.edges[static_cast<std::size_t>(i)] != 2) in_space.push_back(i);
  }
  return why_no_round_cone(std::ssize(in_space) == problem.nc() ? problem : select_contacts(problem, in_space));
}

ConeFriction::Vector2 ConeFriction::impulse(Index contact, const QuadVector& z) const {
  Vector2 sum;
  for (Index k = 0; k < edges(contact); ++k) {
    const Quad f = z[direction(contact, k)];
    if (f == 0) continue;
    const Index quarters = 4 * k / edges(contact);
    if (quarters * edges(contact) == 4 * k) {  // exact: along a tangent
      (quarters % 2 == 0 ? sum.first : sum.second) += quarters < 2 ? f : -f;
      continue;
    }
    // Not rounded to 2^-40 as edge_direction(): the directions of a file may be a regular polygon to all digits.
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges(contact));
    sum.first += f * Quad{std::cos(angle)};
    sum.second += f * Quad{std::sin(angle)};
  }
  return sum;
}

/// Not from w, in which a large lambda hides it.
ConeFriction::Vector2 ConeFriction::slip(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Quad along_second = edges(contact) > 2 ? lcp_.velocity(second(contact), z, u) : Quad{0};  // in the plane: none
  return {lcp_.velocity(direction(contact, 0), z, u), along_second};
}

/// M_tt
Quad ConeFriction::diagonal(Index contact) const {
  return larger(lcp_.diagonal(direction(contact, 0)), lcp_.diagonal(second(contact)));
}

Quad ConeFriction::convex_residual(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Quad m = larger(lcp_.diagonal(static_cast<std::size_t>(contact)), diagonal(contact));
  return finite_or_infinity(lcpbench::convex_residual<Quad>(m, Quad{problem_.mu(contact)}, normal(contact, z),
                                                            separation(contact, z, u), impulse(contact, z),
                                                            slip(contact, z, u)));
}

Quad ConeFriction::residual(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Vector2 f = impulse(contact, z);
  if (f.first == 0 && f.second == 0 && !(normal(contact, z) > 0)) return 0;  // whatever M_tt is, which takes a solve
  return finite_or_infinity(friction_residual<Quad>(diagonal(contact), Quad{problem_.mu(contact)}, normal(contact, z),
                                                    f, slip(contact, z, u)));
}

}  // namespace lcpbench
