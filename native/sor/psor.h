#pragma once

#include <cstdint>
#include <memory>

#include "core/settings.h"
#include "native/contacts/budgeted_solver.h"

namespace lcpbench {

struct PsorSettings {
  enum class Parts { kExact, kNone };

  std::int64_t max_iterations = 10000;
  double relaxation = 1.3;
  double tolerance = 1e-8;
  Parts parts = Parts::kExact;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 0}, "sweeps over all contacts (rows of a bare LCP)");
    field("relaxation", relaxation, RealRange{.min = 0x1p-10, .max = 2 - 0x1p-10},
          "factor on each step: 1 is Gauss-Seidel, more is over-relaxation");
    field("tolerance", tolerance, RealRange{.min = 0},
          "an answer is tested, and claimed if it passes, when the velocity residual of every island, evaluated in "
          "double, is at most min(this, 5e-5) times the scale of the island; of a bare LCP times its max|q|");
    field("parts", parts, Choices<Parts>{{{"exact", Parts::kExact}, {"none", Parts::kNone}}},
          "exact: a step along a direction conjugate to the last ones after each sweep, and contact_lemke solves groups "
          "of contacts on which the sweeps make no progress; none: sweeps alone");
  }
};

/// psor. Its budget is looked at after each sweep over all contacts.
class PsorSolver : public BudgetedSolver {
 public:
  /// u := v + G* [N D] f, the velocity of the coordinates after the impulses f of z. O(nonzeros). Allocates nothing.
  /// @pre a contact problem is loaded @param z n entries; lambda is not used
  /// @param u ngc entries, set
  virtual void respond(const Vector& z, Vector& u) = 0;
};

std::unique_ptr<PsorSolver> make_psor(const PsorSettings& settings);

}  // namespace lcpbench
