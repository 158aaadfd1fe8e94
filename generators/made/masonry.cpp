#include <cmath>

#include "generators/made/scene.h"

// Blocks, planks and cards on one another: two or four contacts where two of them touch.

namespace lcpbench::made {

// Boxes along a half circle of radius 1 m between two abutments: four contacts at each joint.
void build_arch(Scene& scene) {
  const int blocks = Scene::count(scene.goal() / 4 - 1, 2);
  const double thickness = scene.uniform(0.1, 0.3);
  const double width = scene.uniform(0.1, 0.5);
  const double block_length = 3.14 / blocks;
  int last = kWorld;
  for (int k = 0; k <= blocks; ++k) {
    const Axes joint = turned_about_y(0.5 * k / blocks);
    const Axes middle = turned_about_y(0.5 * (k + 0.5) / blocks);
    const int next = k == blocks ? kWorld
                                 : scene.box(scene.mass(2400 * thickness * width * block_length),
                                             {thickness, width, block_length}, middle[0], middle);
    const Triple along = thickness / 2 * joint[0];
    const Triple across = width / 2 * kY;
    if (next == kWorld) {
      scene.touch_face(last, kWorld, joint[0], -joint[2], along, across);
    } else {
      scene.touch_face(next, last, joint[0], joint[2], along, across);
    }
    last = next;
  }
}

// Planks on girders that lie on two abutments, and loads on the planks.
void build_bridge(Scene& scene) {
  const int girders = scene.integer(2, scene.goal() < 100 ? 2 : 6);
  const int planks = Scene::count((scene.goal() - 4 * girders) / (2 * girders + 1), 1);
  const double span = 0.25 * planks;
  const double spacing = scene.uniform(0.4, 1);
  const double reach = spacing * (girders - 1);
  std::vector<int> beams;
  for (int g = 0; g < girders; ++g) {
    const double y = spacing * g;
    beams.push_back(scene.box(scene.mass(20 * span), {span + 0.4, 0.1, 0.2}, {span / 2, y, -0.1}));
    for (const double x : {-0.1, span + 0.1}) {
      for (const double side : {-0.05, 0.05}) scene.touch(beams.back(), kWorld, {x, y + side, -0.2}, kZ, true);
    }
  }
  int load = kWorld;
  for (int p = 0; p < planks; ++p) {
    const double x = 0.25 * (p + 0.5);
    const int plank = scene.box(scene.mass(8 * reach), {0.2, reach + 0.2, 0.04}, {x, reach / 2, 0.02});
    for (int g = 0; g < girders; ++g) {
      for (const double side : {-0.1, 0.1}) {
        scene.touch(plank, beams[static_cast<std::size_t>(g)], {x + side, spacing * g, 0}, kZ, true);
      }
    }
    if (p % 4 == 0) {
      const Triple centre{x + 0.125, scene.uniform(0.2, 0.8) * reach, 0.14};
      load = scene.box(scene.mass(50), {0.3, 0.2, 0.2}, centre);
    }
    if (p % 4 > 1) continue;
    for (const double side : {-0.1, 0.1}) {
      scene.touch(load, plank, {x, scene.centre(load)[1] + side, 0.04}, kZ, true);
    }
  }
}

// A house of cards: storeys of leaning pairs, and flat cards from pair to pair.
void build_cards(Scene& scene) {
  const int storeys = Scene::count(std::sqrt(scene.goal() / 5), 2);
  const double lean = scene.uniform(0.03, 0.08);
  const double depth = 0.06;
  const auto [height, half] = cos_sin(lean);
  const Triple card{0.0003, depth, 1};
  const double weight = 0.05;
  std::vector<int> floor;
  for (int storey = 0; storey < storeys; ++storey) {
    const int pairs = storeys - storey;
    const double low = (height + 0.001) * storey;
    const Triple across = depth / 2 * kY;
    std::vector<int> right_cards;
    std::vector<int> next_floor;
    const auto touch_edge = [&](int a, int b, const Triple& at, const Triple& normal) {
      scene.touch(a, b, at - across, normal);
      scene.touch(a, b, at + across, normal);
    };
    for (int k = 0; k < pairs; ++k) {
      const double middle = (2 * k + storey) * half;
      const int below = storey == 0 ? kWorld : floor[static_cast<std::size_t>(k)];
      const int left = scene.box(scene.mass(weight), card, {middle - half / 2, 0, low + height / 2},
                                 turned_about_y(-lean));
      const int right = scene.box(scene.mass(weight), card, {middle + half / 2, 0, low + height / 2},
                                  turned_about_y(lean));
      touch_edge(left, below, {middle - 0.98 * half, 0, low}, kZ);
      touch_edge(right, below, {middle + 0.98 * half, 0, low}, kZ);
      touch_edge(right, left, {middle, 0, low + height}, kX);
      if (k > 0) {
        const int flat = scene.box(scene.mass(weight), {2 * half, depth, 0.001}, {middle - half, 0, low + height});
        touch_edge(flat, right_cards.back(), {middle - 1.98 * half, 0, low + height}, kZ);
        touch_edge(flat, left, {middle - 0.02 * half, 0, low + height}, kZ);
        next_floor.push_back(flat);
      }
      right_cards.push_back(right);
    }
    floor = next_floor;
  }
}

// Rings of blocks, each block on two blocks of the ring below and beside its neighbours.
void build_dome(Scene& scene) {
  const double blocks = scene.goal() / 6;
  const int rings = Scene::count(std::sqrt(blocks / 3), 1);
  const int segments = Scene::count(blocks / rings, 3);
  const double thickness = scene.uniform(0.05, 0.2);
  const double opening = scene.uniform(0.16, 0.24);  // turns from the ground to the top ring
  const double block_height = 6.28 * opening / rings;
  // Radial, along the ring, and along the meridian.
  const auto axes_at = [&](double around, double up) {
    const Axes ring = turned_about_z(around);
    const auto [c, s] = cos_sin(up);
    return Axes{c * ring[0] + s * kZ, ring[1], c * kZ - s * ring[0]};
  };
  std::vector<int> below;
  for (int r = 0; r < rings; ++r) {
    const double low = opening * r / rings;
    const double middle = opening * (r + 0.5) / rings;
    const auto around = [&](double k) { return (k + 0.5 * r) / segments; };
    std::vector<int> ring;
    for (int k = 0; k < segments; ++k) {
      const Axes axes = axes_at(around(k + 0.5), middle);
      const double block_width = 6.28 / segments * cos_sin(middle)[0];
      const double volume = thickness * block_width * block_height;
      ring.push_back(scene.box(scene.mass(2400 * volume), {thickness, block_width, block_height}, axes[0], axes));
    }
    for (int k = 0; k < segments; ++k) {
      const int own = ring[static_cast<std::size_t>(k)];
      const int neighbour = ring[static_cast<std::size_t>((k + 1) % segments)];
      for (const double side : {-0.4, 0.4}) {
        const double radius = 1 + side * thickness;
        for (const int half : {0, 1}) {
          const Axes bed = axes_at(around(k + 0.25 + 0.5 * half), low);
          const int lower = r == 0 ? kWorld : below[static_cast<std::size_t>((k + half) % segments)];
          scene.touch(own, lower, radius * bed[0], bed[2]);
        }
        const Axes head = axes_at(around(k + 1), middle);
        scene.touch(neighbour, own, radius * head[0], head[1]);
      }
    }
    below = ring;
  }
}

// Courses of stones of random lengths, with rough faces, each contact with a friction coefficient of its own.
void build_drystone(Scene& scene) {
  scene.roughen();
  const double stones = scene.goal() / 8.5;
  const int courses = Scene::count(std::sqrt(stones / scene.uniform(1, 3)), 2);
  const double wall = stones / courses < 1 ? 1 : stones / courses;
  const double depth = scene.uniform(0.3, 1);
  struct Stone {
    int body;
    double begin, end;
  };
  const auto rough = [&](const Triple& normal) {
    return unit(normal + Triple{scene.uniform(-0.1, 0.1), scene.uniform(-0.1, 0.1), scene.uniform(-0.1, 0.1)});
  };
  std::vector<Stone> below{{kWorld, -1, wall + 1}};
  for (int course = 0; course < courses; ++course) {
    std::vector<Stone> stones_here;
    for (double begin = 0; begin < wall;) {
      double end = begin + scene.uniform(0.6, 1.4);
      if (end > wall - 0.6) end = wall < begin + 0.6 ? begin + 0.6 : wall;
      const double size = end - begin;
      const Triple centre{(begin + end) / 2, scene.uniform(-0.02, 0.02), 0.5 * course + 0.25};
      const int body = scene.box(scene.mass(1000 * depth * size), {size, depth, 0.5}, centre);
      for (const Stone& lower : below) {
        const double left = begin > lower.begin ? begin : lower.begin;
        const double right = end < lower.end ? end : lower.end;
        if (right - left < 0.1) continue;
        for (const double x : {left + 0.03, right - 0.03}) {
          for (const double y : {-0.45, 0.45}) scene.touch(body, lower.body, {x, y * depth, 0.5 * course}, rough(kZ));
        }
      }
      if (!stones_here.empty() && scene.chance(0.6)) {
        const double z = 0.5 * course + scene.uniform(0.1, 0.4);
        for (const double y : {-0.4, 0.4}) scene.touch(body, stones_here.back().body, {begin, y * depth, z}, rough(kX));
      }
      stones_here.push_back({body, begin, end});
      begin = end;
    }
    below = stones_here;
  }
}

// Boxes on one another, of masses in any order or heavier and heavier.
void build_tower(Scene& scene) {
  const int boxes = Scene::count(scene.goal() / 4, 2);
  const bool is_sorted = scene.chance(0.5);
  int below = kWorld;
  double height = 0;
  for (int k = 0; k < boxes; ++k) {
    const double tall = scene.uniform(0.1, 0.4);
    const Triple centre{scene.uniform(-0.05, 0.05), scene.uniform(-0.05, 0.05), height + tall / 2};
    const double any = scene.mass(1);
    const int box = scene.box(is_sorted ? scene.graded_mass(1, (k + 1.0) / boxes) : any, {1, 1, tall}, centre);
    scene.touch_face(box, below, {0, 0, height}, kZ, 0.4 * kX, 0.4 * kY, true);
    height += tall;
    below = box;
  }
}

}  // namespace lcpbench::made
