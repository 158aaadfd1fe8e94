#include <algorithm>
#include <cmath>

#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- stacks ----

enum class Order { kHeavyTop, kHeavyBottom, kAlternateLightFirst, kAlternateHeavyFirst, kGrowing };

const Choices<Order> kOrders{{{"heavy_top", Order::kHeavyTop},
                              {"heavy_bottom", Order::kHeavyBottom},
                              {"light_heavy", Order::kAlternateLightFirst},
                              {"heavy_light", Order::kAlternateHeavyFirst},
                              {"growing", Order::kGrowing}}};

/// Masses of a stack from the ground up: 1 and 2^ratio, or powers of two between them.
Numbers stack_masses(std::int64_t k, std::int64_t ratio, Order order) {
  Numbers masses;
  for (std::int64_t i = 0; i < k; ++i) {
    const bool heavy = order == Order::kHeavyTop              ? i == k - 1
                       : order == Order::kHeavyBottom         ? i == 0
                       : order == Order::kAlternateLightFirst ? i % 2 == 1
                                                              : i % 2 == 0;
    const std::int64_t exponent = order == Order::kGrowing ? ratio * i / std::max<std::int64_t>(1, k - 1)
                                  : heavy                  ? ratio
                                                           : 0;
    masses.push_back(power_of_two(exponent));
  }
  return masses;
}

/// The load of each contact: the sum of the masses above it, and so the impulse that stops them at 1 m/s.
Numbers loads(const Numbers& masses) {
  Numbers sums = masses;
  for (std::size_t i = masses.size() - 1; i-- > 0;) sums[i] += sums[i + 1];
  return sums;
}

Table diagonal(const Numbers& values) {
  Table D(values.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) D(i, i) = values[i];
  return D;
}

/// 1 at `up`, -1 at `down` where there is one.
Numbers difference(std::size_t size, std::size_t up, std::optional<std::size_t> down) {
  Numbers column = unit(size, up);
  if (down) column[*down] = -1;
  return column;
}

/// The body below the i-th; none: the ground.
std::optional<std::size_t> below(std::size_t i) { return i > 0 ? std::optional<std::size_t>(i - 1) : std::nullopt; }

template <std::int64_t kBodies, std::int64_t kMaxRatio>
struct StackDials {
  std::int64_t k = kBodies;
  std::int64_t ratio = 20;
  Order order = Order::kHeavyTop;
  void visit(auto&& field) {
    field("k", k, IntegerRange{1, 32}, "bodies");
    field("ratio", ratio, IntegerRange{0, kMaxRatio}, "the heaviest mass is 2^ratio times the lightest; 40 is 1e12");
    field("order", order, kOrders, "from the ground up; growing: evenly in the logarithm");
  }
};

HardCase make_stack(const StackDials<8, 46>& dials) {
  const Numbers masses = stack_masses(dials.k, dials.ratio, dials.order);
  const std::size_t k = masses.size();
  Contacts contacts(diagonal(masses), constant(k, -1));
  for (std::size_t i = 0; i < k; ++i) contacts.add(difference(k, i, below(i)));
  return contacts.with(solution(loads(masses), HardUnique::kYes, kDefiniteInertia, constant(k, 0)));
}

struct FrictionStackDials : StackDials<5, 40> {
  double mu = 0.5;
  double slip = 0.25;
  void visit(auto&& field) {
    StackDials::visit(field);
    field("mu", mu, RealRange{0, 1e6}, "friction coefficient of every contact");
    field("slip", slip, RealRange{0, 1e6}, "speed of the whole stack along the ground; it falls with 1 m/s");
  }
};

