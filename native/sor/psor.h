#pragma once

#include <cstdint>
#include <memory>

#include "core/settings.h"
#include "native/contacts/resumable_solver.h"

namespace lcpbench {

struct PsorSettings {
  enum class Acceleration { kNone, kConjugate, kLocal, kExact };

  std::int64_t max_iterations = 10000;
  double relaxation = 1.3;
  double tolerance = 1e-8;
  Acceleration acceleration = Acceleration::kNone;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "sweeps over all contacts (rows of a bare LCP)");
    field("relaxation", relaxation, RealRange{.min = 0x1p-10, .max = 2 - 0x1p-10},
          "factor on each step: 1 is Gauss-Seidel, more is over-relaxation");
    field("tolerance", tolerance, RealRange{.min = 0},
          "an answer is tested, and then claimed, when the velocity residual of every island, evaluated in double, is "
          "at most this (5e-5, if this is more) times max|q| of the island");
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

/// psor that solves in parts, which end after sweeps over all contacts, or between steps of exact parts.
class ResumablePsor : public ResumableSolver {
 public:
  /// The velocity that these impulses give to the contacts that are loaded, O(nonzeros). Allocates nothing.
  /// @param z n entries @param u ngc entries
  virtual void respond(const Vector& z, Vector& u) = 0;
};

std::unique_ptr<ResumablePsor> make_psor(const PsorSettings& settings);

}  // namespace lcpbench
