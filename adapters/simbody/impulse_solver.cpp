#include "adapters/simbody/impulse_solver.h"

#include <memory>

#include <simbody/internal/PGSImpulseSolver.h>
#include <simbody/internal/PLUSImpulseSolver.h>

namespace lcpbench::simbody {
namespace {

std::unique_ptr<SimTK::ImpulseSolver> make(const Request& request) {
  std::unique_ptr<SimTK::ImpulseSolver> solver;
  if (request.method == Method::kPgs) {
    solver = std::make_unique<SimTK::PGSImpulseSolver>(request.slip_speed);
  } else {
    solver = std::make_unique<SimTK::PLUSImpulseSolver>(request.slip_speed);
  }
  solver->setConvergenceTol(request.tolerance);
  solver->setMaxIterations(request.max_iterations);
  return solver;
}

SimTK::Array_<SimTK::ImpulseSolver::UniContactRT> as_simbody(const std::vector<Contact>& contacts) {
  SimTK::Array_<SimTK::ImpulseSolver::UniContactRT> result;
  for (const Contact& contact : contacts) {
    SimTK::ImpulseSolver::UniContactRT entry;
    entry.m_ucx = SimTK::UnilateralContactIndex(static_cast<int>(result.size()));
    entry.m_Nk = SimTK::MultiplierIndex(contact.normal_row);
    entry.m_type = SimTK::ImpulseSolver::Participating;
    entry.m_effCOR = 0;
    if (contact.friction) {
      entry.m_Fk.push_back(SimTK::MultiplierIndex(contact.normal_row + 1));
      entry.m_Fk.push_back(SimTK::MultiplierIndex(contact.normal_row + 2));
      entry.m_effMu = contact.mu;
    }
    result.push_back(entry);
  }
  return result;
}

}  // namespace

/// Simbody's problem is (A + D) pi = verr, where an impulse that pushes is negative: A = W, D = 0, verr = q, pi = -r.
bool solve(const Request& request, const std::vector<Contact>& contacts, int m, const double* W, const double* q,
           double* r) {
  SimTK::Matrix A(m, m);
  SimTK::Vector verr(m);
  SimTK::Array_<SimTK::MultiplierIndex> participating;
  for (int i = 0; i < m; ++i) {
    verr[i] = q[i];
    participating.push_back(SimTK::MultiplierIndex(i));
    for (int j = 0; j < m; ++j) A(i, j) = W[i + m * j];
  }
  auto in_contact = as_simbody(contacts);
  const SimTK::Vector D(m, 0.0);
  SimTK::Vector expansion(m, 0.0);
  SimTK::Vector applied(m, 0.0);
  SimTK::Vector pi(m, 0.0);
  const SimTK::Array_<SimTK::MultiplierIndex> expanding;
  SimTK::Array_<SimTK::ImpulseSolver::UncondRT> unconditional;
  SimTK::Array_<SimTK::ImpulseSolver::UniSpeedRT> speeds;
  SimTK::Array_<SimTK::ImpulseSolver::BoundedRT> bounded;
  SimTK::Array_<SimTK::ImpulseSolver::ConstraintLtdFrictionRT> constraint_friction;
  SimTK::Array_<SimTK::ImpulseSolver::StateLtdFrictionRT> state_friction;
  constexpr int kPhase = 0;  // Simbody keeps its statistics by phase
  const bool solved =
      make(request)->solve(kPhase, participating, A, D, expanding, expansion, verr, applied, pi, unconditional,
                           in_contact, speeds, bounded, constraint_friction, state_friction);
  for (int i = 0; i < m; ++i) r[i] = -pi[i];
  return solved;
}

}  // namespace lcpbench::simbody
