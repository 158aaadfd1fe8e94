#include "generators/rest/rest.h"

#include <algorithm>

#include "core/error.h"
#include "generators/rest/scene.h"

// A load goes from body to body along lines: it meets the weight of each body on the vertical through the body's
// centre, and goes on from there along the sum of the two. A patch of contacts lies where the line crosses from one
// body to the next.

namespace lcpbench {
namespace rest {
namespace {

using made::dot;
using made::length;
using made::unit;

constexpr double kReach = 0.4;  ///< of a patch, in edges of the smaller body

int aim(const Scene& scene) { return static_cast<int>(scene.goal()); }

// A row of bodies between two jaws, or a jaw and a wall. Friction at the two ends carries the whole weight, and the
// press is the normal load of each: with mu P of both below the weight nothing holds the row.
void build_clamp(Scene& scene) {
  const Triple ahead = scene.axes()[0];
  const int least = scene.least();
  const int wanted = scene.integer(least, 16);
  const int objects = std::max(aim(scene) / wanted - 1, 1);
  const int each = std::clamp(aim(scene) / (objects + 1), least, 16);
  std::vector<double> masses;
  double load = 0;
  for (int k = 0; k < objects; ++k) {
    masses.push_back(scene.mass_of(k + 1));
    load += weight(masses.back());
  }
  const Surface left = scene.surface();
  const Surface right = scene.surface();
  const double press = load / (left.slope + right.slope);
  Triple point{};
  Triple impulse = press * (ahead + left.slope * kZ);
  const double jaw = scene.mass_of(0);
  int last = scene.chance(0.3) ? kWorld : scene.finger(jaw, ahead, impulse, point);
  double last_edge = 1e9;
  for (int k = 0; k < objects; ++k) {
    const double mass = masses[static_cast<std::size_t>(k)];
    const double edge = cube_edge(mass);
    const Triple middle = point + (0.5 * edge / press) * impulse;
    const int object = scene.body(mass, middle + (0.2 * edge * scene.jitter()) * kZ);
    const Surface surface = k == 0 ? left : scene.surface(true);
    scene.patch(object, last, each, least, surface, point, ahead, impulse, kReach * std::min(edge, last_edge));
    impulse = impulse - weight(mass) * kZ;
    point = middle + (0.5 * edge / press) * impulse;
    last = object;
    last_edge = edge;
  }
  const int other_jaw = scene.finger(scene.mass_of(objects + 1), -ahead, -impulse, point);
  scene.patch(last, other_jaw, each, least, right, point, -ahead, -impulse, kReach * last_edge);
}

// A body between two to eight fingers that press towards a vertical line. Each finger's press is its normal load: with
// mu P of all below the weight nothing holds the body.
void build_grasp(Scene& scene) {
  const int fingers = scene.integer(2, std::clamp(scene.slides() ? aim(scene) : aim(scene) / 3, 2, 8));
  const int least = scene.slides() && fingers > 2 ? 1 : scene.least();
  const int each = std::max(aim(scene) / fingers, least);
  const double mass = scene.mass_of(1);
  const double edge = cube_edge(mass);
  std::vector<Triple> presses;
  std::vector<Surface> surfaces;
  Triple sum{};
  double capacity = 0;
  for (int k = 0; k < fingers; ++k) {
    const Axes around = made::turned_about_z((k + 0.1 * scene.jitter()) / fingers);
    const double press = 1 + 0.5 * scene.jitter();
    presses.push_back(k + 1 < fingers ? press * around[0] : -sum);
    sum = sum + presses.back();
    surfaces.push_back(scene.surface());
    capacity += surfaces.back().slope * length(presses.back());
  }
  const double scale = weight(mass) / capacity;
  std::vector<Triple> points;
  Triple centre = (0.2 * edge * scene.jitter()) * kZ;
  for (std::size_t k = 0; k < presses.size(); ++k) {
    points.push_back(-edge * (0.5 + 0.1 * scene.jitter()) * unit(presses[k]));
    centre = centre + (surfaces[k].slope * length(presses[k]) / capacity) * points.back();
  }
  const int object = scene.body(mass, centre);
  for (std::size_t k = 0; k < presses.size(); ++k) {
    const Triple normal = unit(presses[k]);
    const Triple impulse = scale * (presses[k] + length(presses[k]) * surfaces[k].slope * kZ);
    const int finger = scene.finger(scene.mass_of(2 * static_cast<int>(k)), normal, impulse, points[k]);
    scene.patch(object, finger, each, least, surfaces[k], points[k], normal, impulse, kReach * edge);
  }
}

// Boxes on one another, the planes between them tilted, one of them as far as the margin lets it: what stands there
// would slide if the slope were above mu. The lowest box stands on `legs` points.
void pile(Scene& scene, int boxes, int each, int legs, int steepest) {
  Triple point{};
  double load = 0;
  double last_edge = 0;
  int last = kWorld;
  for (int k = 0; k <= boxes; ++k) {  // from the top
    const bool is_ground = k == boxes;
    const double mass = scene.mass_of(k);
    const double edge = cube_edge(mass);
    const Triple aside = (0.2 * edge * scene.jitter()) * scene.axes()[0];
    const int box = is_ground ? kWorld : scene.body(mass, point + aside - (0.5 * edge) * kZ);
    if (k > 0) {
      const Surface surface = scene.surface();
      const double slope = surface.slope * (k == steepest ? 1 : scene.uniform(0, 1));
      const Triple normal = unit(kZ + slope * made::turned_about_z(scene.uniform(0, 1))[0]);
      const double reach = kReach * (is_ground ? last_edge : std::min(edge, last_edge));
      scene.patch(last, box, is_ground ? legs : each, 3, surface, point, normal, load * kZ, reach);
    }
    load += weight(mass);
    point = point + (weight(mass) / load) * aside - edge * kZ;
    last = box;
    last_edge = edge;
  }
}

void build_stack(Scene& scene) {
  const int boxes = std::max(aim(scene) / scene.integer(3, 16), 1);
  const int each = std::clamp(aim(scene) / boxes, 3, 16);
  pile(scene, boxes, each, each, scene.integer(1, boxes));
}

// Up to four boxes on a top with many legs, which stands on a slope.
void build_table(Scene& scene) {
  const int boxes = 1 + std::min(aim(scene) / 6, scene.integer(0, 4));
  pile(scene, boxes, 3, aim(scene) - 3 * (boxes - 1), boxes);
}

// A wedge between two sides that lean over it by the angle whose tangent is `lean`: they hold it by friction alone, and
// if lean is above mu, no impulse of theirs points upwards. With a negative lean the wedge lies in a groove. A side
// is a jaw that presses or a wall; two walls only in a groove: between two that lean over it nothing would press.
void build_wedge(Scene& scene) {
  const bool can_rest = scene.can_rest();
  const bool in_groove = scene.chance(0.3) && can_rest;
  const double held = scene.uniform(0, 1);
  const int least = scene.least();
  const int each = std::max(aim(scene) / 2, least);
  const Surface side = scene.surface();
  const double share = in_groove  ? -held / (1 + side.slope * side.slope)
                       : can_rest ? 0.95 * held
                                  : 0.5 + 0.45 * held;
  const double ratio = side.slope / (can_rest ? 1 : share);  // of friction to normal load
  const double lean = share * ratio;
  const Axes& axes = scene.axes();

  const double mass = scene.mass_of(0);
  const double edge = cube_edge(mass);
  const double load = weight(mass) / (2 * (ratio - lean));
  const int wedge = scene.body(mass, (0.2 * edge * scene.jitter()) * kZ);
  const int jaws = scene.integer(in_groove ? 0 : 1, 2);
  for (const int sign : {-1, 1}) {
    const Triple normal = unit(sign * axes[0] - lean * kZ);
    const Triple impulse = load * ((sign * (1 + ratio * lean)) * axes[0] + (ratio - lean) * kZ);
    const Triple point = (-0.5 * edge * sign) * axes[0];
    const double jaw = scene.mass_of(1);
    const bool presses = jaws == 2 || (jaws == 1 && sign < 0);
    const int outer = presses ? scene.finger(jaw, sign * axes[0], impulse, point) : kWorld;
    scene.patch(wedge, outer, each, least, side, point, normal, impulse, kReach * edge);
  }
}

}  // namespace
}  // namespace rest

namespace {

struct RestSettings {
  RestReading reading;

