#pragma once

#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/auto/attempts.h"
#include "native/auto/islands.h"
#include "native/auto/report.h"
#include "native/auto/settings.h"

namespace lcpbench {

/// Contacts with the coordinates that they move, as a problem of their own, with the method for its class and size.
class IslandPart {
 public:
  IslandPart(const AutoSettings& settings, SharedMethods& shared, Attempts::Scope scope)
      : attempts_(settings, shared, scope) {}

  /// Cuts the problem out and takes the memory to solve it.
  /// @param whole, part must outlive the next load @param v velocity of the whole problem
  /// @param in_turn see Attempts::load @param to_hold see Attempts::load_to_hold
  void load(ProblemCutter& whole, const Island& part, const Vector& v, bool in_turn = false, bool to_hold = false);
  /// The same, but the work is put off until an update(), or a solve(), which then does it by a dense method.
  /// @returns false where no dense method will do, and the work was done
  bool load_when_needed(ProblemCutter& whole, const Island& part, const Vector& v);

  /// True if a solve before the next update() uses another method in place of velocity_ipm. That method may take a
  /// hundred times as long.
  bool has_stand_in() const { return attempts_.has_stand_in(); }

  /// Another velocity of the whole problem. Does what was put off.
  void update(const Vector& v);
  /// The same, but what was put off stays so. Allocates nothing.
  void set_velocity(const Vector& v);

  /// Solves it by its method, and where that gives up by those that follow. Allocates only if a second method,
  /// one that is not dense, has to be loaded.
  /// @param start of the whole problem, or nullptr
  /// @returns the claim of answer()
  Claim solve(const Vector* start, const AutoLimits& limits, AutoReport& report);

  const Answer& answer() const { return answer_; }
  const std::vector<Index>& contacts() const { return part_->contacts; }
  /// Whether the answer has lambdas for those of its contacts that have any.
  bool carries_friction() const { return problem_.contact()->frictional(); }

  // After a solve that ended in kSolved:

  /// Whether the solver gave a velocity of its own.
  bool gave_velocity() const { return answer_.velocity.size() > 0; }
  /// The impulses in z of the whole.
  void write_impulses(Vector& z) const;
  /// The velocity in u of the whole. O(ngc^2) where the solver gave none.
  void write_velocity(Vector& u);
  /// The velocity before, in u of the whole.
  void take_back_velocity(Vector& u) const { write(v_, u); }

 private:
  void cut(ProblemCutter& whole, const Island& part, const Vector& v);
  void place_unknowns(const ContactLayout& layout);
  void take_velocity(const Vector& v);
  void write(const Vector& own, Vector& u) const;

  const Island* part_ = nullptr;
  Problem problem_;
  std::vector<Index> place_;  ///< in z of the whole, of each unknown
  Vector v_, u_, start_;
  Answer answer_;
  Attempts attempts_;
};

}  // namespace lcpbench
