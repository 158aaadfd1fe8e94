#include "study/evaluation/cone_friction.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

namespace lcpbench {
namespace {

/// The factor that takes a vector of this length to the nearest point of the disc of this radius around 0.
Quad shrinking(Quad radius, Quad length) { return length > radius ? radius / length : Quad{1}; }

/// Where the length may be zero, an interval that contains [0, 1]: the error bound of the scaled vector is then about
/// as large as the vector.
Bounded shrinking(const Bounded& radius, const Bounded& length) {
  const Bounded shrink = smaller(1.0, quotient(radius, length));
  return is_finite(shrink) ? shrink : Bounded{0.5, 0, 0.5};
}

Quad length_of(Quad a, Quad b) { return sqrt(a * a + b * b); }

Quad finite_or_infinity(Quad x) { return is_finite(x) ? x : Quad{std::numeric_limits<double>::infinity()}; }

Bounded finite_or_infinity(const Bounded& x) {
  if (!is_finite(x)) throw Doubt();
  return x;
}

/// Where the length may be zero, an interval that contains 0 and the sum of the largest possible magnitudes.
Bounded length_of(const Bounded& a, const Bounded& b) {
  const Bounded length = sqrt(a * a + b * b);
  if (is_finite(length)) return length;
  return {0, 0, std::abs(a.high) + std::abs(b.high) + 2 * (a.error + b.error)};
}

}  // namespace

template <class Real>
Real ConeFriction<Real>::Tangential::length() const {
  return length_of(first, second);
}

template <class Real>
ConeFriction<Real>::ConeFriction(const ContactProblem& problem, ContactLcp<Real>& lcp)
    : problem_(problem), layout_(lcp.layout()), lcp_(lcp) {}

template <class Real>
std::size_t ConeFriction<Real>::direction(Index contact, Index k) const {
  return static_cast<std::size_t>(layout_.friction_offset() +
                                  layout_.friction_begin[static_cast<std::size_t>(contact)] + k);
}

template <class Real>
bool ConeFriction<Real>::impulse_free(Index contact, const RealVector& z) const {
  if (!surely_equal(normal(contact, z), 0)) return false;
  for (Index k = 0; k < edges(contact); ++k) {
    if (!surely_equal(z[direction(contact, k)], 0)) return false;
  }
  return true;
}

template <class Real>
typename ConeFriction<Real>::Tangential ConeFriction<Real>::impulse_of(Index contact, const RealVector& z) const {
  Tangential sum;
  for (Index k = 0; k < edges(contact); ++k) {
    const Real f = z[direction(contact, k)];
    if (surely_equal(f, 0)) continue;
    const Index quarters = 4 * k / edges(contact);
    if (quarters * edges(contact) == 4 * k) {  // exact: along a tangent
      (quarters % 2 == 0 ? sum.first : sum.second) += quarters < 2 ? f : -f;
      continue;
    }
    // Not rounded to 2^-40 as edge_direction(): the directions of a file may be a regular polygon to all digits.
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges(contact));
    sum.first += f * Real(std::cos(angle));
    sum.second += f * Real(std::sin(angle));
  }
  return sum;
}

template <class Real>
typename ConeFriction<Real>::Tangential ConeFriction<Real>::slip_of(Index contact, const RealVector& u) const {
  return {lcp_.project(direction(contact, 0), u), lcp_.project(direction(contact, edges(contact) / 4), u)};
}

template <class Real>
typename ConeFriction<Real>::Tangential ConeFriction<Real>::relative_slip(Index contact, const Tangential& f,
                                                                          const RealVector& u) const {
  Tangential slip = slip_of(contact, u);
  if (!problem_.is_soft()) return slip;
  const Real compliance(problem_.tangential_compliance(contact));
  slip.first += Real(problem_.tangential_offset(contact, 0)) + compliance * f.first;
  slip.second += Real(problem_.tangential_offset(contact, 1)) + compliance * f.second;
  return slip;
}

/// M_tt
template <class Real>
Real ConeFriction<Real>::diagonal(Index contact) const {
  return larger(lcp_.diagonal(direction(contact, 0)), lcp_.diagonal(direction(contact, edges(contact) / 4)));
}

template <class Real>
Real ConeFriction<Real>::convex_residual(Index contact, const RealVector& z, const RealVector& u) const
  requires std::is_same_v<Real, Quad>
{
  const auto row = static_cast<std::size_t>(contact);
  const Quad m = larger(lcp_.diagonal(row), diagonal(contact));
  const Quad mu = problem_.mu(contact);
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, f, u);
  const Quad scaled = m * z[row], w = lcp_.row(row, z, u), trial_normal = scaled - w;
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

template <class Real>
void ConeFriction<Real>::describe(Index contact, const RealVector& z, const RealVector& u, WorstRow& worst) const
  requires std::is_same_v<Real, Quad>
{
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, f, u);
  worst.slip = to_double(slip.length());
  worst.separation = to_double(lcp_.row(static_cast<std::size_t>(contact), z, u));
  worst.normal = to_double(normal(contact, z));
  worst.friction = to_double(f.length());
  worst.opposing = -to_double(quotient(f.first * slip.first + f.second * slip.second, f.length() * slip.length()));
}

template <class Real>
Real ConeFriction<Real>::lack(Index contact, const RealVector& z, const RealVector& u) const {
  const Tangential slip = relative_slip(contact, impulse_of(contact, z), u);
  return Real(problem_.mu(contact)) * slip.length() - lcp_.row(static_cast<std::size_t>(contact), z, u);
}

template <class Real>
Real ConeFriction<Real>::work(Index contact, const RealVector& z, const RealVector& u) const {
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, f, u);
  return normal(contact, z) * lcp_.row(static_cast<std::size_t>(contact), z, u) + f.first * slip.first +
         f.second * slip.second;
}

template <class Real>
Real ConeFriction<Real>::residual(Index contact, const RealVector& z, const RealVector& u) const {
  if (impulse_free(contact, z)) return 0;  // whatever M_tt is, which takes a solve
  const Real m = diagonal(contact);
  const Tangential f = impulse_of(contact, z), slip = relative_slip(contact, f, u);
  const Tangential scaled{m * f.first, m * f.second};
  const Tangential trial{scaled.first - slip.first, scaled.second - slip.second};
  const Real radius = Real(problem_.mu(contact)) * m * larger(normal(contact, z), Real{0});
  const Real shrink = shrinking(radius, trial.length());
  return finite_or_infinity(
      Tangential{scaled.first - shrink * trial.first, scaled.second - shrink * trial.second}.length());
}

template <class Real>
Real ConeFriction<Real>::slack(Index contact, const RealVector& z) const {
  return Real(problem_.mu(contact)) * normal(contact, z) - impulse_of(contact, z).length();
}

template class ConeFriction<Quad>;
template class ConeFriction<Bounded>;

}  // namespace lcpbench
