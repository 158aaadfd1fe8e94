#pragma once

#include "core/compliance.h"
#include "core/solver.h"

namespace lcpbench {

/// Whether no contact has friction and all yield. Some methods take such a problem as it is, and any other soft one by
/// its rigid equivalent: before each load they choose between their capabilities and with_compliance() of them.
inline bool yields_without_friction(const Problem& problem) {
  const ContactProblem* contact = problem.kind() != ProblemKind::kLcp ? problem.contact() : nullptr;
  return contact != nullptr && !contact->frictional() && every_contact_yields(*contact);
}
constexpr Capabilities with_compliance(Capabilities capabilities) {
  capabilities.compliance = true;
  return capabilities;
}

/// A solver of contact problems whose solve() can be done in parts, so that several can take turns at one problem.
///
/// Work is counted in multiplications of doubles, or what takes as long; it depends on the data alone, never on a
/// clock, so that whoever shares work out gets the same answers on every machine and under every load.
class ResumableSolver : public Solver {
 public:
  /// Begins a solve of what is loaded. Does next to no work, beside a product of the data with a start; allocates
  /// nothing.
  /// @param start n, a guess at z, or nullptr; must stay valid until the solve has ended
  /// @param error velocity residual, relative to the scale of each island, that an answer may leave; 0: the method's own
  virtual void begin(const Vector* start, double error) = 0;

  /// Goes on until it has done about `work` more, or is done. The end does not depend on the parts: the same answer bit
  /// for bit as in one part. Allocates nothing where solve() allocates nothing.
  /// @param deadline_s on wall_clock_s(); it ends the solve with kTimeLimit
  /// @returns whether the solve has ended; only then `answer` is written, as by solve()
  virtual bool go_on(double work, double deadline_s, Answer& answer) = 0;

  /// Since begin(), in all.
  virtual double work() const = 0;

  /// The best impulses so far, with the least lambdas that they allow. May cost a few products with the data.
  /// @param z n entries @returns their velocity residual in double, relative to the scale of each island, of the worst
  /// island; infinity where there are none, and then z is not written
  virtual double best(Vector& z) = 0;

  /// Whether that residual tells how far the solve has come.
  virtual bool residual_tells() const { return true; }
};

}  // namespace lcpbench
