#include "generators/made/scene.h"

#include <algorithm>
#include <cmath>

#include "generators/paper/spectrum.h"

namespace lcpbench::made {
namespace {

constexpr double kGap = 0.1;  ///< largest gap, or depth of penetration, over the step [m/s]

}  // namespace

double length(const Triple& a) { return std::sqrt(dot(a, a)); }

Triple unit(const Triple& a) { return (1 / length(a)) * a; }

double power(double base, double exponent) { return portable_exp2(exponent * portable_log2(base)); }

// Taylor series at an eighth of the angle, and three times the formulas for the double angle.
std::array<double, 2> cos_sin(double turns) {
  const double angle = (turns - std::floor(turns + 0.5)) * (6.283185307179586 / 8);
  const double square = angle * angle;
  double cosine = 0, sine = 0;
  for (int k = 16; k > 0; k -= 2) {
    cosine = square * (1 - cosine) / (k * (k - 1));
    sine = square * (1 - sine) / (k * (k + 1));
  }
  cosine = 1 - cosine;
  sine = angle * (1 - sine);
  for (int k = 0; k < 3; ++k) {
    const double doubled = cosine * cosine - sine * sine;
    sine = 2 * cosine * sine;
    cosine = doubled;
  }
  const double norm = std::sqrt(cosine * cosine + sine * sine);
  return {cosine / norm, sine / norm};
}

Axes turned_about_z(double turns) {
  const auto [c, s] = cos_sin(turns);
  return {Triple{c, s, 0}, Triple{-s, c, 0}, kZ};
}

Axes turned_about_y(double turns) {
  const auto [c, s] = cos_sin(turns);
  return {Triple{c, 0, s}, kY, Triple{-s, 0, c}};
}

Triple tangent(const Triple& normal) {
  const std::size_t across = std::abs(normal[2]) < 0.7 ? 2 : 0;
  return unit(cross(normal, kWorldAxes[across]));
}

Scene::Scene(const MadeReading& reading, const TrialKey& key)
    : shape_(key, Purpose::kMadeShape),
      velocities_(key, Purpose::kMadeVelocity),
      frictions_(key, Purpose::kMadeFriction),
      offset_draws_(key, Purpose::kMadeOffset),
      mu_min_(reading.mu_min),
      mu_max_(reading.mu_max) {
  DrawSequence draws(key, Purpose::kMadeTrial);
  const auto share = [&] { return static_cast<double>(draws.unit_grid()) * kGridStep; };
  const auto up_to = [&](double low, double high) { return low * power(high / low, share()); };
  goal_ = up_to(static_cast<double>(std::min(reading.nc_min, reading.nc_max)), static_cast<double>(reading.nc_max));

  constexpr std::array<int, 8> kEdges{0, 4, 2, 4, 6, 8, 12, 16};
  const int edges = kEdges[static_cast<std::size_t>(draws.integer(0, 7))];
  edges_ = reading.edges == MadeEdges::kDrawn ? edges : static_cast<int>(reading.edges);
  const std::int64_t friction = draws.integer(0, 5);
  const double mu = mu_min_ + share() * (mu_max_ - mu_min_);
  mu_is_shared_ = friction < 4;
  mu_ = friction == 0 ? mu_max_ : mu;

  const double decades = share();
  if (draws.integer(0, 1) == 1) mass_ratio_ = power(reading.mass_ratio, decades);

  const auto drawn_motion = static_cast<MadeMotion>(draws.integer(1, 3));
  const MadeMotion motion = reading.motion == MadeMotion::kDrawn ? drawn_motion : reading.motion;
  const double speed = up_to(0.1, 1);
  if (motion == MadeMotion::kSlide) {
    speed_ = 0.02 * speed;
    drift_ = 0.5 * speed * turned_about_z(share())[0];
  } else if (motion == MadeMotion::kImpact) {
    speed_ = 2 * speed;
  }

  const auto kind = static_cast<Offsets>(draws.integer(0, 2));
  offset_share_ = share() * reading.offsets;
  bounce_ = share();
  if (offset_share_ > 0) offsets_ = kind;
}

double Scene::draw(DrawSequence& draws, double low, double high) {
  return low + static_cast<double>(draws.unit_grid()) * kGridStep * (high - low);
}

Triple Scene::draw_triple(DrawSequence& draws, double largest) {
  Triple drawn;
  for (double& each : drawn) each = draw(draws, -largest, largest);
  return drawn;
}

double Scene::uniform(double low, double high) { return draw(shape_, low, high); }

double Scene::log_uniform(double low, double high) { return low * power(high / low, uniform(0, 1)); }

double Scene::graded_mass(double usual, double share) const { return usual * power(mass_ratio_, share); }

int Scene::add_free_body(double mass, const ColumnMajor<double>& inertia, const Triple& centre, double radius) {
  const Part part{.base_row = sample_.v.size(), .base_centre = centre, .centre = centre, .joints = {}};
  parts_.push_back(part);
  ColumnMajor<double> masses(3, 3);
  for (std::size_t k = 0; k < 3; ++k) masses(k, k) = mass;
  sample_.blocks.push_back(masses);
  sample_.blocks.push_back(inertia);
  add_free_velocity(radius);
  return static_cast<int>(parts_.size()) - 1;
}

void Scene::add_free_velocity(double radius) {
  const Triple linear = draw_triple(velocities_, speed_) + drift_ - kGravityStep * kZ;
  const Triple angular = draw_triple(velocities_, speed_ / radius);
  sample_.v.insert(sample_.v.end(), linear.begin(), linear.end());
  sample_.v.insert(sample_.v.end(), angular.begin(), angular.end());
}

int Scene::box(double mass, const Triple& edges, const Triple& centre, const Axes& axes) {
  ColumnMajor<double> inertia(3, 3);
  for (std::size_t k = 0; k < 3; ++k) {
    const double moment = mass / 12 * (dot(edges, edges) - edges[k] * edges[k]);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) inertia(i, j) += moment * (axes[k][i] * axes[k][j]);
    }
  }
  return add_free_body(mass, inertia, centre, length(edges) / 2);
}

