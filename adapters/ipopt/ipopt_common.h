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

/// The options that solved every problem of a trial set on which Ipopt's own defaults left a third above 1e-6.
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

/// The parts of Ipopt's interface that our programs share.
class QuietProgram : public Ipopt::TNLP {
 public:
  /// The final point; empty when Ipopt never came that far.
  const Vector& solution() const { return solution_; }

  void finalize_solution(Ipopt::SolverReturn, Ipopt::Index n, const Ipopt::Number* x, const Ipopt::Number*,
                         const Ipopt::Number*, Ipopt::Index, const Ipopt::Number*, const Ipopt::Number*, Ipopt::Number,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    solution_ = Eigen::Map<const Vector>(x, n);
  }

 protected:
  static constexpr double kInfinity = 2e19;  // beyond Ipopt's nlp_upper_bound_inf: no bound

 private:
  Vector solution_;
};

/// The properties of a program that Ipopt is told besides its settings.
struct IpoptHints {
  bool constant_derivatives = true;  ///< linear constraints and a quadratic objective
  double mu_init = 0.1;              ///< the first barrier parameter; 0.1 is Ipopt's default
};

/// Runs Ipopt on `program`. Sets claim, iteration count and detail of the answer, not its z.
void run_ipopt(const Ipopt::SmartPtr<QuietProgram>& program, const IpoptSettings& settings, double time_limit_s,
               Answer& answer, const IpoptHints& hints = {});

#endif

}  // namespace lcpbench
