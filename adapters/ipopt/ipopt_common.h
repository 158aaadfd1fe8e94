#pragma once

// Shared by the Ipopt adapters: their settings, and a run of Ipopt on one nonlinear program that prints nothing.

#include <cstdint>

#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#endif

namespace lcpbench {

/// Tolerances below Ipopt's own, with which a third of the answers to a trial set missed a residual of 1e-6.
struct IpoptSettings {
  double tol = 1e-10;
  double acceptable_tol = 1e-8;
  std::int64_t max_iter = 3000;

  void visit(auto&& field) {
    field("tol", tol, RealRange{.min = 1e-300, .max = 1.0}, "Ipopt's tol; the library's own default is 1e-8");
    field("acceptable_tol", acceptable_tol, RealRange{.min = 1e-300, .max = 1.0},
          "Ipopt's acceptable_tol; the library's own default is 1e-6");
    field("max_iter", max_iter, IntegerRange{.min = 1, .max = 1000000000}, "Ipopt's max_iter; 3000 is Ipopt's default");
  }
};

#ifndef LCPBENCH_DESCRIBE_ONLY

/// A program that keeps its final point; derived classes define the functions.
class NonlinearProgram : public Ipopt::TNLP {
 public:
  /// The final point; empty if Ipopt returned none.
  const Vector& solution() const { return solution_; }

  void finalize_solution(Ipopt::SolverReturn, Ipopt::Index n, const Ipopt::Number* x, const Ipopt::Number*,
                         const Ipopt::Number*, Ipopt::Index, const Ipopt::Number*, const Ipopt::Number*, Ipopt::Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    solution_ = Eigen::Map<const Vector>(x, n);
  }

 protected:
  static constexpr double kInfinity = 2e19;  // no bound: Ipopt takes 1e19 and more as infinite (nlp_upper_bound_inf)

 private:
  Vector solution_;
};

/// Runs Ipopt on `program`. Sets claim, iteration count and detail of the answer, not its z.
/// @pre linear constraints and a quadratic objective: Jacobian and Hessian are evaluated once
/// @param settings  an acceptable_tol below tol counts as tol
/// @param time_limit_s  of CPU time (max_cpu_time), > 0
void run_ipopt(const Ipopt::SmartPtr<NonlinearProgram>& program, const IpoptSettings& settings, double time_limit_s,
               Answer& answer);

#endif

}  // namespace lcpbench
