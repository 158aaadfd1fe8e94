#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "adapters/capture/scene.h"

namespace lcpbench::capture {

constexpr double kGravity = 9.81;  ///< [m/s^2], down the z axis
constexpr int kWorld = -1;
/// Up to which gap a solver in the loop gets the contacts of ODE, DART and MuJoCo [m], so that it keeps those that its
/// last velocities left open by a hair. The engines' own solvers get what the engine finds as it is shipped.
constexpr double kContactMargin = 1e-4;

/// A free body as a step finds it. The velocities have the forces of the step in them: v + h M^-1 f.
struct BodyState {
  double mass = 1;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  ///< in world axes
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_change = Eigen::Vector3d::Zero();  ///< what those forces add to the velocity
  Eigen::Vector3d angular_change = Eigen::Vector3d::Zero();

  /// Adds what a force [N] and a torque [N m] do in a step of length h to velocities without forces.
  void accelerate(const Eigen::Vector3d& force, const Eigen::Vector3d& torque, double h);
};

/// A robot as a step finds it: its mass matrix, and its velocity with the forces of the step in it.
struct BlockState {
  Eigen::MatrixXd mass;
  Eigen::VectorXd velocity;
};

/// The rows of a contact over the coordinates of all blocks. One without friction has no tangents.
struct Rows {
  std::vector<int> coordinates;
  Eigen::VectorXd normal;
  Eigen::VectorXd tangent;
  Eigen::VectorXd second_tangent;
};

struct ContactState {
  int body_a = kWorld;  ///< index in Snapshot::bodies
  int body_b = kWorld;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< from body_b into body_a; zero where there is no place
  Eigen::Vector3d tangent = Eigen::Vector3d::UnitX();
  std::optional<Rows> rows;  ///< of articulated scenes, in place of the bodies
  double mu = 0;
  int edges = 4;
  double gap = 0;                                     ///< [m], negative: penetration
  double offset = 0;                                  ///< b: the contact asks that normal velocity + b >= 0 [m/s]
  double compliance_n = 0;                            ///< r_n and r_t of ContactProblem, with offset_t
  double compliance_t = 0;
  Eigen::Vector2d offset_t = Eigen::Vector2d::Zero();
  std::string pair;                                   ///< who touches whom: contacts keep their names within a pair
  Eigen::Vector3d local = Eigen::Vector3d::Zero();    ///< the point in the frame of a moving body of the pair
  std::string id;                                     ///< set by the program, before a solver in the loop sees it
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  ///< the engine's, along normal, tangent, second tangent [N s]
};

/// A bounded row over the coordinates of all blocks, as BoundedRows has them.
struct RowState {
  std::vector<int> coordinates;
  Eigen::VectorXd direction;
  double lower = 0;
  double upper = 0;
  double offset = 0;  ///< b
  double compliance = 0;
  int friction_of = -1;  ///< the row whose impulse, times mu, bounds this one
  double mu = 0;
  bool is_angle = false;
  std::string name;
  double impulse = 0;  ///< the engine's [N s, N m s]
};

struct Pose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

/// One step: bodies of a scene without joints, or blocks, of robots or where contacts have rows of their own.
struct Snapshot {
  std::vector<BodyState> bodies;
  std::vector<BlockState> blocks;
  std::vector<ContactState> contacts;
  std::vector<RowState> rows;  ///< of blocks
  std::vector<Pose> poses;  ///< of the scene's parts, for pictures
  std::vector<Eigen::Vector3d> marks;  ///< places of Scene::marks [m]
  Eigen::VectorXd correction;      ///< of positions, beside h velocity: by a solver in the loop, or empty
  int substeps = 1;                ///< of a stepper in the loop
  Eigen::VectorXd velocity_after;  ///< the engine's own, of all coordinates; empty where it cannot be told
  bool has_impulses = false;
  std::optional<double> solve_s;  ///< thread CPU time of the engine's own solver, its set-up included
  std::vector<std::string> notes;  ///< how the problem differs from the engine's step: "what: how many"
};

/// The shape that a pose in Snapshot::poses belongs to, for pictures; without a type: none. Sizes are half lengths and
/// radii [m].
struct Drawn {
  std::string type;
  std::vector<double> size;
};

/// A solver in the loop, in place of the engine's own: gives the velocity after the contacts, of all coordinates of the
/// snapshot.
using VelocitySolver = std::function<Eigen::VectorXd(Snapshot& snapshot)>;

/// A physics engine that steps one scene on.
class Engine {
 public:
  virtual ~Engine() = default;
  const std::string& name() const { return name_; }
  const std::string& version() const { return version_; }
  /// As the engine runs it: where nothing of a model was named, with its free bodies as marks.
  const Scene& scene() const { return scene_; }
  virtual double step_length() const { return scene_.step; }
  virtual Eigen::Vector3d gravity() const { return {0, 0, -kGravity}; }
  virtual std::vector<Drawn> drawn() const;
  /// Finds the contacts, fills the snapshot, solves and moves on by one step. @param loop  empty: the engine solves,
  /// and its answer is part of the snapshot
  virtual void step(long index, Snapshot& snapshot, const VelocitySolver& loop) = 0;

