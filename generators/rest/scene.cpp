#include "generators/rest/scene.h"

#include <algorithm>
#include <cmath>

namespace lcpbench::rest {
namespace {

using made::cos_sin;
using made::cross;
using made::dot;
using made::length;
using made::unit;

constexpr double kLightest = 1e-3, kHeaviest = 1e3;
constexpr double kLeastMu = 0.1, kLargestMu = 2;
constexpr double kFastest = 50;  ///< that a press makes a finger in a step, unless it had to be too heavy for it [m/s]

MadeReading made_reading(const RestReading& reading) {
  return {.nc_min = 3, .nc_max = reading.nc_max, .offsets = 0, .motion = MadeMotion::kRest};
}

/// The least sum of impulses along the edges that gives the friction (x, y).
double edge_sum(int edges, double x, double y) {
  if (edges == 2) return std::abs(x);
  double furthest = 0;  // beyond the sides of the polygon
  for (int k = 0; k < edges; ++k) {
    const auto [c, s] = cos_sin((k + 0.5) / edges);
    furthest = std::max(furthest, c * x + s * y);
  }
  return furthest / cos_sin(0.5 / edges)[0];
}

}  // namespace

double weight(double mass) { return mass * made::kGravityStep; }

double cube_edge(double mass) { return made::power(mass / 1000, 1.0 / 3); }

Scene::Scene(const RestReading& reading, const TrialKey& key) : made::Scene(made_reading(reading), key) {
  const double margin = log_uniform(1.02, 100);
  margin_ = reading.margin == 0 ? margin : reading.margin;
  slides_ = chance(0.5);
  const double turn = uniform(0, 1);
  axes_ = made::turned_about_z(chance(0.5) ? turn : 0);
  const int masses = integer(0, 2);
  masses_are_drawn_ = masses == 1;
  even_mass_ = log_uniform(masses == 2 ? 1 : kLightest, kHeaviest);
  const double light_mass = log_uniform(kLightest, 1);
  odd_mass_ = masses == 2 ? light_mass : even_mass_;
  is_regular_ = chance(0.25);
  const int edges = 2 * integer(1, 8);
  edges_ = chance(0.5) || is_regular_ ? edges : 0;
  const double mu = uniform(kLeastMu, kLargestMu);
  const int friction = integer(0, 2);
  mu_ = friction == 0 || is_regular_ ? mu : 0;
  mu_is_shared_ = friction < 2;
  const double share = uniform(0, 0.5);
  open_share_ = chance(0.5) ? share : 0;
  const double unevenness = log_uniform(1, 1000);
  unevenness_ = chance(0.5) && !is_regular_ ? unevenness : 1;
}

double Scene::mass_of(int k) {
  const double own = log_uniform(kLightest, kHeaviest);
  if (masses_are_drawn_) return own;
  return k % 2 == 0 ? even_mass_ : odd_mass_;
}

Surface Scene::surface(bool is_inner) {
  const int edges = 2 * integer(1, 8);
  const double mu = uniform(kLeastMu, kLargestMu);
  const double turn = uniform(0, 1);
  Surface surface{.edges = edges_ > 0 ? edges_ : edges, .mu = mu_ > 0 ? mu_ : mu};
  surface.turn = surface.edges == 2 || is_regular_ || is_inner ? 0 : turn;
  const auto [c, s] = cos_sin(surface.turn);
  // A round cone holds every pyramid: what it cannot carry, no pyramid can.
  surface.slope = surface.mu / (can_rest() ? edge_sum(surface.edges, c, s) * margin_ : margin_);
  return surface;
}

int Scene::body(double mass, const Triple& centre) {
  Triple edges;
  for (double& each : edges) each = cube_edge(mass) * uniform(0.7, 1.3);
  return box(mass, edges, centre, axes_);
}

int Scene::finger(double mass, const Triple& axis, const Triple& impulse, const Triple& point) {
  const double actual = std::min(std::max(mass, length(impulse) / kFastest), kHeaviest);
  if (slides_) return slider(actual, axis, dot(axis, impulse) / actual);
  // The line of the impulse goes through its centre: no torque.
  const int finger = body(actual, point - (0.5 * cube_edge(actual)) * unit(impulse));
  move(finger, (1 / actual) * impulse, {});
  return finger;
}

void Scene::patch(int a, int b, int count, int least, const Surface& surface, const Triple& centre,
                  const Triple& normal, const Triple& impulse, double radius) {
  const double load = dot(impulse, normal);
  const Triple needed = impulse - load * normal;
  const bool needs_friction = length(needed) > 1e-9 * load;
  const Triple ahead = needs_friction ? unit(needed) : made::tangent(normal);
  const auto [c, s] = cos_sin(surface.turn);
  const Triple first = c * ahead - s * cross(normal, ahead);
  const Triple second = cross(normal, first);
  const double ratio = needs_friction ? edge_sum(surface.edges, c, s) * length(needed) / load : 0;

  std::vector<Triple> points;
  std::vector<bool> is_open;
  Triple sum{};
  double total = 0;
  for (int k = 0; k < count; ++k) {
    const auto [x, y] = cos_sin((k + 0.5 + 0.3 * jitter()) / count);
    const double away = radius * (0.75 + 0.25 * jitter());
    const double share = made::power(unevenness_, -uniform(0, 1));
    points.push_back(away * (x * first + y * second));
    is_open.push_back(chance(open_share_) && k >= least);
    if (is_open.back()) continue;
    total += share;
    sum = sum + share * points.back();
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double gap = log_uniform(1e-6, 0.1);  // over the step [m/s]
    const double own = uniform(1, 2);
    const double factor = mu_is_shared_ || k == 0 ? 1 : own;
    const double enough = std::max(std::min(factor * surface.mu, kLargestMu), ratio * margin_);
    const double mu = can_rest() ? enough : std::max(surface.mu / factor, kLeastMu);
    const Triple point = centre + (points[k] - (1 / total) * sum);
    add_contact(a, b, point, normal, first, surface.edges, mu, is_open[k] ? gap : 0);
  }
}

}  // namespace lcpbench::rest