  void visit(auto&& field) {
    field("margin", reading.margin, RealRange{0, 1e4},
          "available over needed friction; below 1 rest is impossible; 0: drawn, from 1.02 to 100");
    field("nc_max", reading.nc_max, IntegerRange{3, 200}, "the most contacts that are aimed at");
  }
};

RestSet rest_set(const std::string& name, void (*build)(rest::Scene&), const std::string& summary) {
  RestSet set{name, name, summary, {build}};
  read_options_as<RestSettings>(set);
  set.parse = [](std::string_view owner, const Options& options) {
    const RestReading reading = parse_settings<RestSettings>(owner, options).reading;
    if (reading.margin <= 0.99 || reading.margin >= 1.01) return reading;
    throw InputError(std::string(owner) + ": margin: too near 1, where rounding decides");
  };
  return set;
}

}  // namespace

const std::vector<RestSet>& rest_sets() {
  using namespace rest;
  static const std::vector<RestSet> sets{
      rest_set("rest/clamp", build_clamp, "a row of bodies between two jaws"),
      rest_set("rest/grasp", build_grasp, "a body between fingers"),
      rest_set("rest/stack", build_stack, "boxes on one another, with slopes between them"),
      rest_set("rest/table", build_table, "a loaded table on a slope, on many legs"),
      rest_set("rest/wedge", build_wedge, "a wedge between two walls or jaws, or in a groove"),
  };
  return sets;
}

MadeSample draw_rest(const RestSet& set, const RestReading& reading, std::uint64_t seed, std::uint64_t trial) {
  rest::Scene scene(reading, {stream_id(set.stream), seed, trial});
  set.features.build(scene);
  return scene.finish();
}

}  // namespace lcpbench
