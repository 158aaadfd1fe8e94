#pragma once

#include <cstdint>
#include <memory>

#include "core/settings.h"
#include "native/contacts/resumable_solver.h"

namespace lcpbench {

struct PsorSettings {
  enum class Order { kForward, kSymmetric };
  enum class Acceleration { kNone, kConjugate, kLocal, kExact };

  std::int64_t max_iterations = 10000;
  double relaxation = 1.3;
  double tolerance = 1e-8;
  Order order = Order::kForward;
  Acceleration acceleration = Acceleration::kNone;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "sweeps over all contacts (rows of a bare LCP)");
    field("relaxation", relaxation, RealRange{.min = 0x1p-10, .max = 2 - 0x1p-10},
          "factor on each step: 1 is Gauss-Seidel, more is over-relaxation");
    field("tolerance", tolerance, RealRange{.min = 0},
          "an answer is tested, and then claimed, when the velocity residual of every island, evaluated in double, is "
          "at most this times max|q| of the island");
    field("order", order, Choices<Order>{{{"forward", Order::kForward}, {"symmetric", Order::kSymmetric}}},
          "every sweep in the order given, or every second one backwards");
    field("acceleration", acceleration,
          Choices<Acceleration>{{{"none", Acceleration::kNone},
                                 {"conjugate", Acceleration::kConjugate},
                                 {"local", Acceleration::kLocal},
                                 {"exact", Acceleration::kExact}}},
          "between sweeps: nothing; a step along a direction conjugate to the last ones; or that, and sweeps over the "
          "contacts that are far off where these are few; or those, and contacts about which the sweeps wander are "
          "solved by contact_lemke");
  }
};

/// psor with limits that may change from one solve to the next. A solve in parts begins with the settings given, its
/// parts end after sweeps over all contacts.
class LimitedPsor : public ResumableSolver {
 public:
  /// From now on acceleration=exact, or local.
  virtual void take_parts(bool exact) = 0;
  /// From now on at most so many sweeps at the default relaxation, and solved is claimed up to this residual.
  virtual void limit_sweeps(std::int64_t sweeps, double tolerance) = 0;
  /// From now on solved is claimed up to this residual, be it more than the verdict allows.
  virtual void aim_at(double residual) = 0;
  /// From now on psor's defaults; with acceleration=exact 100,000 sweeps with relaxation 1, another path than that of
  /// limited sweeps.
  virtual void unlimit_sweeps() = 0;

  /// The velocity that these impulses give to the contacts that are loaded, O(nonzeros). Allocates nothing.
  /// @param z n entries @param u ngc entries
  virtual void respond(const Vector& z, Vector& u) = 0;
};

std::unique_ptr<LimitedPsor> make_psor(const PsorSettings& settings);

/// With acceleration=exact, not limited.
std::unique_ptr<LimitedPsor> make_limited_psor();

}  // namespace lcpbench
