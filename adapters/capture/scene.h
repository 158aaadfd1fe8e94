#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

// Scenes for physics engines, described without any engine: bodies, shapes, joints and forces as plain data. Each
// engine's capture.cpp translates a description into its own world. Lengths in m, masses in kg, times in s.

namespace lcpbench::capture {

/// A convex part of a body, in the axes of the body.
struct Part {
  enum class Kind { kSphere, kBox };
  Kind kind = Kind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Ones();    ///< half lengths of a box; a sphere's radius in x
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< centre of the part, from the centre of mass
};

/// Where a controller wants a joint: centre + amplitude sin(2 pi frequency t + phase).
struct Target {
  double centre = 0;
  double amplitude = 0;
  double frequency = 0;  ///< [Hz]
  double phase = 0;      ///< [rad]
};

/// A hinge between a body and its parent, or a slide along the axis. Angles and positions are zero in the pose of the
/// description. Units are those of a hinge; a slide has m in place of rad, and N in place of N m.
struct Joint {
  int parent = 0;                                    ///< an earlier body
  Eigen::Vector3d anchor = Eigen::Vector3d::Zero();  ///< a point of the axis, in the world
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();   ///< in the world
  double lower = -1;                                 ///< [rad]
  double upper = 1;                                  ///< [rad]
  double stiffness = 0;                              ///< of a hinge's controller [N m / rad]
  double damping = 0;                                ///< of the controller [N m s / rad]
  double max_torque = 0;                             ///< of the controller [N m]
  Target target;
  /// Of a motor that is part of the engine's solve: at most this torque keeps the speed after the step at `speed`
  /// [N m]. Dry friction where that speed is 0.
  double effort = 0;
  double speed = 0;  ///< [rad/s]
  bool slides = false;

  const char* kind() const { return slides ? "slide" : "hinge"; }
};

/// A force at the centre of mass, in world axes, during the steps from first to last.
struct Push {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< [N]
  long first = 0;
  long last = 1'000'000;
};

/// A rigid body. The frame of the body has its origin in the centre of mass and its axes along the principal axes.
/// A body with a mass of 0 is part of the world and does not move.
struct Body {
  std::vector<Part> parts;
  double mass = 1;
  Eigen::Vector3d inertia = Eigen::Vector3d::Ones();  ///< principal moments [kg m^2]; see solid()
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d linear_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< in world axes
  std::optional<Joint> joint;                                  ///< without: the body moves freely
  Push push;
};

/// Two bodies that share a point: what closes a chain.
struct Loop {
  int first = 0;
  int second = 0;
  Eigen::Vector3d anchor = Eigen::Vector3d::Zero();  ///< in the world
};

/// A body that holds another one by friction.
struct Grip {
  int held = 0;
  int by = 0;
};

struct Scene {
  std::string name;
  std::string summary;  ///< one line
  std::vector<Body> bodies;
  std::vector<Loop> loops;
  std::vector<int> stands;  ///< bodies that stay where they are while contacts are solved well
  std::vector<Grip> grips;  ///< what does not slip while contacts are solved well
  /// Of a model file: bodies, geometries and sites by name, whose places a replay measures. Then `stands` and `grips` are
  /// indices of these, else of `bodies`.
  std::vector<std::string> marks;
  double mu = 0.5;
  double restitution = 0;
  double step = 0.005;  ///< [s]
  std::string program;  ///< command of the engine, where it is a program of the user's
  std::string soft;     ///< not empty: contacts as the engine itself softens them, and its solver, as --soft names it
  bool elliptic = false;  ///< MuJoCo's elliptic friction cones in place of its pyramids
  double cfm = -1;      ///< constraint force mixing of contacts, in the engine's units; negative: the engine's default
  double erp = -1;      ///< error reduction of contacts, a share of 1; negative: the engine's default
  int sweeps = 0;       ///< of the engine's own solver; 0: as many as it does by default
  long steps = 300;     ///< how long the scene is worth watching
  /// A model that the engine brings along, in place of bodies: MuJoCo's humanoid. Relative to the engine's models.
  std::string model;
  double model_height = 0;     ///< how far the model's root is lifted [m]
  double model_tilt = 0;       ///< how far it is turned about the y axis [rad]
  double model_stiffness = 0;  ///< of a controller that holds the model's joints where they are [N m / rad]
  Push model_push;             ///< on the root

  bool articulated() const;
  bool driven() const;  ///< whether a joint has a motor that is part of the engine's solve
  /// The first engine that has what the scene needs.
  const char* engine() const { return articulated() && !driven() ? "mujoco" : "ode"; }
  /// The body that carries this one over joints. Bodies with the same root do not touch each other.
  std::size_t root(std::size_t body) const;
};

/// All scenes, free bodies first.
const std::vector<Scene>& scenes();

/// A scene by its spec: `stack`, or changed by options, `stack{divide=4,nudge=1e-12}`: steps a quarter as long, the
/// first body that moves aside. @throws InputError
Scene find_scene(const std::string& spec);

std::vector<Scene> free_body_scenes();
std::vector<Scene> articulated_scenes();

// Functions that make the descriptions' parts.

Part box(double x, double y, double z, const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());
Part sphere(double radius, const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());
/// A body of equal density: places the parts about the centre of mass and computes the inertia. Parts do not overlap,
/// and are arranged so that the axes of the body are its principal axes.
/// @param origin  where the origin of the parts' offsets is in the world
Body solid(std::vector<Part> parts, double mass, const Eigen::Vector3d& origin);
/// A part of the world.
Body fixed(Part part, const Eigen::Vector3d& position,
           const Eigen::Quaterniond& orientation = Eigen::Quaterniond::Identity());
/// A level floor at height 0.
Body ground();
/// A scene of the ground alone, to which others are added.
Scene scene(std::string name, std::string summary, double mu);
/// A turn about the y axis by an angle of this cosine and sine: z goes to (sine, 0, cosine). Without trigonometric
/// functions, whose last bit is not the same everywhere. @pre cosine > -1
Eigen::Quaterniond turned_about_y(double cosine, double sine);

}  // namespace lcpbench::capture
