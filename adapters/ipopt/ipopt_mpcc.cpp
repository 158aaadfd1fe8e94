// Ipopt on the LCP as a mathematical program with complementarity constraints, the product z'w in the objective.
#include "adapters/define_adapter.h"
#include "adapters/ipopt/ipopt_common.h"

namespace lcpbench {
namespace {

constexpr Capabilities kIpoptMpccCapabilities{.guarantees = "none: a local minimum with z'w > 0 is no solution",
                                     .obeys_time_limit = true};

struct IpoptMpccSettings : IpoptSettings {
  double complementarity_tolerance = 1e-6;

  void visit(auto&& field) {
    IpoptSettings::visit(field);
    field("complementarity_tolerance", complementarity_tolerance, RealRange{.min = 0.0},
          "a local minimum claims to be a solution when z'w <= this times max(1, max|q|)");
  }
};

class IpoptMpcc;

#ifndef LCPBENCH_DESCRIBE_ONLY

class IpoptMpcc final : public Solver {
 public:
  explicit IpoptMpcc(const IpoptMpccSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kIpoptMpccCapabilities; }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    const Index n = lcp_.size();
    if (n == 0) {
      answer.claim = Claim::kSolved;
      return;
    }
    const Ipopt::SmartPtr<QuietProgram> program = complementarity_program(lcp_, first_point(lcp_));
    run_ipopt(program, settings_, request.time_limit_s, answer);
    const Vector& point = program->solution();
    if (point.size() != 2 * n) return;
    answer.z = point.head(n);
    const double product = point.head(n).dot(point.tail(n));
    const double scale = std::max(1.0, lcp_.q.lpNorm<Eigen::Infinity>());
    if (answer.claim == Claim::kSolved && !(product <= settings_.complementarity_tolerance * scale)) {
      answer.claim = Claim::kNumericalFailure;
      answer.detail += ", a local minimum with z'w = " + format_real(product);
    }
  }

 private:
  IpoptMpccSettings settings_;
  Lcp lcp_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ipopt_mpcc() {
  return define_adapter<IpoptMpcc, IpoptMpccSettings>(
      {.name = "ipopt_mpcc",
       .summary = "Ipopt on min z'w, w = Mz + q, z >= 0, w >= 0 (complementarity program)",
       .source = "Waechter, Biegler 2006; Luo, Pang, Ralph 1996 for the program",
       .capabilities = kIpoptMpccCapabilities});
}

}  // namespace lcpbench
