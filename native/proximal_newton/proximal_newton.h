#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "native/answer_test/impulse_solver.h"
#include "native/proximal_newton/newton_matrix.h"
#include "native/velocity_ipm/settings.h"

namespace lcpbench {

struct ProximalNewtonSettings {
  double tolerance = 1e-9;
  std::int64_t max_iterations = 50000;

  void visit(auto&& field) {
    visit_tolerance(field, tolerance);
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "Newton steps, over all proximal problems");
  }
};

/// Solves contact problems with friction, also large sparse ones, as a sequence of soft ones.
///
/// From impulses f' a *proximal problem* is the contact problem in which each contact yields by s (f - f'), for a
/// compliance s that is added to its own. Where f = f' its solution is that of the contacts. [Rockafellar 1976,
/// Monotone operators and the proximal point algorithm] The velocity u decides its impulses, the normal one by max(0,
/// .), and friction as the nearest point of the pyramid's section, so that G (u - v) = J f(u) is a system of as many
/// equations as there are coordinates. It is solved by Newton's method for functions that are piecewise smooth, with a
/// step that is halved until the residual falls. [Qi, Sun 1993] Where Newton's method ends in a few steps, the next
/// problem yields less; where it does not end, it begins anew from the last f' with contacts that yield more.
///
/// Where the residual falls no more, the solve begins anew, once, with all contacts made soft: each also yields by a
/// compliance times f. That compliance then falls in steps to zero, and the impulses of each step begin the next.
///
/// Without friction every proximal problem is convex, and the sequence converges; with friction neither is proven. A
/// step costs one LU factorization of a matrix whose entries are those of G and the pairs of coordinates that a contact
/// moves. Takes inertia of full rank, and directions of regular polygons.
///
/// kSolved: the velocity residual, recomputed from z in double, is at most 1e-4 or the tolerance, and AnswerTest passes.
class ProximalNewton : public BestImpulseSolver<> {
 public:
  explicit ProximalNewton(const ProximalNewtonSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;
  double work() const override { return best_.work; }

 protected:
  /// What a velocity decides: impulses, and how they fall with the velocities of the contact's three rows.
  struct Response {
    Eigen::Matrix3Xd impulse;
    std::vector<Eigen::Matrix3d> slope;
    Vector velocity, left, momentum;  ///< u, u less the velocity that the impulses give, and that times G
    double size = std::numeric_limits<double>::infinity();  ///< of what is left, in the norm of G
  };

  /// The compliance that the first proximal problem adds, over the contact's own entries of M.
  static constexpr double kFirstShare = 0.1;

  /// Of one solve, between its steps.
  struct Progress {
    bool is_last = false;                                     ///< this proximal problem ends the solve
    double share = kFirstShare;                               ///< of the added compliance
    int steps = 0;                                            ///< of this proximal problem
    std::int64_t step_then = 0;                               ///< when the residual last fell to a half
    double halved = std::numeric_limits<double>::infinity();  ///< that residual
    double softness = 0;                                      ///< see kHarder
    bool has_softened = false;                                ///< it was above zero in this solve
    std::int64_t soft_since = 0;                              ///< when it last changed
  };

  void on_load(const Problem& problem) override;
  void begin(const Vector* start, double error) override;
  bool run(double work, double deadline_s) override;

  void begin_proximal();
  void respond(Response& to);
  void respond(std::size_t contact, Response& to) const;
  bool newton_step();
  void note();
  void soften();
  void harden();
  Index coordinates() const { return matrix_.G().cols(); }

  ProximalNewtonSettings settings_;
  double work_of_response_ = 0;
  std::vector<ContactRows> rows_;
  ContactPolygons polygons_;
  NewtonMatrix matrix_;
  Eigen::Matrix3Xd from_;  // impulses from which the contacts yield
  Vector from_velocity_;
  Eigen::Matrix3Xd compliance_;  // that is added to that of each row: s, and the softness times the mean M_nn
  Eigen::Matrix3Xd pull_;        // s f' of each row: with a smaller w a contact presses
  double mean_normal_ = 0;       // the mean M_nn
  Response now_at_, next_at_;
  Vector step_;
  Vector change_;  // scratch: impulses on the coordinates
  Progress now_;
};

/// At its defaults. A start gives the first impulses from which the contacts yield.
std::unique_ptr<BudgetedSolver> make_proximal_newton();

}  // namespace lcpbench
