#pragma once

#include "core/problem.h"
#include "native/contact_input.h"
#include "native/contact_lemke.h"

namespace lcpbench {

/// Half of what the evaluation allows, to be on its safe side whatever the test itself rounds: velocity residual
/// relative to max|q| of contact problems.
inline constexpr double kClaimedResidual = 5e-5;

/// Whether an answer solves a contact problem, from its factors: for methods that work on M. M as rounded is another
/// problem where the inertia is near singular, and its exact solution may be none of the contacts'.
class ContactTest {
 public:
  ContactTest() : judge_(contact_lemke_engine(isa_level())) {}

  /// Bare LCPs have nothing to test. @param problem must stay as it is until the next load. O(ngc^3)
  void load(const Problem& problem);

  /// True where the velocity residual of z with its estimated rounding is within kClaimedResidual of max|q|,
  /// and for bare LCPs. Every positive entry counts as in the basis: w has to vanish there. Allocates nothing.
  bool passes(const Vector& z);

 private:
  LoadedContacts judge_;
  ContactInput contacts_;
  Vector completed_;  ///< n; empty of a bare LCP
  bool bare_ = true;
};

}  // namespace lcpbench
