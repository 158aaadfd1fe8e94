#include "generators/rigid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "generators/random.h"
#include "generators/spectrum.h"

namespace lcpbench {
namespace {

constexpr double kPointStep = 0x1p-10;
constexpr double kNormalSteps = 0x1p40;
constexpr int kQuarters = 4;
/// Largest ratio of the principal moments of a body before it is scaled.
constexpr double kLargestMomentRatio = 64;

double signed_unit(DrawSequence& draws) { return static_cast<double>(draws.signed_grid()) * kGridStep; }

Triple draw_velocity(DrawSequence& draws) {
  Triple velocity;
  for (double& component : velocity) component = signed_unit(draws);
  return velocity;
}

// Components uniform on multiples of 2^-10 in [-bound, bound).
Triple draw_point(DrawSequence& draws, double bound) {
  const auto steps = static_cast<std::int64_t>(bound / kPointStep);
  Triple point;
  for (double& component : point) component = static_cast<double>(draws.integer(-steps, steps - 1)) * kPointStep;
  return point;
}

Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double round_to_normal_grid(double value) {
  const double steps = value * kNormalSteps;
  return static_cast<double>(static_cast<std::int64_t>(steps + (steps >= 0 ? 0.5 : -0.5))) / kNormalSteps;
}

// Uniform in direction: a point of the unit ball, not too near its centre, divided by its length and rounded.
Triple draw_general_normal(DrawSequence& draws) {
  for (;;) {
    const Triple point = draw_velocity(draws);
    const double square = point[0] * point[0] + point[1] * point[1] + point[2] * point[2];
    if (square > 1 || square < 0x1p-4) continue;
    const double length = std::sqrt(square);
    return {round_to_normal_grid(point[0] / length), round_to_normal_grid(point[1] / length),
            round_to_normal_grid(point[2] / length)};
  }
}

Triple draw_axis_normal(DrawSequence& draws) {
  const std::int64_t side = draws.integer(0, 5);
  Triple normal{};
  normal[static_cast<std::size_t>(side / 2)] = side % 2 == 0 ? 1.0 : -1.0;
  return normal;
}

// Inertia of six point masses in three opposite pairs about the centre, so that the centre of mass is where it should
// be and the tensor belongs to a real body. Every entry is exact: weights on 2^-12, arms on 2^-10.
struct Shape {
  double mass = 0;
  ColumnMajor<double> inertia{3, 3};
  std::vector<double> moments;  // ascending
};

Shape draw_shape(DrawSequence& masses, DrawSequence& arms) {
  Shape shape;
  const double scale = static_cast<double>(std::int64_t{1} << masses.integer(0, 4)) / 4;
  for (int pair = 0; pair < 3; ++pair) {
    const double weight = static_cast<double>(masses.integer(512, 1024)) * kPointStep * scale;
    const Triple arm = draw_point(arms, 0.5);
    const double square = arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2];
    shape.mass += weight;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) shape.inertia(i, j) += weight * ((i == j ? square : 0.0) - arm[i] * arm[j]);
    }
  }
  return shape;
}

// Shapes that are all but a line are drawn again: their smallest moment would hide the conditioning asked for.
Shape draw_compact_shape(DrawSequence& masses, DrawSequence& arms) {
  for (;;) {
    Shape shape = draw_shape(masses, arms);
    if (!safely_positive_definite(shape.inertia)) continue;
    for (const double square : spectrum_of_square(shape.inertia).values) shape.moments.push_back(std::sqrt(square));
    if (shape.moments.back() <= kLargestMomentRatio * shape.moments.front()) return shape;
  }
}

// Numbers from 0 to 1, both of them among the numbers.
std::vector<double> draw_positions(const TrialKey& key, std::size_t count) {
  DrawSequence draws(key, Purpose::kConditioning);
  std::vector<double> positions(count);
  for (;;) {
    for (double& position : positions) position = static_cast<double>(draws.unit_grid());
    const auto [lowest, highest] = std::minmax_element(positions.begin(), positions.end());
    const double low = *lowest;
    const double span = *highest - low;
    if (!(span > 0)) continue;
    for (double& position : positions) position = (position - low) / span;
    return positions;
  }
}

// From `low` to `high` on a logarithmic scale; the ends are exact.
double interpolate_log(double low, double high, double position) {
  if (position == 0) return low;
  if (position == 1) return high;
  const double log_low = portable_log2(low);
  return portable_exp2(log_low + position * (portable_log2(high) - log_low));
}

