#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "generators/made/made.h"
#include "generators/random.h"

// What the made sets are built of: bodies, robots and contacts, in world coordinates, z upwards. Units: m, kg, s.

namespace lcpbench::made {

using Triple = std::array<double, 3>;

inline Triple operator+(const Triple& a, const Triple& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Triple operator-(const Triple& a, const Triple& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Triple operator*(double factor, const Triple& a) { return {factor * a[0], factor * a[1], factor * a[2]}; }
inline Triple operator-(const Triple& a) { return -1.0 * a; }
inline double dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Triple& a);
Triple unit(const Triple& a);
/// base^exponent, the same bits everywhere. @pre base > 0
double power(double base, double exponent);

constexpr double kGravityStep = 9.81 * 0.005;  ///< the speed that gravity gives in one step of 5 ms [m/s]
constexpr Triple kX{1, 0, 0};
constexpr Triple kY{0, 1, 0};
constexpr Triple kZ{0, 0, 1};

/// (cos, sin) of an angle in turns, by a fixed series: the same bits everywhere.
std::array<double, 2> cos_sin(double turns);

/// Three orthonormal axes.
using Axes = std::array<Triple, 3>;
constexpr Axes kWorldAxes{kX, kY, kZ};
/// The world's axes turned about z, or about y: the first axis is (cos, sin, 0), or (cos, 0, sin).
Axes turned_about_z(double turns);
Axes turned_about_y(double turns);

/// A direction of length 1 across `normal`, of length 1.
Triple tangent(const Triple& normal);

/// A link on a hinge: it turns about `axis`, of length 1, through the point `joint` of its parent.
struct Link {
  int parent = -1;  ///< index of an earlier link; -1: the base
  Triple joint{};
  Triple axis{};
  Triple centre{};  ///< of mass
  double mass = 1;
};

constexpr int kWorld = -1;

/// A problem in the making, with the random numbers of its trial.
class Scene {
 public:
  Scene(const MadeReading& reading, const TrialKey& key);

  // ---- draws ----
  /// The number of contacts that the class should aim at.
  double goal() const { return goal_; }
  /// `value` rounded down, but at least `least`.
  static int count(double value, int least) { return value < least ? least : static_cast<int>(value); }
  double uniform(double low, double high);
  /// Both bounds are included.
  int integer(int low, int high) { return static_cast<int>(shape_.integer(low, high)); }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  double log_uniform(double low, double high);
  /// `usual` times a factor from 1 to the mass ratio of the trial, logarithmically uniform. Always takes one draw.
  double mass(double usual) { return graded_mass(usual, uniform(0, 1)); }
  /// `usual` times the mass ratio to the power `share`.
  double graded_mass(double usual, double share) const;

  // ---- bodies ----
  /// A box whose edges have these lengths and directions.
  int box(double mass, const Triple& edges, const Triple& centre, const Axes& axes = kWorldAxes);
  int sphere(double mass, double radius, const Triple& centre);
  /// A tree of links on a base that is free or stands still: one block of the inertia. Each part has the inertia of a
  /// solid sphere. Each diagonal entry is increased by the block's trace / condition, as rotors do, so that the block's
  /// condition number is at most 1 + condition. Joints have random speeds; without a free base there is no gravity.
  /// @returns the base; link k is base + 1 + k
  int robot(double mass, const Triple& centre, bool base_is_free, const std::vector<Link>& links, double condition);
  /// What moves along `axis` only. The inertia of the problem is dense with it.
  int slider(double mass, const Triple& axis, double speed);
  /// Sets the velocity of a free body before the impact. @pre it has no contacts yet: their restitution depends on it
  void move(int body, const Triple& linear, const Triple& angular);
  const Triple& centre(int body) const { return parts_[static_cast<std::size_t>(body)].centre; }

  // ---- contacts ----
  /// Adds a contact that pushes `a` along the normal, and `b` against it. `b` may be the world, but no part of the
  /// robot of `a`.
  /// @param normal  of length 1
  /// @param is_open  promises that no impulses which together move nothing include one at this contact, so that a
  ///   solution exists for an offset of either sign. A contact that is not open gets no negative offset
  void touch(int a, int b, const Triple& point, const Triple& normal, bool is_open = false);
  /// Four contacts at the corners centre +- along +- across.
  void touch_face(int a, int b, const Triple& centre, const Triple& normal, const Triple& along, const Triple& across,
                  bool is_open = false);
  /// Each contact from now on has a mu of its own, whatever the trial has drawn.
  void roughen() { mu_is_shared_ = false; }

  /// A contact with its first friction direction, and with edges, mu and an offset of its own.
  void add_contact(int a, int b, const Triple& point, const Triple& normal, const Triple& first, int edges, double mu,
                   double offset);

  MadeSample finish() { return std::move(sample_); }

 private:
  /// A body or a link: which coordinates move its points.
  struct Part {
    std::size_t base_row = 0;
    bool base_is_free = true;
    Triple base_centre{};
    Triple centre{};
    std::vector<std::pair<std::size_t, Link>> joints;  ///< (row, joint) from the part to the base
    Triple slide{};                                    ///< of what moves along an axis only: this axis
  };

  double draw(DrawSequence& draws, double low, double high);
  Triple draw_triple(DrawSequence& draws, double largest);
  /// Appends six velocities: one step of gravity, the drift, and random speeds, angular ones divided by the radius.
  void add_free_velocity(double radius);
  int add_free_body(double mass, const ColumnMajor<double>& inertia, const Triple& centre, double radius);
  /// Appends the generalized force of a unit force along `direction` at `point` of the part.
  static void push(const Part& part, const Triple& point, const Triple& direction, MadeSample::Column& column);
  MadeSample::Column column(int a, int b, const Triple& point, const Triple& direction) const;
  double draw_mu();
  double draw_offset(double approach, bool is_open);

  DrawSequence shape_, velocities_, frictions_, offset_draws_;
  double goal_ = 0;
  int edges_ = 0;
  bool mu_is_shared_ = true;
  double mu_ = 0, mu_min_ = 0, mu_max_ = 0;
  double mass_ratio_ = 1;
  double speed_ = 0;
  Triple drift_{};
  enum class Offsets { kNone, kGaps, kBounces } offsets_ = Offsets::kNone;
  double offset_share_ = 0, bounce_ = 0;
  std::vector<Part> parts_;
  MadeSample sample_;
};

/// Chains of links from `root` on, `branches` or fewer, the links in random directions, most of them nearly level.
/// @param lightest  mass of the outermost links, divided by 5 kg; along a chain masses change by a constant factor
std::vector<Link> random_tree(Scene& scene, const Triple& root, int count, double link_length, int branches,
                              double lightest);

}  // namespace lcpbench::made
