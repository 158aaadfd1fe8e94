#include "adapters/ipopt/ipopt_common.h"

#include <algorithm>
#include <utility>

namespace lcpbench {

/// Ipopt's status of a run as a claim. Both of its kinds of success are kSolved.
static Claim ipopt_claim(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level: return Claim::kSolved;
    case Ipopt::Infeasible_Problem_Detected: return Claim::kUnsolvable;
    case Ipopt::Maximum_Iterations_Exceeded: return Claim::kIterationLimit;
    case Ipopt::Maximum_CpuTime_Exceeded: return Claim::kTimeLimit;
    default: return Claim::kNumericalFailure;
  }
}

void run_ipopt(const Ipopt::SmartPtr<NonlinearProgram>& program, const IpoptSettings& settings, double time_limit_s,
               Answer& answer) {
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
  const Ipopt::SmartPtr<Ipopt::OptionsList> options = application->Options();
  options->SetIntegerValue("print_level", 0);
  options->SetStringValue("sb", "yes");
  options->SetNumericValue("tol", settings.tol);
  options->SetNumericValue("acceptable_tol", std::max(settings.tol, settings.acceptable_tol));
  options->SetIntegerValue("max_iter", static_cast<Ipopt::Index>(settings.max_iter));
  options->SetNumericValue("max_cpu_time", std::min(time_limit_s, 1e6));
  options->SetNumericValue("bound_relax_factor", 0.0);
  options->SetStringValue("honor_original_bounds", "yes");
  options->SetStringValue("mu_strategy", "adaptive");
  options->SetStringValue("nlp_scaling_method", "none");
  options->SetStringValue("hessian_constant", "yes");
  options->SetStringValue("jac_c_constant", "yes");
  if (application->Initialize("") != Ipopt::Solve_Succeeded) {
    answer.detail = "Ipopt refused its options";
    return;
  }
  const Ipopt::ApplicationReturnStatus status =
      application->OptimizeTNLP(Ipopt::SmartPtr<Ipopt::TNLP>(Ipopt::GetRawPtr(program)));
  answer.claim = ipopt_claim(status);
  const Ipopt::SmartPtr<Ipopt::SolveStatistics> statistics = application->Statistics();
  if (Ipopt::IsValid(statistics)) answer.counters.iterations = statistics->IterationCount();
  answer.detail = "Ipopt status " + std::to_string(static_cast<int>(status));
}

}  // namespace lcpbench
