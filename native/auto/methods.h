#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "native/active_set/least_energy.h"
#include "native/auto/report.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/contacts/budgeted_solver.h"

namespace lcpbench {

/// One solver of each method, made when it is first needed, and the problem that they hold.
class Methods {
 public:
  /// @param later what the stages of contact_lemke beyond double run on
  explicit Methods(std::shared_ptr<LaterEngines> later) : later_(std::move(later)) {}

  /// Whether it works on dense matrices.
  static bool is_dense(AutoMethod method) {
    return method == AutoMethod::kActiveSet || method == AutoMethod::kContactLemke;
  }
  /// Whether the method takes the problem, and the memory for it: dense ones need about ngc (ngc + nc) numbers.
  static bool takes(AutoMethod method, const Problem& problem);

  /// Multiplications of the load of a dense method; 0 of others. O(1) @param idle coordinates that no contact moves
  static double load_work(AutoMethod method, const Problem& problem, Index idle);

  /// Takes the memory of a dense method, and of the impulses of least energy, which a later load then finds.
  void reserve(AutoMethod method, const Problem& problem, bool with_least_energy);

  /// Another problem: all solvers have to be loaded again. Loads none.
  /// @param problem must stay valid until the next begin(), v until that or the next set_velocity()
  void begin(const Problem& problem, const Vector& v, bool is_one_island);
  /// Another velocity for the problem, also for the solvers that are loaded later. Updates all that are loaded.
  /// @param v must stay valid until the next call of this or begin()
  void set_velocity(const Vector& v);

  /// Whether the solver holds the problem.
  bool has(AutoMethod method) const { return is_loaded_[static_cast<std::size_t>(method)]; }
  /// The solver with the problem loaded. Allocates what it needs.
  BudgetedSolver& loaded(AutoMethod method);
  LeastEnergy& loaded_least_energy();

  /// The velocity of impulses for which the method gave none. psor O(nonzeros), contact_lemke O(ngc^2), others O(ngc^3)
  void respond(AutoMethod method, const Vector& z, Vector& u);

 private:
  BudgetedSolver& made(AutoMethod method);

  std::shared_ptr<LaterEngines> later_;
  const Problem* problem_ = nullptr;
  const Vector* v_ = nullptr;
  bool is_one_island_ = false;
  std::array<std::unique_ptr<BudgetedSolver>, kAutoMethods> solvers_;
  std::array<bool, kAutoMethods> is_loaded_{};
  std::unique_ptr<LeastEnergy> least_energy_;
  bool has_least_energy_ = false;  ///< it holds the problem
};

}  // namespace lcpbench
