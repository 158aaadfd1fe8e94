#include <algorithm>

#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

/// A box with k x k contacts below it, spread evenly over [-1, 1]^2 at the depth `depth` under its centre, in units of
/// its own: mass and moments of inertia 1 and length 1, each times a power of two.
/// Coordinates: velocity x, y, z, then turn about x, y, z. Friction directions +x, +y, -x, -y.
struct Box {
  std::size_t k = 2;
  double depth = 0;
  bool frictional = false;
  double mu = 0;
  double mass = 1;
  double length = 1;

  std::size_t points() const { return k * k; }
  /// Of point i in x, i % k, or y, i / k; exactly antisymmetric.
  double place(std::size_t index) const {
    return (2 * static_cast<double>(index) - static_cast<double>(k - 1)) / static_cast<double>(k - 1);
  }
  double x(std::size_t point) const { return place(point % k); }
  double y(std::size_t point) const { return place(point / k); }

  /// @param v  in the units of a box of length 1
  HardCase fall(Numbers v, HardTruth truth) const;
  /// z with normal impulses at the four corners only (at_rear at x = -1, at_front at x = 1), and friction along -x.
  Numbers corner_impulses(double at_rear, double at_front, double friction_per_normal) const;
};

HardCase Box::fall(Numbers v, HardTruth truth) const {
  Table inertia(6, 6);
  for (std::size_t i = 0; i < 3; ++i) {
    inertia(i, i) = mass;
    inertia(3 + i, 3 + i) = mass * length * length;
    v[i] *= length;
  }
  Contacts contacts(inertia, v);
  for (std::size_t point = 0; point < points(); ++point) {
    const double px = length * x(point);
    const double py = length * y(point);
    const double pz = -length * depth;
    const Numbers normal{0, 0, 1, py, -px, 0};
    if (!frictional) {
      contacts.add(normal);
      continue;
    }
    contacts.add(normal, mu, {{1, 0, 0, 0, pz, -py}, {0, 1, 0, -pz, 0, px}});
  }
  truth.z = scaled(std::move(truth.z), mass * length);
  for (std::size_t i = 0; i < std::min<std::size_t>(3, truth.velocity.size()); ++i) truth.velocity[i] *= length;
  return contacts.with(std::move(truth));
}

Numbers Box::corner_impulses(double at_rear, double at_front, double friction_per_normal) const {
  constexpr std::size_t kEdges = 4;
  constexpr std::size_t kAgainstX = 2;
  Numbers z(frictional ? points() * (kEdges + 2) : points());
  for (const std::size_t row : {std::size_t{0}, k - 1}) {
    for (const std::size_t column : {std::size_t{0}, k - 1}) {
      const std::size_t point = row * k + column;
      z[point] = column == 0 ? at_rear : at_front;
      if (frictional) z[points() + kEdges * point + kAgainstX] = friction_per_normal * z[point];
    }
  }
  return z;
}

using GridDial = IntegerDial<"k", 6, 2, 20, "contacts along a side, k^2 in all">;

HardCase make_falling(GridDial k) {
  const Box box{.k = k};
  const Numbers z = box.corner_impulses(0.25, 0.25, 0);
  return box.fall({0, 0, -1, 0, 0, 0}, solution(z, HardUnique::kYes, kDefiniteInertia, constant(6, 0)));
}

// The box turns with 1/2 and 1/4, and stops as a whole. The corner with the signs sx, sy gets the impulse in the loop.
HardCase make_tilted(GridDial k) {
  const Box box{.k = k};
  Numbers z(box.points());
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      const std::size_t column = sx < 0 ? 0 : box.k - 1;
      const std::size_t row = sy < 0 ? 0 : box.k - 1;
      z[row * box.k + column] = (1 - sx / 4) * (1 - sy / 2) / 4;
    }
  }
  return box.fall({0, 0, -1, 0.5, -0.25, 0}, solution(z, HardUnique::kYes, kDefiniteInertia, constant(6, 0)));
}

