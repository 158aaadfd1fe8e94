#pragma once

#include <array>
#include <memory>

#include "core/contact_problem.h"
#include "core/solver.h"
#include "native/contacts/island_units.h"
#include "native/velocity_ipm/coupled_compliance.h"
#include "native/velocity_ipm/settings.h"
#include "native/velocity_ipm/whitened_normals.h"

namespace lcpbench {

/// Mehrotra's predictor-corrector method in velocity space for frictionless contact problems,
///
///     minimize 1/2 (u - v)'G (u - v) + 1/2 f'R f subject to N'u + b + R f >= 0,
///
/// the multipliers f being the impulses, and R = diag(r_n) plus the CoupledCompliance, if any. Each step factors one
/// matrix of the order of the velocity (ngc), whatever the number and redundancy of the contacts. In coordinates where
/// G = I, and without coupling, it is I + W diag(f / (s + (shift + r_n) f)) W'; the shift, 1e-12 max M_ii, is added to
/// the diagonal of M = N'G*N + R. WhitenedNormals factors the matrix. [Mehrotra 1992; Wright 1997, ch. 10;
/// docs/reference/solvers/velocity_ipm.md]
///
/// Every island is solved in its own unit (IslandUnits), so that the scale, to which the residual is relative, is that
/// of each island.
///
/// Life: load(), then for each velocity set_velocity(), begin(), iterate(), iterated(), perhaps finish(),
/// impulses() or conclude(). Only load(), keep_points(), the factorization of the WhitenedNormals and the text that
/// conclude() writes may allocate.
class InteriorPoint {
 public:
  /// The residual up to which conclude() claims an answer, unless the tolerance is larger.
  static constexpr double kAcceptedResidual = 3e-5;

  explicit InteriorPoint(const InteriorPointSettings& settings) : settings_(settings) { aim_at(settings.tolerance); }

  /// @param normals  nullptr where the inertia does not suit the algebra: then only load() and loaded() may be called
  /// @param coupled  a compliance that is added to the problem's, or empty
  void load(std::unique_ptr<WhitenedNormals> normals, const ContactProblem& contact, CoupledCompliance coupled = {});
  bool loaded() const { return normals_ != nullptr; }
  /// From now on until the next load(), iterate() keeps points for begin_near(). @pre loaded()
  void keep_points();
  void set_velocity(const Vector& v);
  /// With the constraints N'u + R f + offset >= 0 (nc) instead; islands are not rescaled. @pre b is zero
  /// @param scale  what residuals are relative to @param speed  the size of what impulses have to change, or less
  void set_velocity(const Vector& v, const Vector& offset, double scale, double speed);

  /// InteriorPointSettings::tolerance from now on.
  void aim_at(double tolerance) {
    settings_.tolerance = tolerance;
    accepted_ = std::max(tolerance, kAcceptedResidual);
  }
  /// The residual up to which conclude() claims an answer, until the next aim_at().
  void accept(double residual) { accepted_ = residual; }

  /// How an iteration ended: the tolerance is met; no step goes further; the Newton system could not be solved; a
  /// limit.
  enum class Stop { kConverged, kStalled, kBreakdown, kIterationLimit, kTimeLimit, kWorkLimit };

  /// Starts at the standard point.
  void begin();
  /// Starts at a point kept since begin(), for another offset: the one with the least residual that is at least three
  /// times `residual`; if none is, the one with the largest; begin() if none is kept. Nearer to the solution, impulses
  /// and velocities are too close to their boundaries to follow a change of that size. @pre keep_points()
  /// @param residual of the last solution, with the new offset, relative to the scale
  void begin_near(double residual);
  /// Iterates until counters.iterations is max_iterations, the wall clock is at deadline_s, or work() has grown by
  /// `work` and one step at least is done. Called again it goes on. Adds to the counters.
  Stop iterate(double work, double deadline_s, std::int64_t max_iterations, Counters& counters);
  /// Of all solves since this object was made, in the units of BudgetedSolver::work().
  double work() const { return work_; }