// Masses and inertias of the same shapes, scaled so that the smallest eigenvalue of the whole inertia is 1 and the
// largest is `condition`. Scaling a tensor as a whole keeps it that of a real body.
void condition_shapes(const TrialKey& key, double condition, std::vector<Shape>& shapes) {
  const std::vector<double> positions = draw_positions(key, 2 * shapes.size());
  for (std::size_t b = 0; b < shapes.size(); ++b) {
    Shape& shape = shapes[b];
    shape.mass = interpolate_log(1, condition, positions[2 * b]);
    const double scale =
        interpolate_log(1 / shape.moments.front(), condition / shape.moments.back(), positions[2 * b + 1]);
    for (double& entry : shape.inertia.data) entry *= scale;
  }
}

std::vector<RigidBodySample> draw_bodies(const TrialKey& key, const RigidSet& set, std::size_t count) {
  DrawSequence masses(key, Purpose::kBodyMass);
  DrawSequence arms(key, Purpose::kBodyShape);
  DrawSequence positions(key, Purpose::kBodyPosition);
  DrawSequence velocities(key, Purpose::kVelocity);
  std::vector<Shape> shapes;
  for (std::size_t b = 0; b < count; ++b) shapes.push_back(draw_compact_shape(masses, arms));
  if (set.features.conditioned) condition_shapes(key, set.condition, shapes);

  std::vector<RigidBodySample> bodies;
  for (Shape& shape : shapes) {
    RigidBodySample body;
    body.mass = shape.mass;
    body.inertia = std::move(shape.inertia);
    body.position = draw_point(positions, 1.0);
    body.linear_velocity = draw_velocity(velocities);
    body.angular_velocity = draw_velocity(velocities);
    bodies.push_back(std::move(body));
  }
  return bodies;
}

class ContactSource {
 public:
  ContactSource(const TrialKey& key, NormalReading reading)
      : reading_(reading),
        bodies_(key, Purpose::kContactBodies),
        points_(key, Purpose::kContactPoints),
        normals_(key, Purpose::kNormals) {}

  // Every body in turn, against the world or one of the others.
  RigidContactSample independent(std::size_t body_count) {
    const int a = static_cast<int>(turn_++ % body_count);
    const int b = static_cast<int>(bodies_.integer(0, static_cast<std::int64_t>(body_count) - 1));
    return {a, b == a ? -1 : b, draw_point(points_, 1.0), normal()};
  }

  // Another contact of the same two bodies with the same normal, at another place of the plane across it.
  RigidContactSample partner(const RigidContactSample& first) {
    for (;;) {
      const Triple step = draw_point(points_, 0.125);
      if (cross(step, first.normal) == Triple{}) continue;
      RigidContactSample second = first;
      for (std::size_t i = 0; i < 3; ++i) second.point[i] += kQuarters * step[i];
      return second;
    }
  }

 private:
  Triple normal() {
    return reading_ == NormalReading::kAxis ? draw_axis_normal(normals_) : draw_general_normal(normals_);
  }

  NormalReading reading_;
  std::size_t turn_ = 0;
  DrawSequence bodies_;
  DrawSequence points_;
  DrawSequence normals_;
};

RigidDependence draw_dependence(std::size_t contact, std::size_t independent, Redundancy redundancy,
                                DrawSequence& sources, DrawSequence& factors) {
  if (redundancy == Redundancy::kMultiple || independent < 2) {
    const auto first = static_cast<std::size_t>(sources.integer(0, static_cast<std::int64_t>(independent) - 1));
    return {contact, first, first, 0};
  }
  const auto pair = static_cast<std::size_t>(sources.integer(0, static_cast<std::int64_t>(independent / 2) - 1));
  return {contact, 2 * pair, 2 * pair + 1, static_cast<int>(factors.integer(1, kQuarters - 1))};
}

RigidContactSample depend(const std::vector<RigidContactSample>& contacts, const RigidDependence& dependence) {
  RigidContactSample contact = contacts[dependence.first];
  const Triple& end = contacts[dependence.second].point;
  for (std::size_t i = 0; i < 3; ++i) {
    contact.point[i] += dependence.quarter * ((end[i] - contacts[dependence.first].point[i]) / kQuarters);
  }
  return contact;
}

template <RigidFeatures kFeatures>
struct RigidSettings {
  RigidReading reading;

