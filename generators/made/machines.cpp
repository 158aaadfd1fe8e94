#include <algorithm>

#include "generators/made/scene.h"

// Robots, hands, gears and tracks.

namespace lcpbench::made {

std::vector<Link> random_tree(Scene& scene, const Triple& root, int count, double link_length, int branches,
                              double lightest) {
  std::vector<Link> links;
  const int depth = (count + branches - 1) / branches;
  const auto signed_unit = [&] { return scene.uniform(-1, 1); };
  for (int k = 0; k < count; ++k) {
    Link link;
    link.parent = k < branches ? -1 : k - branches;
    const bool is_first = link.parent < 0;
    const Link& parent = is_first ? link : links[static_cast<std::size_t>(link.parent)];
    const Triple joint = is_first ? root : parent.joint + 2.0 * (parent.centre - parent.joint);
    const double above = joint[2] - root[2];
    const Triple level = turned_about_z(scene.uniform(0, 1))[0];
    const Triple heading = level + (0.2 * signed_unit() - above) * kZ;
    link.joint = joint;
    link.centre = joint + 0.5 * link_length * unit(heading);
    link.axis = unit(cross(heading, {signed_unit(), signed_unit(), 1.5}));
    link.mass = 5 * power(lightest, (k / branches + 1.0) / depth);
    links.push_back(link);
  }
  return links;
}

// A train of turning gears on pins. Of the tooth in mesh one flank touches, or both where there is no play.
void build_gears(Scene& scene) {
  const double chance_of_both = scene.chance(0.3) ? 0 : scene.uniform(0, 1);
  const int gears = Scene::count(scene.goal() / (7 + chance_of_both), 2);
  const double spin = scene.log_uniform(0.1, 10);
  const auto [c, s] = cos_sin(20.0 / 360);  // of the pressure angle
  Triple centre{};
  double last_radius = 0;
  int last = kWorld;
  for (int k = 0; k < gears; ++k) {
    const double radius = scene.uniform(0.1, 0.3);
    // In the plane of x and z, with the pins along y.
    const Axes towards = turned_about_y(scene.uniform(-0.2, 0.2));
    if (k > 0) centre = centre + (last_radius + radius) * towards[0];
    const int gear = scene.box(scene.mass(5000 * radius * radius * 0.03), {1.6 * radius, 0.03, 1.6 * radius}, centre);
    scene.move(gear, -0.05 * kZ, ((k % 2 == 0 ? spin : -spin) * 0.2 / radius) * kY);
    for (const Triple& outward : {kX, -kX, kZ, -kZ}) {
      const double side = scene.uniform(-0.015, 0.015);
      scene.touch(gear, kWorld, centre + 0.02 * outward + side * kY, -outward);
    }
    for (const double side : {-1.0, 1.0}) scene.touch(gear, kWorld, centre + side * 0.015 * kY + 0.02 * kX, -side * kY);
    if (k > 0) {
      const Triple tooth = centre - radius * towards[0];
      const bool both = scene.chance(chance_of_both);
      for (const double flank : {-1.0, 1.0}) {
        if (flank > 0 && !both) continue;
        scene.touch(gear, last, tooth + flank * 0.01 * towards[2], s * towards[0] + flank * c * towards[2]);
      }
    }
    last = gear;
    last_radius = radius;
  }
}

// Fingers around a ball: chains of lighter and lighter links on a palm that is free or held.
void build_hand(Scene& scene) {
  const int points = Scene::count(scene.goal(), 6);
  const int fingers = scene.integer(2, 5);
  const int joints = std::min(scene.integer(2, 12), std::max(points / fingers, 2));
  const double condition = scene.log_uniform(1e2, 1e6);
  const double radius = 0.05;
  std::vector<Link> links;
  for (int f = 0; f < fingers; ++f) {
    const Axes around = turned_about_z((f + scene.uniform(-0.1, 0.1)) / fingers);
    const auto at = [&](double k) {  // on a sphere about the ball, from below upwards
      const auto [c, s] = cos_sin(-0.2 + 0.4 * k / joints);
      return 1.2 * radius * (c * around[0] + s * kZ);
    };
    for (int k = 0; k < joints; ++k) {
      Link link;
      link.parent = k == 0 ? -1 : static_cast<int>(links.size()) - 1;
      link.joint = at(k);
      link.centre = at(k + 0.5);
      link.axis = k % 4 == 1 ? unit(around[0] + 0.3 * kZ) : around[1];
      link.mass = 0.1 * power(1 / condition, (k + 1.0) / joints);
      links.push_back(link);
    }
  }
  const int palm = scene.robot(1, -0.08 * kZ, scene.chance(0.5), links, condition);
  const int ball = scene.sphere(scene.mass(0.2), radius, {});
  for (int k = 0; k < points; ++k) {
    const int link = palm + 1 + k % static_cast<int>(links.size());
    const auto near = [&] { return scene.uniform(-0.3, 0.3); };
    const Triple outward = unit(unit(scene.centre(link)) + Triple{near(), near(), near()});
    scene.touch(link, ball, radius * outward, outward);
  }
}

// Robots with equally many links on one another: each part touches the part of the robot below that is nearest in plan.
void build_ragdolls(Scene& scene) {
  const int link_count = scene.goal() < 30 ? 6 : scene.integer(6, 20);
  const int robots = Scene::count(scene.goal() / (link_count + 1), 2);
  const double condition = scene.log_uniform(1e2, 1e6);
  int below = kWorld;
  for (int r = 0; r < robots; ++r) {
    const Triple root{scene.uniform(-0.2, 0.2), scene.uniform(-0.2, 0.2), 0.1 + 0.2 * r};
    const std::vector<Link> links = random_tree(scene, root, link_count, 0.3, 5, 1 / condition);
    const int robot = scene.robot(scene.mass(20), root, true, links, condition);
    for (int k = 0; k <= link_count; ++k) {
      const Triple centre = scene.centre(robot + k);
      int partner = below;
      for (int other = 0; below != kWorld && other <= link_count; ++other) {
        const auto gap = [&](int part) {
          const Triple apart = scene.centre(part) - centre;
          return apart[0] * apart[0] + apart[1] * apart[1];
        };
        if (gap(below + other) < gap(partner)) partner = below + other;
      }
      const Triple normal = unit(kZ + Triple{scene.uniform(-0.4, 0.4), scene.uniform(-0.4, 0.4), 0});
      scene.touch(robot + k, partner, centre - 0.1 * normal, partner == kWorld ? kZ : normal);
    }
    below = robot;
  }
}

// A robot with 10 to 200 coordinates that lies on uneven ground, each link once before any part touches it again.
void build_robot(Scene& scene) {
  const int points = Scene::count(scene.goal(), 4);
  const int link_count = Scene::count(std::min(scene.log_uniform(4, 195), 4.0 * points), 4);
  const double condition = scene.log_uniform(1e2, 1e6);
  const std::vector<Link> links = random_tree(scene, {}, link_count, 0.2, scene.integer(1, 6), 1 / condition);
  const int robot = scene.robot(scene.mass(20), {}, true, links, condition);
  const double tilt = scene.uniform(0, 0.4);
  for (int k = 0; k < points; ++k) {
    const int link = robot + (k < link_count ? k + 1 : scene.integer(0, link_count));
    const Triple normal = unit(kZ + Triple{scene.uniform(-tilt, tilt), scene.uniform(-tilt, tilt), 0});
    const Triple side{scene.uniform(-0.08, 0.08), scene.uniform(-0.08, 0.08), 0};
    scene.touch(link, kWorld, scene.centre(link) + side - 0.05 * normal, normal);
  }
}

// A vehicle: a hull on wheels, the wheels on two chains of shoes.
void build_tracks(Scene& scene) {
  const int shoes = Scene::count(scene.goal() / 16, 1);
  const double size = 0.15;
  const int hull = scene.box(scene.mass(500 * shoes), {size * shoes, 1.2, 0.4}, {0.5 * size * (shoes - 1), 0, 0.6});
  for (const double side : {-0.7, 0.7}) {
    int last = kWorld;
    for (int k = 0; k < shoes; ++k) {
      const Triple centre{size * k, side, 0.02};
      const int shoe = scene.box(scene.mass(10), {0.9 * size, 0.3, 0.04}, centre);
      scene.touch_face(shoe, kWorld, centre - 0.02 * kZ, kZ, 0.45 * size * kX, 0.15 * kY);
      if (last != kWorld) {
        for (const double end : {-0.12, 0.12}) {
          scene.touch(shoe, last, {size * (k - 0.5), side + end, 0.02}, -1.0 * kX);
        }
        scene.touch(shoe, last, {size * (k - 0.5), side, 0.02}, kZ);
      }
      if (k % 2 == 0) {
        const Triple axle{size * k, side, 0.04 + 0.15};
        const int wheel = scene.box(scene.mass(20), {0.21, 0.1, 0.21}, axle);
        scene.touch(wheel, shoe, axle - 0.15 * kZ, kZ);
        const auto [c, s] = cos_sin(0.1);
        for (const double along : {-1.0, 0.0, 1.0}) {
          const Triple up = unit(c * kZ + along * s * kX);
          scene.touch(hull, wheel, axle + 0.03 * up + 0.04 * along * kY, up);
        }
      }
      last = shoe;
    }
  }
}

}  // namespace lcpbench::made