int Scene::sphere(double mass, double radius, const Triple& centre) {
  ColumnMajor<double> inertia(3, 3);
  for (std::size_t k = 0; k < 3; ++k) inertia(k, k) = 0.4 * mass * radius * radius;
  return add_free_body(mass, inertia, centre, radius);
}

int Scene::robot(double mass, const Triple& centre, bool base_is_free, const std::vector<Link>& links,
                 double condition) {
  struct Twist {
    std::size_t row;
    Triple linear, angular;
  };
  const int base = static_cast<int>(parts_.size());
  const std::size_t first = sample_.v.size();
  const std::size_t base_rows = base_is_free ? 6 : 0;
  const std::size_t order = base_rows + links.size();
  parts_.push_back({first, base_is_free, centre, centre, {}});
  for (std::size_t k = 0; k < links.size(); ++k) {
    Part part = parts_[static_cast<std::size_t>(base + 1 + links[k].parent)];
    part.centre = links[k].centre;
    part.joints.insert(part.joints.begin(), {first + base_rows + k, links[k]});
    parts_.push_back(part);
  }
  ColumnMajor<double> G(order, order);
  for (std::size_t p = 0; p <= links.size(); ++p) {
    const Part& part = parts_[static_cast<std::size_t>(base) + p];
    const double part_mass = p == 0 ? mass : links[p - 1].mass;
    const double radius = p == 0 ? 0.2 : 0.5 * length(links[p - 1].centre - links[p - 1].joint) + 0.02;
    std::vector<Twist> twists;
    for (std::size_t k = 0; k < 3 && base_is_free; ++k) {
      twists.push_back({k, kWorldAxes[k], {}});
      twists.push_back({3 + k, cross(kWorldAxes[k], part.centre - centre), kWorldAxes[k]});
    }
    for (const auto& [row, link] : part.joints) {
      twists.push_back({row - first, cross(link.axis, part.centre - link.joint), link.axis});
    }
    for (const Twist& a : twists) {
      for (const Twist& b : twists) {
        if (b.row > a.row) continue;
        const double entry = dot(a.linear, b.linear) + 0.4 * radius * radius * dot(a.angular, b.angular);
        G(a.row, b.row) += part_mass * entry;
      }
    }
  }
  double trace = 0;
  for (std::size_t i = 0; i < order; ++i) trace += G(i, i);
  for (std::size_t i = 0; i < order; ++i) {
    G(i, i) += trace / condition;
    for (std::size_t j = 0; j < i; ++j) G(j, i) = G(i, j);
  }
  sample_.blocks.push_back(G);
  if (base_is_free) add_free_velocity(1);
  for (std::size_t k = 0; k < links.size(); ++k) sample_.v.push_back(draw(velocities_, -2 * speed_, 2 * speed_));
  return base;
}

