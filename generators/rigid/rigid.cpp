#include "generators/rigid/rigid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "generators/random.h"
#include "generators/paper/spectrum.h"

namespace lcpbench {
namespace {

constexpr double kPointStep = 0x1p-10;  // grid of points and arms
constexpr double kNormalSteps = 0x1p40;  // per unit: the grid of normals and tangents
constexpr int kQuarters = 4;             // dependent contacts divide the way between two others by it
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

double square_of(const Triple& a) { return a[0] * a[0] + a[1] * a[1] + a[2] * a[2]; }

// Uniform in direction: a point of the unit ball, not too near its centre, divided by its length and rounded.
Triple draw_general_normal(DrawSequence& draws) {
  for (;;) {
    const Triple point = draw_velocity(draws);
    const double square = square_of(point);
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

// Uniform in direction across the normal: a point of the unit ball, projected and turned by a right angle. Points of a
// cube would prefer the directions of its corners.
Triple draw_general_tangent(DrawSequence& draws, const Triple& normal) {
  for (;;) {
    const Triple point = draw_velocity(draws);
    if (square_of(point) > 1) continue;
    const Triple across = cross(point, normal);
    const double square = square_of(across);
    if (square < 0x1p-4) continue;
    const double length = std::sqrt(square);
    return {round_to_normal_grid(across[0] / length), round_to_normal_grid(across[1] / length),
            round_to_normal_grid(across[2] / length)};
  }
}

Triple draw_axis_tangent(DrawSequence& draws, const Triple& normal) {
  const std::size_t axis = normal[0] != 0 ? 0 : (normal[1] != 0 ? 1 : 2);
  const std::int64_t side = draws.integer(0, 3);
  Triple tangent{};
  tangent[(axis + 1 + static_cast<std::size_t>(side / 2)) % 3] = side % 2 == 0 ? 1.0 : -1.0;
  return tangent;
}

// Inertia of six point masses in three opposite pairs about the centre, so that the centre of mass is where it should
// be and the tensor belongs to a real body. Until it is scaled every entry is exact: weights on 2^-12, arms on 2^-10.
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
    const double square = square_of(arm);
    shape.mass += weight;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) shape.inertia(i, j) += weight * ((i == j ? square : 0.0) - arm[i] * arm[j]);
    }
  }
  return shape;
}

// Shapes that are almost a line are drawn again. The bound on the ratio of the principal moments is far below every
// condition number of a set, so that condition_shapes() can reach both ends of the spectrum.
Shape draw_compact_shape(DrawSequence& masses, DrawSequence& arms) {
  for (;;) {
    Shape shape = draw_shape(masses, arms);
    if (!safely_positive_definite(shape.inertia)) continue;
    for (const double square : spectrum_of_square(shape.inertia).values) shape.moments.push_back(std::sqrt(square));
    if (shape.moments.back() <= kLargestMomentRatio * shape.moments.front()) return shape;
  }
}

// Numbers from 0 to 1. Both 0 and 1 occur. @pre count >= 2
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
  ContactSource(const TrialKey& key, NormalReading reading, bool frictional)
      : reading_(reading),
        frictional_(frictional),
        bodies_(key, Purpose::kContactBodies),
        points_(key, Purpose::kContactPoints),
        normals_(key, Purpose::kNormals),
        tangents_(key, Purpose::kTangents) {}

  // Every body in turn, against the world or one of the others.
  RigidContactSample independent(std::size_t body_count) {
    const int a = static_cast<int>(turn_++ % body_count);
    const int b = static_cast<int>(bodies_.integer(0, static_cast<std::int64_t>(body_count) - 1));
    RigidContactSample contact{a, b == a ? -1 : b, draw_point(points_, 1.0), normal()};
    if (frictional_) contact.tangent = tangent(contact.normal);
    return contact;
  }

  // Another contact of the same two bodies with the same normal and tangent, whose line along the normal is another.
  // Points that are quarters of the way between the two are on the grid.
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
  Triple tangent(const Triple& normal) {
    return reading_ == NormalReading::kAxis ? draw_axis_tangent(tangents_, normal)
                                            : draw_general_tangent(tangents_, normal);
  }

  NormalReading reading_;
  bool frictional_;
  std::size_t turn_ = 0;
  DrawSequence bodies_;
  DrawSequence points_;
  DrawSequence normals_;
  DrawSequence tangents_;
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