  void visit(auto&& field) {
    if constexpr (kFeatures.redundant) {
      field("redundancy", reading.redundancy,
            Choices<Redundancy>{{{"multiple", Redundancy::kMultiple}, {"combination", Redundancy::kCombination}}},
            "a dependent contact repeats an independent one, or lies between two of the same bodies and normal");
    }
    field("normals", reading.normals,
          Choices<NormalReading>{{{"general", NormalReading::kGeneral}, {"axis", NormalReading::kAxis}}},
          "contact normals in any direction (of length 1 within 1e-12), or along the axes (of length 1 exactly)");
    field("bodies_max", reading.bodies_max, IntegerRange{1, 16}, "ceiling of the number of bodies");
    field("nc_max", reading.nc_max, IntegerRange{2, 200}, "ceiling of the number of contacts");
  }
};

template <RigidFeatures kFeatures>
RigidSet make_set(std::string name, std::string stream, std::string summary, double condition = 0) {
  using Settings = RigidSettings<kFeatures>;
  RigidSet set{std::move(name), std::move(stream), std::move(summary), kFeatures, condition};
  set.options = [] { return describe_settings<Settings>(); };
  set.parse = [](std::string_view owner, const Options& options) {
    return parse_settings<Settings>(owner, options).reading;
  };
  set.changed = [](std::string_view owner, const Options& options) {
    return changed_settings(parse_settings<Settings>(owner, options));
  };
  return set;
}

std::vector<RigidSet> all_rigid_sets() {
  constexpr RigidFeatures kConditioned{.redundant = true, .conditioned = true};
  const std::pair<const char*, double> conditions[] = {{"1e5", 1e5}, {"1e8", 1e8}, {"1e10", 1e10}};
  std::vector<RigidSet> sets;
  sets.push_back(make_set<RigidFeatures{}>("rigid/exp1", "rigid/exp1", "rigid bodies, independent contacts"));
  sets.push_back(
      make_set<RigidFeatures{.redundant = true}>("rigid/exp2", "rigid/exp2", "rigid bodies, redundant contacts"));
  for (const auto& [label, condition] : conditions) {
    const std::string name = std::string("rigid/exp5-") + label;
    sets.push_back(make_set<kConditioned>(
        name, name, std::string("redundant contacts, eigenvalues of the inertia from 1 to ") + label, condition));
  }
  for (const auto& [label, condition] : conditions) {
    sets.push_back(make_set<kConditioned>(
        std::string("rigid/exp6-") + label, std::string("rigid/exp5-") + label,
        "the problems of exp5-" + std::string(label) + ", for solvers that regularise", condition));
  }
  return sets;
}

}  // namespace

const std::vector<RigidSet>& rigid_sets() {
  static const std::vector<RigidSet> sets = all_rigid_sets();
  return sets;
}

RigidSample draw_rigid(const RigidSet& set, const RigidReading& reading, std::uint64_t seed, std::uint64_t trial) {
  const TrialKey key{stream_id(set.stream), seed, trial};
  const auto draw_count = [&](Purpose purpose, std::int64_t low, std::int64_t high) {
    return static_cast<std::size_t>(DrawSequence(key, purpose).integer(low, high));
  };
  const std::size_t body_count = draw_count(Purpose::kBodyCount, 1, reading.bodies_max);
  const std::size_t nc = draw_count(Purpose::kContactCount, 2, reading.nc_max);
  const std::size_t redundant =
      set.features.redundant ? draw_count(Purpose::kRedundantCount, 0, static_cast<std::int64_t>(nc) - 1) : 0;
  const std::size_t independent = nc - redundant;

  RigidSample sample;
  sample.bodies = draw_bodies(key, set, body_count);
  ContactSource source(key, reading.normals);
  const bool paired = redundant > 0 && reading.redundancy == Redundancy::kCombination;
  for (std::size_t i = 0; i < independent; ++i) {
    sample.contacts.push_back(paired && i % 2 == 1 ? source.partner(sample.contacts.back())
                                                   : source.independent(body_count));
  }
  DrawSequence sources(key, Purpose::kRedundancySources);
  DrawSequence factors(key, Purpose::kRedundancyFactors);
  for (std::size_t i = independent; i < nc; ++i) {
    sample.dependences.push_back(draw_dependence(i, independent, reading.redundancy, sources, factors));
    sample.contacts.push_back(depend(sample.contacts, sample.dependences.back()));
  }
  return sample;
}

}  // namespace lcpbench
