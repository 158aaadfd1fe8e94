// Ipopt on the LCP through Scholtes's relaxation: a sequence of programs with z_i w_i <= t, t falling to zero.
#include <algorithm>
#include <limits>

#include "adapters/define_adapter.h"
#include "adapters/ipopt/ipopt_common.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

constexpr Capabilities kIpoptScholtesCapabilities{.guarantees = "none: the relaxed programs are not convex",
                                     .obeys_time_limit = true};

struct IpoptScholtesSettings : IpoptSettings {
  double first_relaxation = 0.1;
  double reduction = 1e-3;
  std::int64_t programs = 8;
  double residual_tolerance = 1e-8;

  void visit(auto&& field) {
    IpoptSettings::visit(field);
    field("first_relaxation", first_relaxation, RealRange{.min = 1e-300, .max = 1e10}, "t of the first program");
    field("reduction", reduction, RealRange{.min = 1e-12, .max = 0.9}, "each t is this times the one before");
    field("programs", programs, IntegerRange{.min = 1, .max = 1000}, "at most");
    field("residual_tolerance", residual_tolerance, RealRange{.min = 0.0},
          "solved when max|min(z, Mz + q)| <= this times max(1, max|q|)");
  }
};

class IpoptScholtes;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// Ipopt takes no limit of zero.
constexpr double kShortestTimeLimit_s = 1e-3;

class IpoptScholtes final : public Solver {
 public:
  explicit IpoptScholtes(const IpoptScholtesSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kIpoptScholtesCapabilities; }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    const Index n = lcp_.size();
    if (n == 0) {
      answer.claim = Claim::kSolved;
      return;
    }
    const double begin_s = wall_clock_s();
    const double tolerance = settings_.residual_tolerance * std::max(1.0, lcp_.q.lpNorm<Eigen::Infinity>());
    Vector point = first_point(lcp_);
    std::int64_t iterations = 0;
    double t = settings_.first_relaxation;
    for (std::int64_t i = 0; i < settings_.programs; ++i, t *= settings_.reduction) {
      const Ipopt::SmartPtr<QuietProgram> program = complementarity_program(lcp_, point, t);
      run_ipopt(program, settings_, std::max(kShortestTimeLimit_s, request.time_limit_s - (wall_clock_s() - begin_s)),
                answer, {.constant_derivatives = false, .mu_init = std::min(0.1, t)});
      if (program->solution().size() == 2 * n) point = program->solution();
      iterations += std::max<std::int64_t>(0, answer.counters.iterations);
      if (residual(point.head(n)) <= tolerance || answer.claim == Claim::kTimeLimit) break;
    }
    answer.counters.iterations = iterations;
    answer.z = point.head(n);
    const bool solved = residual(answer.z) <= tolerance;  // what Ipopt says is of the last program, not of the LCP
    if (solved) answer.claim = Claim::kSolved;
    if (!solved && answer.claim == Claim::kSolved) answer.claim = Claim::kNumericalFailure;
    answer.detail += ", t = " + format_real(t);
  }

 private:
  /// Infinity for a z that is not finite: a maximum need not see NaN.
  double residual(const Vector& z) const {
    const Vector w = lcp_.M * z + lcp_.q;
    if (!z.allFinite() || !w.allFinite()) return std::numeric_limits<double>::infinity();
    return z.cwiseMin(w).lpNorm<Eigen::Infinity>();
  }

  IpoptScholtesSettings settings_;
  Lcp lcp_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ipopt_scholtes() {
  return define_adapter<IpoptScholtes, IpoptScholtesSettings>(
      {.name = "ipopt_scholtes",
       .summary = "Ipopt on a sequence of relaxed complementarity programs, z_i w_i <= t",
       .source = "Scholtes 2001, SIAM J. Optim. 11; Waechter, Biegler 2006",
       .capabilities = kIpoptScholtesCapabilities});
}

}  // namespace lcpbench