// Each contact has a mu of its own, a dependent one too.
void add_friction(const TrialKey& key, PyramidEdges edges, RigidSample& sample) {
  DrawSequence draws(key, Purpose::kFriction);
  for (RigidContactSample& contact : sample.contacts) contact.mu = static_cast<double>(draws.unit_grid()) * kGridStep;
  sample.edges = static_cast<int>(edges);
}

// ---- the sets ----

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
    if constexpr (kFeatures.frictional) {
      field("edges", reading.edges,
            Choices<PyramidEdges>{{{"4", PyramidEdges::k4}, {"8", PyramidEdges::k8}, {"16", PyramidEdges::k16}}},
            "of the friction pyramid: 4 makes a scene; 8 and 16 make a contact problem, which engines refuse");
    }
    field("bodies_max", reading.bodies_max, IntegerRange{1, 16}, "ceiling of the number of bodies");
    field("nc_max", reading.nc_max, IntegerRange{2, 200}, "ceiling of the number of contacts");
  }
};

template <RigidFeatures kFeatures>
RigidSet make_set(std::string name, std::string stream, std::string summary, double condition = 0) {
  using Settings = RigidSettings<kFeatures>;
  RigidSet set{std::move(name), std::move(stream), std::move(summary), kFeatures, condition};
  read_options_as<Settings>(set);
  return set;
}

// Adds the sets of Experiments 1, 2, 5 and 6. The random streams do not depend on the prefix: frictional sets have the
// scenes of the frictionless ones, with friction.
template <bool kFrictional>
void add_sets(const std::string& prefix, std::vector<RigidSet>& sets) {
  constexpr RigidFeatures kPlain{.frictional = kFrictional};
  constexpr RigidFeatures kRedundant{.frictional = kFrictional, .redundant = true};
  constexpr RigidFeatures kConditioned{.frictional = kFrictional, .redundant = true, .conditioned = true};
  sets.push_back(make_set<kPlain>(prefix + "exp1", "rigid/exp1", "rigid bodies, independent contacts"));
  sets.push_back(make_set<kRedundant>(prefix + "exp2", "rigid/exp2", "rigid bodies, redundant contacts"));
  const auto add_conditioned = [&](std::string name, std::string stream, std::string summary, double condition) {
    sets.push_back(make_set<kConditioned>(std::move(name), std::move(stream), std::move(summary), condition));
  };
  for_each_conditioned_experiment(prefix, "rigid/", add_conditioned);
}

}  // namespace

const std::vector<RigidSet>& rigid_sets() {
  static const std::vector<RigidSet> sets = [] {
    std::vector<RigidSet> all;
    add_sets<false>("rigid/", all);
    add_sets<true>("rigid/frictional/", all);
    return all;
  }();
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
  ContactSource source(key, reading.normals, set.features.frictional);
  // With combinations, contacts 2 k and 2 k + 1 have the same bodies and directions: dependent ones lie between them.
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
  if (set.features.frictional) add_friction(key, reading.edges, sample);
  return sample;
}

std::vector<Triple> friction_directions(const RigidContactSample& contact, PyramidEdges edges) {
  constexpr double kCosEighth = 0.92387953251128674;   // cos(pi / 8)
  constexpr double kSinEighth = 0.38268343236508977;   // sin(pi / 8)
  constexpr double kCosQuarter = 0.70710678118654752;  // cos(pi / 4)
  constexpr std::array<double, 8> kCosines = {1, kCosEighth,  kCosQuarter,  kSinEighth,
                                              0, -kSinEighth, -kCosQuarter, -kCosEighth};
  const auto count = static_cast<std::size_t>(edges) / 2;
  const Triple second = cross(contact.normal, contact.tangent);
  std::vector<Triple> directions(count);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t eighths = k * (8 / count);
    const double cosine = kCosines[eighths];
    const double sine = kCosines[eighths < 4 ? 4 - eighths : eighths - 4];
    for (std::size_t i = 0; i < 3; ++i) {
      directions[k][i] = round_to_normal_grid(cosine * contact.tangent[i] + sine * second[i]);
    }
  }
  return directions;
}

}  // namespace lcpbench