  /// After an iterate() that ended with `stop`. False when that ended the solve: `answer` says how (a limit; or nothing
  /// approaches, and z = 0 is the solution). True: the point reached awaits finish() and conclude().
  bool iterated(Stop stop, Answer& answer);

  /// Brings the velocities of the pressed contacts to zero by regularised Newton steps with one more factorization; of
  /// the points on the way the best one is kept.
  void finish(Counters& counters);

  /// Instead of finish(): no impulses at contacts that part.
  void drop_parting();

  /// Sets z and the claim: kSolved when the velocity residual, computed from z alone, is within what is accepted, else
  /// kNumericalFailure; `detail` says so where no step went further, or the Newton system failed.
  void conclude(Answer& answer);

  /// In the units of the islands (IslandUnits); after set_velocity(v, offset) in the units of its arguments.
  const Vector& impulses() const { return point_.f; }
  /// The size of q over the scale.
  double size_over_scale() const { return speed_ > 0 ? speed_ / scale_ : 1; }
  /// f of the contacts that are pressed rather than parting, in the same units; 0 for the others.
  void pressed_contacts(Vector& f) const;
  /// The best impulses and their residual, among the points at which it was called since begin() or begin_near().
  /// @param z nc entries
  double best(Vector& z);

 private:
  /// A point: f > 0, s > 0 and y, with residuals y - W f and W'y + R f + q - s.
  struct Point {
    Vector f;  // nc, impulses [N s]
    Vector s;  // nc, normal velocities [m/s]
    Vector y;  // change of velocity in whitened coordinates

    void resize(Index contacts, Index coordinates) {
      f.resize(contacts);
      s.resize(contacts);
      y.resize(coordinates);
    }
  };

  /// One point for each factor of 4 in the residual from 1 to 1e-9; the last place also takes smaller residuals.
  static constexpr std::size_t kKept = 16;
  struct Kept {
    Point point;
    double residual = 0;  ///< 0: none is kept
  };

  void keep(double residual);
  void forget_steps();
  void project_velocity(const Vector& v);
  void scale_islands();
  bool is_idle(Index contact) const;
  void measure_q(double speed);
  void write_impulses(const Vector& f, Vector& z) const;
  void set_start();
  void evaluate_residuals();
  bool factor(Counters& counters);
  bool factor_with(const Vector& weights);
  void find_direction();
  double longest_step() const;
  double gap_after(double step) const;
  void add_yielding(const Vector& f, Vector& s) const;
  double relative_residual(const Vector& f);

  InteriorPointSettings settings_;
  double accepted_ = 0;
  std::unique_ptr<WhitenedNormals> normals_;
  Jacobian N_;
  Vector b_;  // empty: zero
  IslandUnits units_;
  Vector v_;
  Vector q_;
  Vector compliance_;  // r_n; empty: zero
  CoupledCompliance coupled_;
  Vector diagonal_;    // M_ii
  double scale_ = 0;   // what residuals are relative to
  double speed_ = 0;   // see measure_q()
  Vector shifts_;  // shift + r_n

  Stop stop_ = Stop::kConverged;
  double best_ = 0;     // least residual of iterate() since begin() or begin_near()
  int idle_steps_ = 0;  // since best_ last fell to less than half
  WhitenedNormals::Cost cost_;
  double work_ = 0;
  double least_residual_ = 0;  // of best_impulses_
  Vector best_impulses_;
  Point point_, step_;
  std::array<Kept, kKept> kept_;
  bool keeps_points_ = false;
  Vector dual_residual_;    // y - W f
  Vector primal_residual_;  // W'y + R f + q - s
  Vector target_;           // what f s is to become, less f s
  Vector contacts_;         // scratch, nc
  Vector coordinates_;      // scratch
};

}  // namespace lcpbench
