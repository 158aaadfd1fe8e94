#include "study/evaluation/cone_friction.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/round_cone.h"
#include "core/selection.h"
#include "study/evaluation/measures.h"

namespace lcpbench {
namespace {

Quad length_of(Quad a, Quad b) { return sqrt(a * a + b * b); }

Quad finite_or_infinity(Quad x) { return is_finite(x) ? x : Quad{std::numeric_limits<double>::infinity()}; }

}  // namespace

Quad ConeFriction::Tangential::length() const { return length_of(first, second); }

std::string why_no_cone(const ContactProblem& problem) {
  std::vector<Index> in_space;
  for (Index i = 0; i < problem.nc(); ++i) {
    if (problem.edges[static_cast<std::size_t>(i)] != 2) in_space.push_back(i);
  }
  return why_no_round_cone(std::ssize(in_space) == problem.nc() ? problem : select_contacts(problem, in_space));
}

ConeFriction::ConeFriction(const ContactProblem& problem, ContactLcp& lcp)
    : problem_(problem), layout_(lcp.layout()), lcp_(lcp) {}

std::size_t ConeFriction::direction(Index contact, Index k) const {
  return static_cast<std::size_t>(layout_.friction_offset() +
                                  layout_.friction_begin[static_cast<std::size_t>(contact)] + k);
}

ConeFriction::Tangential ConeFriction::impulse_of(Index contact, const QuadVector& z) const {
  Tangential sum;
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
    sum.first += f * Quad(std::cos(angle));
    sum.second += f * Quad(std::sin(angle));
  }
  return sum;
}

/// Not from w, in which a large lambda hides it.
ConeFriction::Tangential ConeFriction::relative_slip(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Quad along_second = edges(contact) > 2 ? lcp_.velocity(second(contact), z, u) : Quad{0};  // in the plane: none
  return {lcp_.velocity(direction(contact, 0), z, u), along_second};
}

/// M_tt
Quad ConeFriction::diagonal(Index contact) const {
  return larger(lcp_.diagonal(direction(contact, 0)), lcp_.diagonal(second(contact)));
}

Quad ConeFriction::convex_residual(Index contact, const QuadVector& z, const QuadVector& u) const {
  const auto row = static_cast<std::size_t>(contact);
  const Quad m = larger(lcp_.diagonal(row), diagonal(contact));
  const Quad mu = problem_.mu(contact);
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, z, u);
  const Quad scaled = m * z[row], w = lcp_.velocity(row, z, u), trial_normal = scaled - w;
  if (mu == 0) {  // as below, but does not cancel w where m is huge
    return finite_or_infinity(length_of(smaller(scaled, w), Tangential{m * f.first, m * f.second}.length()));
  }
  const Tangential trial{m * f.first - slip.first, m * f.second - slip.second};
  const Quad trial_size = trial.length();
  if (trial_normal >= 0 && mu * trial_normal >= trial_size) return finite_or_infinity(length_of(w, slip.length()));
  const Quad height = larger((trial_normal + mu * trial_size) / (1 + mu * mu), Quad{0});
  const Quad share = quotient(mu * height, trial_size);
  const Tangential missing{m * f.first - share * trial.first, m * f.second - share * trial.second};
  return finite_or_infinity(length_of(scaled - height, missing.length()));
}

void ConeFriction::describe(Index contact, const QuadVector& z, const QuadVector& u, WorstRow& worst) const {
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, z, u);
  worst.slip = to_double(slip.length());
  worst.separation = to_double(lcp_.velocity(static_cast<std::size_t>(contact), z, u));
  worst.normal = to_double(normal(contact, z));
  worst.friction = to_double(f.length());
  worst.opposing = -to_double(quotient(f.first * slip.first + f.second * slip.second, f.length() * slip.length()));
}

Quad ConeFriction::lack(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Tangential slip = relative_slip(contact, z, u);
  return Quad(problem_.mu(contact)) * slip.length() - lcp_.velocity(static_cast<std::size_t>(contact), z, u);
}

Quad ConeFriction::work(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, z, u);
  return normal(contact, z) * lcp_.velocity(static_cast<std::size_t>(contact), z, u) + f.first * slip.first + f.second * slip.second;
}

Quad ConeFriction::residual(Index contact, const QuadVector& z, const QuadVector& u) const {
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, z, u);
  if (f.first == 0 && f.second == 0 && !(normal(contact, z) > 0)) return 0;  // whatever M_tt is, which takes a solve
  const Quad m = diagonal(contact);
  const Tangential scaled{m * f.first, m * f.second};
  const Tangential trial{scaled.first - slip.first, scaled.second - slip.second};
  const Quad radius = Quad(problem_.mu(contact)) * m * larger(normal(contact, z), Quad{0});
  const Quad length = trial.length(), shrink = length > radius ? radius / length : Quad{1};
  return finite_or_infinity(
      Tangential{scaled.first - shrink * trial.first, scaled.second - shrink * trial.second}.length());
}

Quad ConeFriction::slack(Index contact, const QuadVector& z) const {
  return Quad(problem_.mu(contact)) * normal(contact, z) - impulse_of(contact, z).length();
}

}  // namespace lcpbench
