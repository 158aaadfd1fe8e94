#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/contact_problem.h"
#include "core/solver.h"
#include "native/cone_ipm/dense_lu.h"

namespace lcpbench {

/// When the iteration on an island ends.
struct ConeLimits {
  double tolerance = 0;  ///< of the residual, relative to the scale of the island
  double accepted = 0;   ///< residual up to which an answer is one
  std::int64_t max_iterations = 0;
  double deadline_s = 0;  ///< on wall_clock_s()
};

/// The contacts of one island with the round friction cone, by an interior-point method in velocity space.
///
/// In whitened coordinates (G = I) with x_i = (mu f_N, f_t) and y_i = (u_N / mu + |u_t|, u_t) of contact i,
///
///     x_i and y_i in the cone |x_t| <= x_0, x_i'y_i = 0, y = A w + R x + q + (|y_t|, 0, 0), w = A'x:
///
/// |y_t| is de Saxce's correction, without which the problem is convex and is Anitescu's relaxation. R is the
/// compliance of soft contacts, a diagonal. Newton's method on these equations, with Nesterov and Todd's scaling of x_i
/// o y_i = target and Mehrotra's predictor and corrector, solves with I + A'PA for each step, P of 3 x 3 blocks. T is
/// that scaling, T x = T^-1 y = lambda; B is the derivative of y - (|y_t|, 0, 0), or I where the slip is not taken by
/// Newton. A contact without friction is one row x y = target.
class ConeIsland {
 public:
  /// @param island contacts that belong together, on their own coordinates. @pre why_no_round_cone() is ""
  void load(const ContactProblem& island);
  void set_velocity(const ContactProblem& island, const Vector& v);

  enum class Stop { kConverged, kStalled, kBreakdown, kIterationLimit, kTimeLimit };
  static bool is_limit(Stop stop) { return stop == Stop::kIterationLimit || stop == Stop::kTimeLimit; }
  /// How the slip in y is taken: by Newton's method, or held while the then convex problem is solved, round by round.
  enum class Slip { kNewton, kRounds, kNone };

  /// Forgets the impulses of the last solve: none are the first to be tested.
  void start();
  /// Each call from a start of its own. Unless a limit stops it, an interior point ends with finish(). The impulses of
  /// the smallest residual since start() are kept; of kNone those of the relaxation, with the residual of its own
  /// conditions.
  Stop solve(Slip slip, const ConeLimits& limits, Counters& counters);

  /// f_N, f_1, f_2 of a contact, the latter two along its tangents.
  Eigen::Vector3d impulse(Index contact) const;
  /// Largest row of the conditions, relative to the scale.
  double residual() const { return best_residual_; }
  /// That scale [m/s]. @pre start()
  double speed() const { return scale_ * unit_; }
  /// The change of the velocity.
  void add_velocity_change(const ContactProblem& island, Vector& u);

 private:
  struct Contact {
    Index row = 0;  ///< first of its rows, 3 with friction and 1 without
    Index rows = 1;
    double mu = 0;
    std::array<Index, 2> tangents{-1, -1};  ///< columns of D
    Index first = 0;                        ///< of its columns in columns_ and entries_
    Index columns = 0;                      ///< how many coordinates it moves
    double diagonal_normal = 0;             ///< M_nn
    double diagonal_tangent = 0;            ///< the larger M_tt
    Eigen::Vector3d compliance{0, 0, 0};    ///< R

    /// x_0 / f_N, and u_N / y_0 without slip.
    double scale() const { return rows == 3 ? mu : 1.0; }
    /// Of y in x_0, and at least that in x_t.
    double diagonal() const { return diagonal_normal / (scale() * scale()) + diagonal_tangent; }
  };
  /// Nesterov and Todd's scaling of one contact.
  struct Scaling {
    Eigen::Vector3d point;  ///< of unit determinant
    double size = 1;
    Eigen::Vector3d lambda;  ///< the scaled x and y
    Eigen::Matrix3d weight;  ///< P = S T^-2 B^-1
    Eigen::Matrix3d soft;    ///< S = (I + T^-2 B^-1 R)^-1, where a contact is soft
  };

  void add_contact(const ContactProblem& island, const ContactLayout& layout, const Matrix& root, Index contact);
  void keep_what_moves(Index rows);
  void set_start();
  void project(const Vector& w, Vector& rows) const;
  void combine(const Vector& rows, Vector& w) const;
  double natural_residual() const;
  /// Keeps x_ if its residual is the least so far. @returns the residual @pre that of natural_residual()
  double keep_best();
  Stop iterate(Slip slip, const ConeLimits& limits, Counters& counters);
  bool factor();
  bool factor_scaled(Slip slip);
  void find_step(Slip slip);
  void find_residual(Slip slip);
  double convex_residual(const Vector& y) const;
  void take_rigid_velocity();
  void take_velocity();
  void press(double weight);
  void press_on_cone(std::size_t index, const Eigen::Vector3d& pressed, const Eigen::Vector3d& step);
  bool settle_multipliers(double weight, int most_steps, const ConeLimits& limits, Counters& counters);
  bool try_multipliers(double first_weight, const ConeLimits& limits, Counters& counters);
  void drop_separating(const ConeLimits& limits);
  void finish(const ConeLimits& limits, Counters& counters);
  bool scale(std::size_t index, Slip slip);
  void find_direction(Slip slip);
  void set_target(std::size_t index, double centre);
  double longest_step() const;
  double gap_after(double length) const;

  std::vector<Contact> contacts_;
  std::vector<Index> columns_;   // coordinates that contacts move
  std::vector<double> entries_;  // rows x columns of each contact, by columns
  Matrix root_;                  // Z with Z Z' = G*
  Vector momentum_, whitened_;   // scratch: of ngc, and Z' times it
  double unit_ = 1;              // of speeds and impulses in here: a power of two, so that no square leaves the range
  bool is_relaxed_ = false;      // solves the relaxation
  bool is_soft_ = false;         // some R is not zero
  Vector q_;                     // rows: J'v + b, the normal ones divided by mu
  double q_max_ = 0;             // largest approach or slip, in [1, 2), or 0; infinite where J'v is not finite
  double approach_ = 0, floor_ = 0;  // see ContactScale, in unit_
  double scale_ = 0;                 // what residuals are relative to, of what is solved, in unit_
  Vector x_, y_, w_, u_, slip_;
  Vector dx_, dy_, target_, residual_, rows_, dw_;
  std::vector<Scaling> scalings_;
  DenseLu lu_;
  Vector x_held_;
  Vector best_x_;
  double best_residual_ = 0;
};

}  // namespace lcpbench