 protected:
  Engine(const Scene& scene, std::string name, std::string version)
      : scene_(scene), name_(std::move(name)), version_(std::move(version)) {}

  Scene scene_;
  std::string name_;
  std::string version_;
};

/// Each engine's capture.cpp defines this. @param model  a model file of the user's, or empty
/// @throws InputError when the engine cannot run the scene
std::unique_ptr<Engine> make_engine(const Scene& scene, const std::string& model);

// What the engines share.

/// The velocity that moves the bodies to their next positions: with the correction of positions in it.
Eigen::VectorXd moving_velocity(const Eigen::VectorXd& velocity, const Snapshot& snapshot, double h);

/// R diag(moments) R', in a fixed order of operations.
Eigen::Matrix3d world_inertia(const Eigen::Matrix3d& R, const Eigen::Vector3d& moments);

/// Gravity and the push of the scene on this body.
Eigen::Vector3d force_on(const Body& body, long step);

/// The torque of the gyroscopic forces, implicit in the angular velocity (one Newton step from the explicit one), so
/// that a fast spin gains no energy.
Eigen::Vector3d gyroscopic_torque(const Eigen::Matrix3d& inertia, const Eigen::Vector3d& angular_velocity, double h);

/// The torque of the scene's controller at a hinge.
double controller_torque(const Joint& hinge, double angle, double velocity, double time);

/// A direction orthogonal to a unit normal.
Eigen::Vector3d tangent_to(const Eigen::Vector3d& normal);

/// The offset of a contact: gap / h of a gap that is open by more than a nanometre; restitution of an approach at more
/// than 0.2 m/s. Penetration is left as it is. @param approach  normal velocity before the step's forces
double contact_offset(double gap, double h, double restitution, double approach);

/// A contact that is open and would bounce once it is closed: within the margin a solver in the loop gets it then only,
/// because the offset of an open contact has no bounce in it. @param approach  as for contact_offset()
bool waits_to_bounce(const Scene& scene, double gap, double approach);

/// The contact of bodies a and b of a scene. The engine sets what differs: body_a, body_b and local, or rows; impulse.
/// @param normal  not zero @param approach  relative velocity of the bodies at the point, before the step's forces
ContactState touch(const Scene& scene, std::size_t a, std::size_t b, const Eigen::Vector3d& point,
                   const Eigen::Vector3d& normal, double gap, const Eigen::Vector3d& approach);

/// An impulse in world axes along the contact's normal, tangent and second tangent.
Eigen::Vector3d in_axes_of(const ContactState& contact, const Eigen::Vector3d& impulse);

/// Friction that an engine limits along each of two directions by itself, |f_i| <= mu f_N: this square is a pyramid of
/// four edges, turned by 45 degrees, with the coefficient sqrt(2) mu.
void set_square_friction(const Eigen::Vector3d& first, ContactState& contact);

/// Of a free body: its linear velocity before its angular velocity.
BlockState block_of(const BodyState& state);

/// A bounded row of the velocity linear'v_a + angular_a'w_a - linear'v_b - angular_b'w_b of two bodies in a snapshot,
/// of which a moves. Without bounds; it is about an angle where `linear` is zero.
RowState row_between(int a, int b, const Eigen::Vector3d& linear, const Eigen::Vector3d& angular_a,
                     const Eigen::Vector3d& angular_b, std::string name);

/// Sets the impulses of rows between the same two bodies by what they do to body a, which they tell apart.
/// @param force, torque  times the step length
void set_impulses(const Eigen::Vector3d& force, const Eigen::Vector3d& torque, std::span<RowState> rows);

/// Bounded rows are those of blocks: makes a block of each body, and rows over their coordinates of each contact.
void make_blocks(Snapshot& snapshot);

/// "name", "name #2" and so on.
std::string numbered(const std::string& name, int count);

/// @param poses  of the bodies
std::vector<Pose> part_poses(const Scene& scene, const std::vector<Pose>& poses);

/// For engines that read no models. @throws InputError when the scene is a model, or one is given
void require_built_scene(const Scene& scene, const std::string& model, const char* engine);

}  // namespace lcpbench::capture