int Scene::slider(double mass, const Triple& axis, double speed) {
  Part part{.base_row = sample_.v.size(), .base_is_free = false, .joints = {}};
  part.slide = axis;
  parts_.push_back(part);
  ColumnMajor<double> inertia(1, 1);
  inertia(0, 0) = mass;
  sample_.blocks.push_back(inertia);
  sample_.v.push_back(speed);
  sample_.is_dense = true;
  return static_cast<int>(parts_.size()) - 1;
}

void Scene::move(int body, const Triple& linear, const Triple& angular) {
  const std::size_t row = parts_[static_cast<std::size_t>(body)].base_row;
  for (std::size_t k = 0; k < 3; ++k) {
    sample_.v[row + k] = linear[k];
    sample_.v[row + 3 + k] = angular[k];
  }
}

void Scene::push(const Part& part, const Triple& point, const Triple& direction, MadeSample::Column& column) {
  const auto add = [&](std::size_t row, double entry) {
    if (entry != 0) column.emplace_back(row, entry);
  };
  if (part.base_is_free) {
    const Triple torque = cross(point - part.base_centre, direction);
    for (std::size_t k = 0; k < 3; ++k) {
      add(part.base_row + k, direction[k]);
      add(part.base_row + 3 + k, torque[k]);
    }
  }
  const double slid = dot(part.slide, direction);
  if (std::abs(slid) > 1e-12) add(part.base_row, slid);  // across the axis only rounding is left of the product
  for (const auto& [row, link] : part.joints) add(row, dot(link.axis, cross(point - link.joint, direction)));
}

MadeSample::Column Scene::column(int a, int b, const Triple& point, const Triple& direction) const {
  MadeSample::Column entries;
  push(parts_[static_cast<std::size_t>(a)], point, direction, entries);
  if (b != kWorld) push(parts_[static_cast<std::size_t>(b)], point, -direction, entries);
  std::sort(entries.begin(), entries.end());
  return entries;
}

// If each contact has its own mu, this is mu_min with probability 1/8, else uniform.
double Scene::draw_mu() {
  const double own = draw(frictions_, mu_min_, mu_max_);
  const bool is_least = frictions_.integer(0, 7) == 0;
  if (mu_is_shared_) return mu_;
  return is_least ? mu_min_ : own;
}

// A positive offset is a gap over the step, a negative one a penetration over the step or, if the contact closes, a
// restitution times the normal velocity.
double Scene::draw_offset(double approach, bool is_open) {
  const bool is_chosen = draw(offset_draws_, 0, 1) < offset_share_;
  const double drawn = draw(offset_draws_, -kGap, kGap);
  if (!is_chosen || offsets_ == Offsets::kNone) return 0;
  if (!is_open) return drawn < 0 ? -drawn : drawn;
  return offsets_ == Offsets::kBounces && approach < 0 ? bounce_ * approach : drawn;
}

void Scene::touch(int a, int b, const Triple& point, const Triple& normal, bool is_open) {
  const double mu = draw_mu();
  add_contact(a, b, point, normal, tangent(normal), edges_, edges_ > 0 ? mu : 0, 0);
  double approach = 0;
  for (const auto& [row, entry] : sample_.N.back()) approach += entry * sample_.v[row];
  sample_.b.back() = draw_offset(approach, is_open);
}

void Scene::add_contact(int a, int b, const Triple& point, const Triple& normal, const Triple& first, int edges,
                        double mu, double offset) {
  sample_.N.push_back(column(a, b, point, normal));
  sample_.b.push_back(offset);
  sample_.edges.push_back(edges);
  sample_.mu.push_back(mu);
  const Triple second = cross(normal, first);
  const std::size_t begin = sample_.D.size();
  for (int k = 0; k < edges / 2; ++k) {
    const auto [c, s] = cos_sin(static_cast<double>(k) / edges);
    sample_.D.push_back(column(a, b, point, c * first + s * second));
  }
  for (int k = 0; k < edges / 2; ++k) {
    MadeSample::Column opposite = sample_.D[begin + static_cast<std::size_t>(k)];
    for (auto& entry : opposite) entry.second = -entry.second;
    sample_.D.push_back(std::move(opposite));
  }
}

void Scene::touch_face(int a, int b, const Triple& centre, const Triple& normal, const Triple& along,
                       const Triple& across, bool is_open) {
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) touch(a, b, centre + x * along + y * across, normal, is_open);
  }
}

}  // namespace lcpbench::made
