#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "core/spec.h"
#include "study/evaluation/evaluation.h"
#include "study/models/pyramid.h"

namespace lcpbench {

/// The models of friction, from the coarsest on. docs/explanation/friction-models.md says when each is used.
enum class ContactModel {
  kNothing,       ///< no contacts at all: what any model must be better than
  kNormals,       ///< no friction
  kRest,          ///< the solution in which no pressed contact slips, where there is one
  kEdges4,        ///< a pyramid of 4 edges along the tangents
  kEdges4Turned,  ///< the same, solved again with an edge against the slip of the last pass
  kEdges8,
  kEdges8Turned,
  kEdges16,
  kEdges16Turned,
  kSoft,       ///< the same as kRelaxed, of contacts that are soft enough to give way by about the error asked for
  kRelaxed,    ///< the convex relaxation of the cone, in which sliding contacts lift off
  kConeRough,  ///< the cone, solved only as far as the error that is asked for
  kCone,       ///< the round Coulomb cone
};

inline constexpr std::array kContactModels{
    ContactModel::kNothing,       ContactModel::kNormals, ContactModel::kRest,         ContactModel::kEdges4,
    ContactModel::kEdges4Turned,  ContactModel::kEdges8,  ContactModel::kEdges8Turned, ContactModel::kEdges16,
    ContactModel::kEdges16Turned, ContactModel::kSoft,    ContactModel::kRelaxed,      ContactModel::kConeRough,
    ContactModel::kCone};

/// "nothing", "normals", "rest", "4", "4-turned", ..., "soft", "relaxed", "cone-rough", "cone".
const char* to_string(ContactModel model);

/// What one model makes of one island.
struct ModelAnswer {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  ContactModel model = ContactModel::kNormals;
  Claim claim = Claim::kNumericalFailure;
  Vector impulses{};  ///< z of the island's tangents; empty without an answer
  Vector velocity{};  ///< v+ of the island; empty without an answer
  /// The residual of the cone's own conditions [m/s], by the evaluation: the error of model and solver together.
  double error_m_per_s = kNone;
  /// The residual of the model's own conditions [m/s], by the evaluation: the solver's part. Of kRest none is known:
  /// its conditions are no problem that the evaluation knows.
  double solver_error_m_per_s = kNone;
  double time_s = kNone;  ///< set-up and solve, thread CPU, of all passes
  int passes = 0;         ///< problems solved one after the other

  bool answered() const { return velocity.size() > 0; }
  bool meets(double error) const { return answered() && error_m_per_s <= error; }
};

/// NaN, the error where there is no answer, stays.
inline double larger_or_nan(double a, double b) { return std::isnan(a) || b <= a ? a : b; }

/// The error at which turning ends, if nothing coarser is asked for [m/s].
inline constexpr double kFinestTurn = 1e-10;

/// One island of a problem, to be solved by one model after the other.
class Ladder {
 public:
  /// @param tangents contacts of 4 edges or none: see with_tangents() @param time_limit_s on each solve
  Ladder(ContactProblem tangents, double time_limit_s);

  const ContactProblem& contacts() const { return *reference_.contact(); }

  /// @param error [m/s] at which turning and kConeRough stop, and that kSoft may cost
  ModelAnswer climb(ContactModel model, double error);

 private:
  void take(const TangentImpulses& impulses, ModelAnswer& to);
  double error_of(const Vector& z, double Errors::*measure);
  void solve_pyramid(int edges, const std::vector<double>& angles, ModelAnswer& to, TangentImpulses& impulses);
  ModelAnswer pyramid(ContactModel model, double error);
  ModelAnswer by_cone(ContactModel model, double error);
  ModelAnswer nothing();

  Problem reference_;  ///< the island's contacts
  double time_limit_s_;
  Evaluator evaluator_;  ///< of answers to it
};

/// A problem by its islands.
struct LadderIsland {
  std::vector<Index> contacts;     ///< of the problem
  std::vector<Index> coordinates;  ///< of the problem
  std::unique_ptr<Ladder> ladder;
};

/// @throws InputError naming `file` for a bare LCP, and where the friction directions name no cone
std::vector<LadderIsland> ladder_islands(const Problem& problem, const std::string& file, double time_limit_s);

/// The models that `solve --max-velocity-error` climbs: those that cost less than the one above them on most captured
/// steps.
inline constexpr std::array kClimbed{ContactModel::kEdges4, ContactModel::kConeRough, ContactModel::kCone};

/// The solver of a model: `auto` without friction and on the pyramids, `cone_ipm{cone=true}` else.
/// @param error [m/s] at which kConeRough stops
Spec solver_of(ContactModel model, double error);

/// An island solved as finely as asked for.
struct Climb {
  ModelAnswer chosen;  ///< the first that meets the error, or the best
  bool met = false;
  double spent_s = 0;  ///< CPU time of all models tried, without `next`
  ModelAnswer next;     ///< by the cone, where a coarser model met the error; else not answered
  double change_m_per_s = ModelAnswer::kNone;  ///< largest difference of contact velocities, `next` against `chosen`
};

Climb climb(Ladder& ladder, double error);

}  // namespace lcpbench
