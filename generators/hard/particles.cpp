#include <algorithm>
#include <cmath>

#include "generators/hard/build.h"

namespace lcpbench::hard {
namespace {

// ---- one particle on the ground, in the plane: x along it, y up; friction columns +x, -x ----

template <int kQuarters>
struct ParticleDials {
  double mu = 0.5;
  double slip = kQuarters / 4.0;
  void visit(auto&& field) {
    field("mu", mu, RealRange{0, 1e6}, "friction coefficient");
    field("slip", slip, RealRange{0, 1e6}, "speed along the ground; it approaches with 1 m/s");
  }
};

/// A particle of mass 1 with velocity (slip, -approach): Coulomb's law by hand.
HardCase particle(double mu, double slip, double approach) {
  Contacts contacts(identity(2), {slip, -approach});
  contacts.add({0, 1}, mu, {{1, 0}});
  const double grip = mu * approach;
  const double friction = std::min(grip, slip);
  const double rest = slip - friction;
  HardTruth truth = solution({approach, 0, friction, rest}, HardUnique::kYes, kDefiniteInertia);
  const bool exact_friction = friction == slip || std::fma(mu, approach, -grip) == 0;
  truth.exact = exact_friction && slip - rest == friction;
  if (truth.exact) truth.velocity = {rest, 0};
  return contacts.with(truth);
}

HardCase make_sticking(const ParticleDials<1>& dials) { return particle(dials.mu, dials.slip, 1); }
HardCase make_sliding(const ParticleDials<8>& dials) { return particle(dials.mu, dials.slip, 1); }

using UlpsDial = IntegerDial<"ulps", 0, -1'000'000, 1'000'000, "mu is 3/4 plus so many units in its last place">;

HardCase make_friction_angle(UlpsDial ulps) {
  return particle(0.75 + static_cast<double>(ulps.value) * 0x1p-53, 3, 4);
}

HardCase make_zero_friction(SpeedDial scale) {
  const double unit_speed = power_of_two(scale.value);
  return particle(0, 2 * unit_speed, unit_speed);
}

HardCase make_huge_friction(IntegerDial<"bits", 27, 0, 300, "mu is 2^bits"> bits) {
  return particle(power_of_two(bits.value), 0.25, 1);
}

template <int kQuarters, Text kHelp = "friction coefficient">
struct FrictionDial {
  double mu = kQuarters / 4.0;
  void visit(auto&& field) { field("mu", mu, RealRange{0, 1e6}, kHelp.letters); }
};

// In space with the directions +x, +y, -x, -y and the velocity (1, 1, -1): half of the friction along each axis.
HardCase make_diagonal(const FrictionDial<2>& dials) {
  Contacts contacts(identity(3), {1, 1, -1});
  contacts.add({0, 0, 1}, dials.mu, {{1, 0, 0}, {0, 1, 0}});
  const double friction = std::min(dials.mu / 2, 1.0);
  const double rest = 1 - friction;
  HardTruth truth = solution({1, 0, 0, friction, friction, rest}, HardUnique::kYes, kDefiniteInertia);
  truth.exact = 1 - rest == friction;
  if (truth.exact) truth.velocity = {rest, rest, 0};
  return contacts.with(truth);
}

// ---- one particle between several surfaces ----

HardCase make_plates(SpeedDial scale) {
  const double speed = power_of_two(scale.value);
  Contacts contacts(identity(1), {-speed});
  contacts.add({1});
  contacts.add({-1});
  return contacts.with(solution({speed, 0}, HardUnique::kYes, kDefiniteInertia, {0}));
}

HardCase make_corner(SpeedDial scale) {
  const double speed = power_of_two(scale.value);
  Contacts contacts(identity(2), {-speed, -speed});
  for (const Numbers& normal : {Numbers{1, 0}, Numbers{-1, 0}, Numbers{0, 1}, Numbers{0, -1}}) contacts.add(normal);
  return contacts.with(solution({speed, 0, speed, 0}, HardUnique::kYes, kDefiniteInertia, {0, 0}));
}

// Normals of length 5, so that they are integers: impulses are a fifth of those of unit normals.
HardCase make_wedge(const FrictionDial<3, "friction coefficient; from 3/4 on the groove locks">& dials) {
  Contacts contacts(identity(2), {0, -5});
  contacts.add({3, 4}, dials.mu, {{4, -3}});
  contacts.add({-3, 4}, dials.mu, {{4, 3}});
  return contacts.with(
      solution({0.625, 0.625, 0, 0, 0, 0, 0, 0}, HardUnique::kUnknown, kDefiniteInertia, {0, 0}));
}

HardCase make_near_duplicate(IntegerDial<"bits", 25, 1, 50, "the second normal is (2^-bits, 1)"> bits) {
  const double offset = power_of_two(-bits.value);
  Contacts contacts(identity(2), {-offset / 2, -1});
  contacts.add({0, 1});
  contacts.add({offset, 1});
  return contacts.with(solution({0.5, 0.5}, HardUnique::kYes, kDefiniteInertia, {0, 0}));
}

// ---- one body in the plane: x, y, turn ----

// A disc held between two fingers at (-1, 0) and (1, 0), falling with 1 m/s: nothing presses, so that it may fall on;
// an internal force may also stop it.
HardCase make_grasp(const FrictionDial<2>& dials) {
  Contacts contacts(identity(3), {0, -1, 0});
  contacts.add({1, 0, 0}, dials.mu, {{0, 1, -1}});
  contacts.add({-1, 0, 0}, dials.mu, {{0, 1, 1}});
  return contacts.with(solution({0, 0, 0, 0, 0, 0, 1, 1}, dials.mu > 0 ? HardUnique::kNo : HardUnique::kYes,
                                "it falls on without impulses", {0, -1, 0}));
}

// Normal acceleration of the contact per unit of normal force while a rod at the slope 3 : 4 slides: 25 times
// 1 + 3 c (c - mu s) with c = 3/5, s = 4/5.
HardCase make_painleve_acceleration(const FrictionDial<8>& dials) {
  const Table M = matrix({{52 - 36 * dials.mu}});
  const Numbers q{-25};
  if (M(0, 0) <= 0) return lcp(M, q, unsolvable({1}, "q < 0 and M <= 0: every force presses the rod further in"));
  return lcp(M, q, rounded_solution({25 / M(0, 0)}, HardUnique::kYes, "z = -q / M"));
}

// The same rod in impulses: arms and directions times 5, G^-1 = diag(1, 1, 3). It sticks when mu >= 88/109.
HardCase make_painleve_impulse(const FrictionDial<8>& dials) {
  constexpr double kSpeed = 500.0 / 1024;
  constexpr double kNormal = 109.0 / 1024;
  constexpr double kFriction = 88.0 / 1024;
  Contacts contacts(matrix({{1, 0, 0}, {0, 1, 0}, {0, 0, 3}}), {-kSpeed, -kSpeed, 0}, InertiaForm::kInverse);
  contacts.add({0, 5, -3}, dials.mu, {{5, 0, 4}});
  if (109 * dials.mu < 88) return contacts.with(solvable(HardUnique::kUnknown, kDefiniteInertia));
  const double spin = 3 * (4 * kFriction - 3 * kNormal);
  return contacts.with(solution({kNormal, kFriction, 0, 0}, HardUnique::kUnknown, kDefiniteInertia,
                                {5 * kFriction - kSpeed, 5 * kNormal - kSpeed, spin}));
}

HardCase make_thin_rod(IntegerDial<"bits", 40, 0, 100, "the moment of inertia is 2^-bits"> bits) {
  Contacts contacts(matrix({{1, 0}, {0, power_of_two(-bits.value)}}), {-1, 0});
  contacts.add({1, 1});
  contacts.add({1, -1});
  return contacts.with(solution({0.5, 0.5}, HardUnique::kYes, kDefiniteInertia, {0, 0}));
}

// ---- inertia of reduced rank: G = diag(1, 0) ----

HardCase make_massless(SpeedDial scale) {
  Contacts contacts = Contacts::reduced(matrix({{1}, {0}}), {0, -power_of_two(scale.value)});
  contacts.add({0, 1});
  return contacts.with(unsolvable({1}, "the normal is in the null space of G and approaches: no impulse changes that"));
}

HardCase make_nearly_massless(IntegerDial<"bits", 10, 0, 26, "the normal is (2^-bits, 1)"> bits) {
  const double tilt = power_of_two(-bits.value);
  Contacts contacts = Contacts::reduced(matrix({{1}, {0}}), {0, -1});
  contacts.add({tilt, 1});
  return contacts.with(solution({power_of_two(2 * bits.value)}, HardUnique::kYes, "M = 4^-bits > 0",
                                {power_of_two(bits.value), -1}));
}

}  // namespace

std::vector<HardSet> particle_sets() {
  return {
#include "generators/hard/particles.inc"
  };
}

}  // namespace lcpbench::hard
