// Bounded rows beside contacts: small mechanisms whose motion is worked out by hand, hard and soft, by themselves and
// in a scene of 100 other bodies.

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/answer/farkas.h"
#include "core/answer/lcp_error.h"
#include "tests/support/bounded_rows.h"
#include "tests/support/solving.h"

namespace lcpbench::bounded_rows_test {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// The numbers of a case are short fractions: what is left are a few roundings.
constexpr double kRounding = 1e-12;

/// What solvers may leave of an answer of size one.
constexpr double kFound = 1e-8;

using Numbers = std::vector<double>;

using testing::Row;

Row equality(Numbers direction, double b = 0) { return {.direction = std::move(direction), .b = b}; }
/// R'v+ >= speed.
Row at_least(Numbers direction, double speed) { return {.direction = std::move(direction), .lower = 0, .b = -speed}; }
/// R'v+ <= speed.
Row at_most(Numbers direction, double speed) { return {.direction = std::move(direction), .upper = 0, .b = -speed}; }
/// Takes R'v+ to `speed` as far as impulses between the limits do.
Row motor(Numbers direction, double speed, double lower, double upper) {
  return {.direction = std::move(direction), .lower = lower, .upper = upper, .b = -speed};
}
/// Dry friction, a brake, a clutch.
Row dry(Numbers direction, double limit) { return motor(std::move(direction), 0, -limit, limit); }
/// Friction of mu times the impulse of another row.
Row friction(Numbers direction, int load, double mu) {
  return {.direction = std::move(direction), .friction_of = load, .mu = mu};
}
Row soft(double compliance, Row row) {
  row.compliance = compliance;
  return row;
}
Row turning(Row row) {
  row.is_angle = true;
  return row;
}

struct Contact {
  Numbers normal;
  double mu = 0;
  std::vector<Numbers> tangents{};  ///< none, one (two edges) or two (four edges)
  double b = 0;
  double compliance = 0;  ///< along the normal and the tangents
  Numbers offset_t{};     ///< one along each tangent, or none
};

struct Case {
  std::string name;
  Numbers masses;
  Numbers v;
  std::vector<Contact> contacts{};
  std::vector<Row> rows{};
  // The right answer.
  Numbers after{};
  Numbers f_N{};
  Numbers f_T{};  ///< of each contact as many as it has tangents
  Numbers f_R{};
  bool impulses_are_unique = true;  ///< f_N and f_R
  Matrix G{};                       ///< none: that of the masses
};

/// Free bodies that move along one axis each, and wheels of radius 1 with mass 1 and inertia 1/2: (x, y, angle).
std::vector<Case> cases() {
  const std::vector<Numbers> along_x{{1, 0}};
  const Contact floor{.normal = {0, 1}, .mu = 0.25, .tangents = along_x};
  const auto road = [](double mu) { return Contact{.normal = {0, 1, 0}, .mu = mu, .tangents = {{1, 0, -1}}}; };
  const Numbers wheel{1, 1, 0.5};
  // A parallelogram of bars of length 1 at the angle whose cosine is 0.6: crank, coupler, rocker.
  const Row bars_x = turning(equality({-0.8, 0, 0.8})), bars_y = turning(equality({0.6, 1, -0.6}));
  // Threads of lead 0.1 m/rad: x - 0.1 angle >= 0, and their friction on the angle.
  const Row threads = at_least({1, -0.1}, 0);
  const auto thread_friction = [](double mu) { return turning(friction({0, 1}, 0, mu)); };
  // A finger (x), and an object (x, z) between it and a wall.
  const std::vector<Contact> grip{{.normal = {-1, 1, 0}, .mu = 0.5, .tangents = {{0, 0, 1}}},
                                  {.normal = {0, -1, 0}, .mu = 0.5, .tangents = {{0, 0, 1}}}};
  return {
      // --- dry friction, brakes, clutches ---
      // 0.1 - 0.03
      {.name = "a dry hinge slips", .masses = {1}, .v = {0.1}, .rows = {turning(dry({1}, 0.03))}, .after = {0.07},
       .f_R = {-0.03}},
      // 0.02 is below 0.03
      {.name = "a dry hinge sticks", .masses = {1}, .v = {0.02}, .rows = {turning(dry({1}, 0.03))}, .after = {0},
       .f_R = {-0.02}},
      // -1 + 0.5 / 2
      {.name = "a dry slider slips backwards", .masses = {2}, .v = {-1}, .rows = {dry({1}, 0.5)}, .after = {-0.75},
       .f_R = {0.5}},
      // 2 * 0.25 is the limit
      {.name = "a brake just holds", .masses = {2}, .v = {0.25}, .rows = {dry({1}, 0.5)}, .after = {0}, .f_R = {-0.5}},
      // (0.5 - 0.4375) / 2
      {.name = "a brake just does not hold", .masses = {2}, .v = {0.25}, .rows = {dry({1}, 0.4375)},
       .after = {0.03125}, .f_R = {-0.4375}},
      // f_N = 2 * 0.5, friction 0.25 and the brake's 0.25 are the 2 * 0.25 that is needed
      {.name = "brake and floor together just hold", .masses = {2, 2}, .v = {0.25, -0.5}, .contacts = {floor},
       .rows = {dry({1, 0}, 0.25)}, .after = {0, 0}, .f_N = {1}, .f_T = {-0.25}, .f_R = {-0.25}},
      // The same with 0.75: (0.75 * 2 - 0.5) / 2
      {.name = "brake and floor together do not hold", .masses = {2, 2}, .v = {0.75, -0.5}, .contacts = {floor},
       .rows = {dry({1, 0}, 0.25)}, .after = {0.5, 0}, .f_N = {1}, .f_T = {-0.25}, .f_R = {-0.25}},
      // The motor gives 1, the load's brake takes 0.4: 0.6 / 2 for both shafts; the second gets 0.4 + 0.3.
      {.name = "torque goes through a coupler", .masses = {1, 1}, .v = {0, 0},
       .rows = {turning(motor({1, 0}, 2, -1, 1)), turning(equality({1, -1})), turning(dry({0, 1}, 0.4))},
       .after = {0.3, 0.3}, .f_R = {1, -0.7, -0.4}},
      // The clutch passes 0.5 on: 1 - 0.5, 0.5 - 0.4.
      {.name = "a clutch slips", .masses = {1, 1}, .v = {0, 0},
       .rows = {turning(motor({1, 0}, 2, -1, 1)), turning(dry({1, -1}, 0.5)), turning(dry({0, 1}, 0.4))},
       .after = {0.5, 0.1}, .f_R = {1, -0.5, -0.4}},
      // --- limits ---
      // 2 (-1 + 3)
      {.name = "a lower limit", .masses = {2}, .v = {-3}, .rows = {at_least({1}, -1)}, .after = {-1}, .f_R = {4}},
      {.name = "a limit that is not reached", .masses = {2}, .v = {-0.5}, .rows = {at_least({1}, -1)},
       .after = {-0.5}, .f_R = {0}},
      // 2 (0.5 - 2)
      {.name = "an upper limit", .masses = {2}, .v = {2}, .rows = {at_most({1}, 0.5)}, .after = {0.5}, .f_R = {-3}},
      // Both limits of one joint, as two rows.
      {.name = "two limits", .masses = {2}, .v = {2}, .rows = {at_least({1}, -1), at_most({1}, 0.5)}, .after = {0.5},
       .f_R = {0, -3}},
      // Friction takes 0.3, the limit the rest of 0.6.
      {.name = "limit and dry friction", .masses = {1}, .v = {-1}, .rows = {dry({1}, 0.3), at_least({1}, -0.4)},
       .after = {-0.4}, .f_R = {0.3, 0.3}},
      {.name = "dry friction stops before the limit", .masses = {1}, .v = {-0.2},
       .rows = {dry({1}, 0.3), at_least({1}, -0.4)}, .after = {0}, .f_R = {0.2, 0}},
      // The limit is overrun and pushes out at 0.5, against the friction.
      {.name = "a preloaded limit", .masses = {1}, .v = {0}, .rows = {dry({1}, 0.3), at_least({1}, 0.5)},
       .after = {0.5}, .f_R = {-0.3, 0.8}},
      // f_N = 1: friction leaves -0.75, the limit -0.5.
      {.name = "a stop beside the friction of the floor", .masses = {1, 1}, .v = {-1, -1}, .contacts = {floor},
       .rows = {at_least({1, 0}, -0.5)}, .after = {-0.5, 0}, .f_N = {1}, .f_T = {0.25}, .f_R = {0.25}},
      // The tendon allows v_1 + v_2 <= 0.5: with f on both, 1 + f - 0.25 and 1 + f.
      {.name = "a tendon's limit beside the friction of the floor", .masses = {1, 1, 1}, .v = {1, -1, 1},
       .contacts = {{.normal = {0, 1, 0}, .mu = 0.25, .tangents = {{1, 0, 0}}}}, .rows = {at_most({1, 0, 1}, 0.5)},
       .after = {0.125, 0, 0.375}, .f_N = {1}, .f_T = {-0.25}, .f_R = {-0.625}},
      // The second shaft may not be slower.
      {.name = "a freewheel holds", .masses = {1, 1}, .v = {1, 0}, .rows = {turning(at_least({-1, 1}, 0))},
       .after = {0.5, 0.5}, .f_R = {0.5}},
      {.name = "a freewheel overruns", .masses = {1, 1}, .v = {0, 1}, .rows = {turning(at_least({-1, 1}, 0))},
       .after = {0, 1}, .f_R = {0}},
      // --- motors ---
      // w = v+ - 1 + f; v+ = f
      {.name = "a PD motor", .masses = {1}, .v = {0}, .rows = {soft(1, motor({1}, 1, -kNone, kNone))}, .after = {0.5},
       .f_R = {0.5}},
      {.name = "a PD motor at its effort limit", .masses = {1}, .v = {0}, .rows = {soft(1, motor({1}, 1, -0.2, 0.2))},
       .after = {0.2}, .f_R = {0.2}},
      {.name = "a PD motor at its limit pushes against a wall", .masses = {1}, .v = {0},
       .contacts = {{.normal = {-1}}}, .rows = {soft(1, motor({1}, 1, -0.2, 0.2))}, .after = {0}, .f_N = {0.2},
       .f_R = {0.2}},
      // w = 0 - 1 + f: without the limit it pushes with 1.
      {.name = "a PD motor pushes against a wall", .masses = {1}, .v = {0}, .contacts = {{.normal = {-1}}},
       .rows = {soft(1, motor({1}, 1, -5, 5))}, .after = {0}, .f_N = {1}, .f_R = {1}},
      // The wall is 0.1 h away.
      {.name = "a PD motor reaches a wall", .masses = {1}, .v = {0}, .contacts = {{.normal = {-1}, .b = 0.1}},
       .rows = {soft(1, motor({1}, 1, -0.2, 0.2))}, .after = {0.1}, .f_N = {0.1}, .f_R = {0.2}},
      {.name = "an asymmetric motor at its upper bound", .masses = {1}, .v = {0}, .rows = {motor({1}, 1, -0.1, 0.6)},
       .after = {0.6}, .f_R = {0.6}},
      {.name = "an asymmetric motor at its lower bound", .masses = {1}, .v = {3}, .rows = {motor({1}, 1, -0.1, 0.6)},
       .after = {2.9}, .f_R = {-0.1}},
      {.name = "an asymmetric motor between its bounds", .masses = {1}, .v = {0.75},
       .rows = {motor({1}, 1, -0.1, 0.6)}, .after = {1}, .f_R = {0.25}},
      // A motor that only pulls, beyond what it is asked for: it lets go.
      {.name = "a motor without a lower effort", .masses = {1}, .v = {3}, .rows = {motor({1}, 1, 0, 0.6)},
       .after = {3}, .f_R = {0}},
      // --- equalities ---
      {.name = "a redundant loop", .masses = {1, 1}, .v = {1, 0}, .rows = {equality({1, -1}), equality({1, -1})},
       .after = {0.5, 0.5}, .f_R = {-0.25, -0.25}, .impulses_are_unique = false},
      // 4 / (1 + 3); f_1 + 2 f_2 = -3
      {.name = "a redundant loop of scaled rows", .masses = {1, 3}, .v = {4, 0},
       .rows = {equality({1, -1}), equality({2, -2})}, .after = {1, 1}, .f_R = {-1, -1},
       .impulses_are_unique = false},
      // G = (2 1; 1 1), G* = (1 -1; -1 2): f = -0.5 on the second angle takes 2 * 0.5 from it and gives 0.5.
      {.name = "a double pendulum's locked elbow", .masses = {}, .v = {0, 1}, .rows = {turning(equality({0, 1}))},
       .after = {0.5, 0}, .f_R = {-0.5}, .G = Matrix{{2, 1}, {1, 1}}},
      // A correction of 0.5 between two equal masses.
      {.name = "a weld that drifted", .masses = {1, 1}, .v = {0, 0}, .rows = {equality({1, -1}, -0.5)},
       .after = {0.25, -0.25}, .f_R = {0.25}},
      // 1 + 2 f + 3 f = 0
      {.name = "a soft weld", .masses = {1, 1}, .v = {1, 0}, .rows = {soft(3, equality({1, -1}))},
       .after = {0.8, 0.2}, .f_R = {-0.2}},
      // v + f_1 = 0, v - 1 + f_2 = 0, v = f_1 + f_2
      {.name = "soft equalities that contradict each other", .masses = {1}, .v = {0},
       .rows = {soft(1, equality({1})), soft(1, equality({1}, -1))}, .after = {1.0 / 3}, .f_R = {-1.0 / 3, 2.0 / 3}},
      // -1 + f = -f
      {.name = "a soft limit", .masses = {1}, .v = {-1}, .rows = {soft(1, at_least({1}, 0))}, .after = {-0.5},
       .f_R = {0.5}},
      // 0.04 + f = -f: it creeps.
      {.name = "soft dry friction", .masses = {1}, .v = {0.04}, .rows = {soft(1, dry({1}, 0.03))}, .after = {0.02},
       .f_R = {-0.02}},
      // Equal speeds of crank and rocker, none of the coupler; -0.8 f_x + 0.6 f_y = -0.5, f_y = -0.5
      {.name = "a four-bar linkage", .masses = {1, 1, 1}, .v = {1, 0.5, 0}, .rows = {bars_x, bars_y},
       .after = {0.5, 0, 0.5}, .f_R = {0.25, -0.5}},
      // The same with the sum of both rows once more, as a loop in space has it.
      {.name = "a redundant four-bar linkage", .masses = {1, 1, 1}, .v = {1, 0.5, 0},
       .rows = {bars_x, bars_y, turning(equality({-0.2, 1, 0.2}))}, .after = {0.5, 0, 0.5},
       .f_R = {0.125, -0.625, 0.125}, .impulses_are_unique = false},
      // A push of 0.4 on the rocker, held by the crank's brake through the coupler: 0.4 - 0.8 * 0.5 on each side.
      {.name = "statics of a four-bar linkage", .masses = {1, 1, 1}, .v = {0, 0, 0.4},
       .rows = {bars_x, bars_y, turning(dry({1, 0, 0}, 0.5))}, .after = {0, 0, 0}, .f_R = {-0.5, 0, -0.4}},
      // The brake takes 0.1 only: 0.3 / 2 for both; the rocker loses 0.25.
      {.name = "a four-bar linkage that its brake does not hold", .masses = {1, 1, 1}, .v = {0, 0, 0.4},
       .rows = {bars_x, bars_y, turning(dry({1, 0, 0}, 0.1))}, .after = {0.15, 0, 0.15}, .f_R = {-0.3125, 0, -0.1}},
      // 2 (3 + 2 f) + 2 f = 0
      {.name = "a differential", .masses = {1, 1, 1}, .v = {3, 0, 0}, .rows = {turning(equality({2, -1, -1}))},
       .after = {1, 1, 1}, .f_R = {-1}},
      // 6 + 6 f + 0.3 = 0
      {.name = "a differential with one wheel braked", .masses = {1, 1, 1}, .v = {3, 0, 0},
       .rows = {turning(equality({2, -1, -1})), turning(dry({0, 0, 1}, 0.3))}, .after = {0.9, 1.05, 0.75},
       .f_R = {-1.05, -0.3}},
      // The same 0.3 by a fixed road under a wheel of radius 1.
      {.name = "a differential with one wheel on the road", .masses = {1, 1, 1, 1}, .v = {3, 0, 0, -1},
       .contacts = {{.normal = {0, 0, 0, 1}, .mu = 0.3, .tangents = {{0, 0, 1, 0}}}},
       .rows = {turning(equality({2, -1, -1, 0}))}, .after = {0.9, 1.05, 0.75, 0}, .f_N = {1}, .f_T = {-0.3},
       .f_R = {-1.05}},
      // All three turn alike; (1, -2, 1) = 0.5 (2, -1, -1) - 1.5 (0, 1, -1)
      {.name = "a locked differential", .masses = {1, 1, 1}, .v = {0, 3, 0},
       .rows = {turning(equality({2, -1, -1})), turning(equality({0, 1, -1}))}, .after = {1, 1, 1}, .f_R = {0.5, -1.5}},
      // --- friction of a load ---
      // f = 1 on the threads; 0.1 of torque are below 0.2.
      {.name = "a self-locking screw", .masses = {1, 0.01}, .v = {-1, 0}, .rows = {threads, thread_friction(0.2)},
       .after = {0, 0}, .f_R = {1, 0.1}},
      // -1 + f = 0.1 (-0.1 + 0.05) f / 0.01
      {.name = "a screw that runs", .masses = {1, 0.01}, .v = {-1, 0}, .rows = {threads, thread_friction(0.05)},
       .after = {-1.0 / 3, -10.0 / 3}, .f_R = {2.0 / 3, 0.1 / 3}},
      {.name = "a screw without load", .masses = {1, 0.01}, .v = {1, 2}, .rows = {threads, thread_friction(0.2)},
       .after = {1, 2}, .f_R = {0, 0}},
      // The load is 0.5 at most: -1 + 0.5, 1 - 0.4 * 0.5.
      {.name = "friction of a load that has a bound", .masses = {1, 1}, .v = {-1, 1},
       .rows = {motor({1, 0}, 0, 0, 0.5), friction({0, 1}, 0, 0.4)}, .after = {-0.5, 0.8}, .f_R = {0.5, -0.2}},
      // --- doors, wheels, grippers, sleds ---
      // A ball at 2 m from the hinge: 2 p = 3 + 0.25.
      {.name = "a door with a dry hinge is hit", .masses = {4, 1}, .v = {0, -3}, .contacts = {{.normal = {-2, 1}}},
       .rows = {turning(dry({1, 0}, 0.5))}, .after = {-0.6875, -1.375}, .f_N = {1.625}, .f_R = {0.5}},
      // 3 at 2 m on the stop.
      {.name = "a closed door is hit", .masses = {4, 1}, .v = {0, -3}, .contacts = {{.normal = {-2, 1}}},
       .rows = {turning(at_least({1, 0}, 0))}, .after = {0, 0}, .f_N = {3}, .f_R = {6}},
      // Stop and friction share what holds the door.
      {.name = "a closed door with a dry hinge is hit", .masses = {4, 1}, .v = {0, -3},
       .contacts = {{.normal = {-2, 1}}}, .rows = {turning(dry({1, 0}, 0.5)), turning(at_least({1, 0}, 0))},
       .after = {0, 0}, .f_N = {3}, .f_R = {0.25, 5.75}, .impulses_are_unique = false},
      // 2 + F = 2 - 2 F - 0.3 / 0.5
      {.name = "a braked wheel rolls", .masses = wheel, .v = {2, -1, 2}, .contacts = {road(0.5)},
       .rows = {turning(dry({0, 0, 1}, 0.3))}, .after = {1.8, 0, 1.8}, .f_N = {1}, .f_T = {-0.2}, .f_R = {-0.3}},
      // F = -0.5 turns the wheel by 1; the brake stops 3 of inertia 0.5.
      {.name = "a braked wheel locks", .masses = wheel, .v = {2, -1, 2}, .contacts = {road(0.5)},
       .rows = {turning(dry({0, 0, 1}, 3))}, .after = {1.5, 0, 0}, .f_N = {1}, .f_T = {-0.5}, .f_R = {-1.5}},
      // F = 0.3 / 0.5 - 2 F
      {.name = "a driven wheel grips", .masses = wheel, .v = {0, -1, 0}, .contacts = {road(0.25)},
       .rows = {turning(motor({0, 0, 1}, 10, -0.3, 0.3))}, .after = {0.2, 0, 0.2}, .f_N = {1}, .f_T = {0.2},
       .f_R = {0.3}},
      // (1 - 0.25) / 0.5
      {.name = "a driven wheel spins", .masses = wheel, .v = {0, -1, 0}, .contacts = {road(0.25)},
       .rows = {turning(motor({0, 0, 1}, 10, -1, 1))}, .after = {0.25, 0, 1.5}, .f_N = {1}, .f_T = {0.25}, .f_R = {1}},
      // 2 from both sides carry up to 1 each; 1 is needed.
      {.name = "a gripper holds", .masses = {1, 1, 1}, .v = {0, 0, -1}, .contacts = grip,
       .rows = {motor({1, 0, 0}, 1, -2, 2)}, .after = {0, 0, 0}, .f_N = {2, 2}, .f_T = {0.5, 0.5}, .f_R = {2}},
      // -1 + 2 * 0.25
      {.name = "a gripper slips", .masses = {1, 1, 1}, .v = {0, 0, -1}, .contacts = grip,
       .rows = {motor({1, 0, 0}, 1, -0.5, 0.5)}, .after = {0, 0, -0.5}, .f_N = {0.5, 0.5}, .f_T = {0.25, 0.25},
       .f_R = {0.5}},
      // Only the first sled has friction: (2 - 0.5) / 2.
      {.name = "a sled pulls another", .masses = {1, 1, 1, 1}, .v = {1, -1, 1, -1},
       .contacts = {{.normal = {0, 1, 0, 0}, .mu = 0.5, .tangents = {{1, 0, 0, 0}}}, {.normal = {0, 0, 0, 1}}},
       .rows = {equality({1, 0, -1, 0})}, .after = {0.75, 0, 0.75, 0}, .f_N = {1, 1}, .f_T = {-0.5}, .f_R = {0.25}},
      // Locked along x, so that all friction acts along y.
      {.name = "a sled on a rail", .masses = {1, 1, 1}, .v = {1, -2, -1},
       .contacts = {{.normal = {0, 0, 1}, .mu = 0.5, .tangents = {{1, 0, 0}, {0, 1, 0}}}},
       .rows = {equality({1, 0, 0})}, .after = {0, -1.5, 0}, .f_N = {1}, .f_T = {0, 0.5}, .f_R = {-1}},
      // Twice held along x, and by the floor's friction: -1 in all.
      {.name = "a sled that is held twice", .masses = {1, 1}, .v = {1, -1}, .contacts = {floor},
       .rows = {equality({1, 0}), equality({1, 0})}, .after = {0, 0}, .f_N = {1}, .f_T = {-0.125},
       .f_R = {-0.5, -0.375}, .impulses_are_unique = false},
  };
}

/// The same answer of a case whose rows and contacts all yield: the offsets make up for it.
Case softened(Case given) {
  given.name += ", soft";
  for (std::size_t i = 0; i < given.rows.size(); ++i) {
    const double added = 0.5 + 0.25 * static_cast<double>(i);
    given.rows[i].compliance += added;
    given.rows[i].b -= added * given.f_R[i];
  }
  std::size_t tangent = 0;
  for (std::size_t c = 0; c < given.contacts.size(); ++c) {
    Contact& contact = given.contacts[c];
    contact.compliance = 0.25;
    contact.b -= contact.compliance * given.f_N[c];
    for (std::size_t t = 0; t < contact.tangents.size(); ++t) {
      contact.offset_t.push_back(-contact.compliance * given.f_T[tangent++]);
    }
  }
  given.impulses_are_unique = true;
  return given;
}

/// Among 100 bodies: three of four fall on a floor, the others slip with dry friction.
Case in_scene(const Case& given) {
  constexpr std::size_t kBodies = 100;
  const std::size_t own = given.v.size(), first = kBodies / 2;
  Case scene = given;
  scene.name += ", in a scene";
  scene.masses.clear(), scene.v.clear(), scene.after.clear();
  scene.contacts.clear(), scene.rows.clear(), scene.f_N.clear(), scene.f_R.clear();
  const auto widened = [&](const Numbers& direction) {
    Numbers wide(kBodies + own, 0.0);
    std::copy(direction.begin(), direction.end(), wide.begin() + first);
    return wide;
  };
  const auto add_given = [&] {
    const auto rows_before = static_cast<int>(scene.rows.size());
    for (std::size_t k = 0; k < own; ++k) {
      scene.masses.push_back(given.masses.empty() ? 0.0 : given.masses[k]);
      scene.v.push_back(given.v[k]);
      scene.after.push_back(given.after[k]);
    }
    for (Contact contact : given.contacts) {
      contact.normal = widened(contact.normal);
      for (Numbers& tangent : contact.tangents) tangent = widened(tangent);
      scene.contacts.push_back(std::move(contact));
    }
    scene.f_N.insert(scene.f_N.end(), given.f_N.begin(), given.f_N.end());
    for (Row row : given.rows) {
      row.direction = widened(row.direction);
      if (row.friction_of >= 0) row.friction_of += rows_before;
      scene.rows.push_back(std::move(row));
    }
    scene.f_R.insert(scene.f_R.end(), given.f_R.begin(), given.f_R.end());
  };
  for (std::size_t body = 0; body < kBodies; ++body) {
    if (body == first) add_given();
    Numbers direction(kBodies + own, 0.0);
    direction[scene.v.size()] = 1;
    const bool slips = body % 4 == 0;
    scene.masses.push_back(2);
    scene.v.push_back(slips ? 0.5 : -1);
    scene.after.push_back(slips ? 0.375 : 0);
    if (slips) {
      scene.rows.push_back(dry(direction, 0.25));
      scene.f_R.push_back(-0.25);
    } else {
      scene.contacts.push_back({.normal = direction});
      scene.f_N.push_back(2);
    }
  }
  return scene;
}

Vector vector_of(const Numbers& numbers) {
  return Eigen::Map<const Vector>(numbers.data(), static_cast<Index>(numbers.size()));
}

/// The inertia of a case by itself: dense.
Matrix own_inertia(const Case& given) {
  return given.G.size() > 0 ? given.G : Matrix(vector_of(given.masses).asDiagonal());
}

/// In dense matrices, or with blocks and sparse columns. @param scene  in_scene(given), or given itself
ContactProblem contact_problem(const Case& given, const Case& scene) {
  const auto ngc = static_cast<Index>(scene.v.size());
  const auto nc = static_cast<Index>(scene.contacts.size());
  ContactProblem problem;
  problem.v = vector_of(scene.v);
  Matrix N(ngc, nc);
  std::vector<Vector> directions;
  problem.mu = problem.b = problem.compliance_n = problem.compliance_t = Vector::Zero(nc);
  problem.offset_t = Vector::Zero(2 * nc);
  for (Index c = 0; c < nc; ++c) {
    const Contact& contact = scene.contacts[static_cast<std::size_t>(c)];
    N.col(c) = vector_of(contact.normal);
    problem.edges.push_back(2 * static_cast<int>(contact.tangents.size()));
    problem.mu(c) = contact.mu;
    problem.b(c) = contact.b;
    problem.compliance_n(c) = contact.compliance;
    if (!contact.tangents.empty()) problem.compliance_t(c) = contact.compliance;
    for (const double sign : {1.0, -1.0}) {
      for (const Numbers& tangent : contact.tangents) directions.push_back(sign * vector_of(tangent));
    }
    for (std::size_t t = 0; t < contact.offset_t.size(); ++t) {
      problem.offset_t(2 * c + static_cast<Index>(t)) = contact.offset_t[t];
    }
  }
  Matrix D(ngc, static_cast<Index>(directions.size()));
  for (Index t = 0; t < D.cols(); ++t) D.col(t) = directions[static_cast<std::size_t>(t)];
  for (Vector* numbers : {&problem.b, &problem.compliance_n, &problem.compliance_t, &problem.offset_t}) {
    if (numbers->isZero(0)) numbers->resize(0);
  }
  problem = testing::with_rows(std::move(problem), scene.rows);
  if (&given == &scene) {
    problem.N = N;
    problem.D = D;
    problem.inertia = DenseInertia{own_inertia(given)};
    return problem;
  }
  problem.N = SparseMatrix(N.sparseView());
  problem.D = SparseMatrix(D.sparseView());
  problem.rows.R = SparseMatrix(to_dense(problem.rows.R).sparseView());
  BlockInertia bodies;
  const Index own = static_cast<Index>(given.v.size()), first = (ngc - own) / 2;
  for (Index k = 0; k < ngc; ++k) {
    if (k == first) bodies.blocks.push_back(own_inertia(given));
    if (k >= first && k < first + own) continue;
    bodies.blocks.push_back(Matrix::Constant(1, 1, scene.masses[static_cast<std::size_t>(k)]));
  }
  problem.inertia = bodies;
  return problem;
}

/// A problem with its right answer.
struct Solved {
  ContactProblem problem;
  Vector z;
  Vector after;
  bool impulses_are_unique = true;
  bool moves = true;  ///< no impulses are no answer
};

Solved solved(const Case& given, const Case& scene) {
  Solved result;
  result.problem = contact_problem(given, scene);
  result.after = vector_of(scene.after);
  const ContactLayout layout = contact_layout(result.problem);
  Vector impulses = Vector::Zero(layout.size());
  impulses.head(layout.nc) = vector_of(scene.f_N);
  impulses.tail(layout.rows) = vector_of(scene.f_R);
  std::size_t tangent = 0;
  for (Index c = 0; c < layout.nc; ++c) {
    const Index first = layout.friction_offset() + layout.friction_begin[static_cast<std::size_t>(c)];
    const Index tangents = result.problem.edges[static_cast<std::size_t>(c)] / 2;
    for (Index t = 0; t < tangents; ++t) {
      const double f = scene.f_T[tangent++];
      impulses(first + t + (f < 0 ? tangents : 0)) = std::abs(f);
    }
  }
  result.z = complete_impulses(result.problem, impulses);
  result.impulses_are_unique = scene.impulses_are_unique;
  result.moves = !impulses.isZero(0);
  return result;
}

/// Every case: hard and soft, by itself and in a scene.
class BoundedRowsTest : public ::testing::Test {
 protected:
  template <class Check>
  static void for_each_form(const Check& check) {
    for (const Case& hard : cases()) {
      for (const Case& given : {hard, softened(hard)}) {
        for (const Case& scene : {given, in_scene(given)}) {
          SCOPED_TRACE(scene.name);
          const bool alone = scene.v.size() == given.v.size();
          check(solved(given, alone ? given : scene));
          if (HasFatalFailure()) return;
        }
      }
    }
  }
};

TEST_F(BoundedRowsTest, ThereAreFortyMechanismsAndTwelveSlideOnContacts) {
  const std::vector<Case> all = cases();
  EXPECT_GE(all.size(), 40u);
  EXPECT_GE(std::count_if(all.begin(), all.end(), [](const Case& one) { return !one.f_T.empty(); }), 12);
}

TEST_F(BoundedRowsTest, TheRightImpulsesLeaveTheRightVelocity) {
  for_each_form([](const Solved& right) {
    const Vector velocity = post_impact_velocity(right.problem, right.z);
    EXPECT_LE((velocity - right.after).lpNorm<Eigen::Infinity>(), kRounding);
  });
}

TEST_F(BoundedRowsTest, TheRightImpulsesSolveTheMixedLcp) {
  for_each_form([](const Solved& right) {
    const Lcp lcp = form_lcp(right.problem);
    const auto error = [&](const Vector& z) { return lcp_error(lcp, Numbers(z.begin(), z.end())).backward; };
    EXPECT_LE(error(right.z), kRounding);
    if (right.moves) {
      EXPECT_GE(error(Vector::Zero(right.z.size())), 1e-2);
    }
  });
}

TEST_F(BoundedRowsTest, TheVerdictIsSolvedAndDoingNothingIsAsBadAsCanBe) {
  for_each_form([](const Solved& right) {
    const Problem problem("mechanism", right.problem);
    Evaluator evaluator(problem);
    Answer answer;
    answer.claim = Claim::kSolved;
    answer.z = right.z;
    answer.velocity = right.after;
    const Errors errors = evaluator.errors(answer);
    EXPECT_TRUE(errors.solved);
    EXPECT_LE(errors.velocity_residual_relative, kRounding);
    if (!right.moves) return;
    answer.z = Vector::Zero(right.z.size());
    answer.velocity.resize(0);
    EXPECT_GE(evaluator.errors(answer).velocity_residual_relative, 1 - kRounding);  // more where friction lacks lambda
  });
}

TEST_F(BoundedRowsTest, NativeSolversFindTheVelocity) {
  for (const std::string& name : testing::native_solvers()) {
    SCOPED_TRACE(name);
    const auto solver = make_solver(parse_spec(name == "psor" ? "psor{tolerance=1e-12}" : name));
    int taken = 0, claimed = 0;
    for_each_form([&](const Solved& right) {
      const Problem problem("mechanism", right.problem);
      if (!why_not(solver->capabilities(), problem).empty()) return;
      solver->load(problem);
      const Answer answer = testing::solve(*solver);
      if (answer.claim == Claim::kUnsupported) return;
      ++taken;
      if (name == "auto") {
        EXPECT_EQ(answer.claim, Claim::kSolved) << answer.detail;
      }
      if (answer.claim != Claim::kSolved) return;
      ++claimed;
      const Vector velocity =
          answer.velocity.size() > 0 ? Vector(answer.velocity) : post_impact_velocity(right.problem, answer.z);
      EXPECT_LE((velocity - right.after).lpNorm<Eigen::Infinity>(), kFound);
      if (!right.impulses_are_unique) return;
      const Index nc = right.problem.nc(), m = right.problem.rows.size();
      EXPECT_LE((answer.z.head(nc) - right.z.head(nc)).lpNorm<Eigen::Infinity>(), kFound);
      EXPECT_LE((answer.z.tail(m) - right.z.tail(m)).lpNorm<Eigen::Infinity>(), kFound);
    });
    EXPECT_GT(taken, 0);
    EXPECT_GE(claimed, taken - taken / 30);
  }
}

/// With the vector of contacts and rows that proves it.
struct Unsolvable {
  Case mechanism;
  Numbers proof;
};

std::vector<Unsolvable> unsolvable_cases() {
  return {
      // v_1 = v_2 and v_1 = v_2 + 1
      {{.name = "equalities that contradict each other", .masses = {1, 1}, .v = {1, 0},
        .rows = {equality({1, -1}), equality({1, -1}, -1)}}, {-1, 1}},
      // The motor does not matter.
      {{.name = "limits that contradict each other", .masses = {1}, .v = {0},
        .rows = {at_least({1}, 2), motor({1}, 0, -1, 1), at_most({2}, 2)}}, {2, 0, -1}},
      // The contact asks for v >= 1, the rail for v = 0.
      {{.name = "a contact that a rail holds", .masses = {1}, .v = {0}, .contacts = {{.normal = {1}, .b = -1}},
        .rows = {equality({1})}}, {1, -1}},
      // A loop of three whose speeds do not add up to zero.
      {{.name = "a loop that does not close", .masses = {1, 2, 3}, .v = {0, 0, 0},
        .rows = {equality({1, -1, 0}, -0.5), equality({0, 1, -1}, -0.5), equality({-1, 0, 1}, 0.5)}}, {1, 1, 1}},
  };
}

TEST_F(BoundedRowsTest, ContradictionsAreUnsolvableAndProvenSo) {
  for (const Unsolvable& unsolvable : unsolvable_cases()) {
    SCOPED_TRACE(unsolvable.mechanism.name);
    const Problem problem("contradiction", contact_problem(unsolvable.mechanism, unsolvable.mechanism));
    const Vector proof = vector_of(unsolvable.proof);
    EXPECT_TRUE(proves_unsolvable(*problem.contact(), proof));
    EXPECT_FALSE(proves_unsolvable(*problem.contact(), -proof));
    for (const std::string& name : testing::native_solvers()) {
      const auto solver = make_solver(parse_spec(name));
      if (!why_not(solver->capabilities(), problem).empty()) continue;
      solver->load(problem);
      const Answer answer = testing::solve(*solver);
      EXPECT_NE(answer.claim, Claim::kSolved) << name;
      if (answer.claim == Claim::kUnsolvable && answer.farkas.size() > 0) {
        EXPECT_TRUE(proves_unsolvable(*problem.contact(), answer.farkas)) << name;
      }
      if (name == "auto") {
        EXPECT_EQ(answer.claim, Claim::kUnsolvable) << answer.detail;
        EXPECT_GT(answer.farkas.size(), 0);
      }
    }
    // Softness of one row or contact is enough.
    Case soft_one = unsolvable.mechanism;
    soft_one.rows.front().compliance = 1;
    const Problem yields("yields", contact_problem(soft_one, soft_one));
    EXPECT_FALSE(proves_unsolvable(*yields.contact(), proof));
    testing::expect_solved(yields, testing::solve("auto", yields));
  }
}

}  // namespace
}  // namespace lcpbench::bounded_rows_test