// Plates with two coordinates each, x along the ground and y upwards. The stack moves as one body. The ratio of
// friction to load is the same at all contacts, and only the contact with the ground slides. z has the normal impulses,
// two friction impulses for each contact, and the lambda of each contact.
HardCase make_friction_stack(const FrictionStackDials& dials) {
  const Numbers masses = stack_masses(dials.k, dials.ratio, dials.order);
  const std::size_t k = masses.size();
  Numbers doubled;
  Numbers v;
  for (const double mass : masses) {
    doubled.insert(doubled.end(), {mass, mass});
    v.insert(v.end(), {dials.slip, -1});
  }
  Contacts contacts(diagonal(doubled), v);
  for (std::size_t i = 0; i < k; ++i) {
    const auto lower = below(i);
    const auto coordinate = [&](std::size_t axis) {
      return difference(2 * k, 2 * i + axis, lower ? std::optional<std::size_t>(2 * *lower + axis) : std::nullopt);
    };
    contacts.add(coordinate(1), dials.mu, {coordinate(0)});
  }
  const double lost = std::min(dials.mu, dials.slip);
  const double rest = dials.slip - lost;
  const Numbers load = loads(masses);
  Numbers z(4 * k);
  bool exact = dials.slip - rest == lost;
  for (std::size_t i = 0; i < k; ++i) {
    z[i] = load[i];
    z[k + 2 * i + 1] = lost * load[i];
    exact = exact && std::fma(lost, load[i], -z[k + 2 * i + 1]) == 0;
  }
  z[3 * k] = rest;
  HardTruth truth = solution(z, HardUnique::kUnknown, kDefiniteInertia);
  truth.exact = exact;
  if (exact) {
    for (std::size_t i = 0; i < k; ++i) truth.velocity.insert(truth.velocity.end(), {rest, 0});
  }
  return contacts.with(truth);
}

// ---- rows and rings ----

// All particles move to the wall on the left, which stops them. The wall on the right may push as well: the velocity is
// unique, the impulses are not.
HardCase make_jammed_row(IntegerDial<"k", 8, 1, 200, "bodies"> k) {
  Contacts contacts(identity(k), constant(k, -1));
  for (std::size_t i = 0; i < k; ++i) contacts.add(difference(k, i, below(i)));
  contacts.add(scaled(unit(k, k - 1), -1));
  const Numbers z = joined(loads(constant(k, 1)), {0});
  return contacts.with(solution(z, HardUnique::kYes, kDefiniteInertia, constant(k, 0)));
}

struct Direction {
  double x;
  double y;
};

double on_grid(double value) { return std::round(value * 0x1p40) * 0x1p-40; }

/// Directions of the 3 * 2^doublings edges of a regular polygon, rounded to multiples of 2^-40, so that sums are exact:
/// those of a triangle, then repeatedly the bisectors of neighbours. Only operations that IEEE rounds correctly.
std::vector<Direction> polygon(std::size_t doublings) {
  const double height = std::sqrt(0.75);
  std::vector<Direction> edges{{1, 0}, {-0.5, height}, {-0.5, -height}};
  for (std::size_t i = 0; i < doublings; ++i) {
    std::vector<Direction> finer;
    for (std::size_t j = 0; j < edges.size(); ++j) {
      const Direction& next = edges[(j + 1) % edges.size()];
      const double x = edges[j].x + next.x;
      const double y = edges[j].y + next.y;
      const double length = std::sqrt(x * x + y * y);
      finer.push_back(edges[j]);
      finer.push_back({x / length, y / length});
    }
    edges = std::move(finer);
  }
  for (Direction& edge : edges) edge = {on_grid(edge.x), on_grid(edge.y)};
  return edges;
}

// Contact i pushes disc i + 1 along edge i, and disc i against it. The velocity is the one that unit impulses stop.
HardCase make_ring(IntegerDial<"doublings", 2, 0, 7, "3 times 2^doublings discs"> doublings) {
  const std::vector<Direction> edges = polygon(doublings);
  const std::size_t k = edges.size();
  Numbers v(2 * k);
  std::vector<Numbers> normals;
  for (std::size_t i = 0; i < k; ++i) {
    const std::size_t next = (i + 1) % k;
    Numbers normal(2 * k);
    normal[2 * i] = -edges[i].x;
    normal[2 * i + 1] = -edges[i].y;
    normal[2 * next] = edges[i].x;
    normal[2 * next + 1] = edges[i].y;
    for (std::size_t row = 0; row < 2 * k; ++row) v[row] -= normal[row];
    normals.push_back(std::move(normal));
  }
  Contacts contacts(identity(2 * k), v);
  for (const Numbers& normal : normals) contacts.add(normal);
  return contacts.with(solution(constant(k, 1), HardUnique::kYes, kDefiniteInertia, constant(2 * k, 0)));
}

}  // namespace

std::vector<HardSet> chain_sets() {
  return {
#include "generators/hard/chains.inc"
  };
}

}  // namespace lcpbench::hard