// The box turns with 2 and lands on the edge y = -1, with the impulse 3/4 at both corners; the others leave the ground.
HardCase make_on_edge(GridDial k) {
  const Box box{.k = k};
  Numbers z(box.points());
  z[0] = z[box.k - 1] = 0.75;
  return box.fall({0, 0, -1, 2, 0, 0}, solution(z, HardUnique::kYes, kDefiniteInertia, {0, 0, 0.5, 0.5, 0, 0}));
}

struct FrictionGridDials {
  std::int64_t k = 2;
  double mu = 0.5;
  void visit(auto&& field) {
    field("k", k, IntegerRange{2, 8}, "contacts along a side, k^2 in all");
    field("mu", mu, RealRange{0, 1e6}, "friction coefficient");
  }
  Box box() const { return {.k = static_cast<std::size_t>(k), .depth = 1, .frictional = true, .mu = mu}; }
};

HardCase make_box_sliding(const FrictionGridDials& dials) {
  return dials.box().fall({2, 0.5, -1, 0, 0, 0}, solvable(HardUnique::kUnknown, kDefiniteInertia));
}

HardCase make_spinning(const FrictionGridDials& dials) {
  return dials.box().fall({0, 0, -1, 0, 0, 1}, solvable(HardUnique::kUnknown, kDefiniteInertia));
}

HardCase make_at_rest(const FrictionGridDials& dials) {
  const Box box = dials.box();
  const Numbers z = constant(6 * box.points(), 0);
  return box.fall(constant(6, 0), solution(z, HardUnique::kUnknown, "q = 0", constant(6, 0)));
}

/// The velocity is 3 along x and 4 downward, at the friction angle of mu = 3/4. The box stops as a whole, and friction
/// at depth 1 shifts the load to the corners in front.
HardCase at_friction_angle(Box box) {
  constexpr double kShare = 0.75;  // of a corner's load that moves from the rear to the front
  constexpr double kSlope = 0.75;
  if (box.mu < kSlope) return box.fall({3, 0, -4, 0, 0, 0}, solvable(HardUnique::kUnknown, kDefiniteInertia));
  const Numbers z = box.corner_impulses(1 - kShare, 1 + kShare, kSlope);
  return box.fall({3, 0, -4, 0, 0, 0}, solution(z, HardUnique::kUnknown, kDefiniteInertia, constant(6, 0)));
}

struct AngleDials {
  std::int64_t k = 2;
  std::int64_t ulps = 0;
  void visit(auto&& field) {
    field("k", k, IntegerRange{2, 8}, "contacts along a side, k^2 in all");
    field("ulps", ulps, IntegerRange{-1'000'000, 1'000'000}, "mu is 3/4 plus so many units in its last place");
  }
};

HardCase make_box_friction_angle(const AngleDials& dials) {
  return at_friction_angle({.k = static_cast<std::size_t>(dials.k),
                            .depth = 1,
                            .frictional = true,
                            .mu = 0.75 + static_cast<double>(dials.ulps) * 0x1p-53});
}

struct UnitsDials {
  std::int64_t mass = 10;
  std::int64_t length = 10;
  void visit(auto&& field) {
    field("mass", mass, IntegerRange{-100, 100}, "the unit of mass is 2^-mass kg: 10 is close to grams");
    field("length", length, IntegerRange{kLeastSpeed, 100}, "the unit of length is 2^-length m: 10 is close to millimetres");
  }
};

HardCase make_units(const UnitsDials& dials) {
  return at_friction_angle({.k = 2,
                            .depth = 1,
                            .frictional = true,
                            .mu = 0.75,
                            .mass = power_of_two(dials.mass),
                            .length = power_of_two(dials.length)});
}

}  // namespace

std::vector<HardSet> box_sets() {
  return {
#include "generators/hard/boxes.inc"
  };
}

}  // namespace lcpbench::hard
