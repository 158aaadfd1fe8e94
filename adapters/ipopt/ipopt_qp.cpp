// Ipopt on the convex quadratic program whose optimality conditions are the LCP of a symmetric positive semidefinite M.
// If this LCP has no solution, the program is unbounded: Ipopt then mostly ends in a numerical failure or at a limit.
#include "adapters/ipopt/ipopt_common.h"

namespace lcpbench {
namespace {

struct IpoptQpSettings : IpoptSettings {
  static constexpr Capabilities capabilities{.frictionless_only = true,
                                             .guarantees = "symmetric positive semidefinite M (a convex program)",
                                             .obeys_time_limit = true};
};

class IpoptQp;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// min 1/2 z'Mz + q'z subject to z >= 0. The multipliers of the bounds are w = M z + q.
class BoundQp final : public NonlinearProgram {
 public:
  explicit BoundQp(const Lcp& lcp) : lcp_(lcp) {}

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_entries, Ipopt::Index& hessian_entries,
                    IndexStyleEnum& style) override {
    n = static_cast<Ipopt::Index>(lcp_.size());
    m = 0;
    jacobian_entries = 0;
    hessian_entries = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Ipopt::Index n, Ipopt::Number* lower, Ipopt::Number* upper, Ipopt::Index, Ipopt::Number*,
                       Ipopt::Number*) override {
    std::fill_n(lower, n, 0.0);
    std::fill_n(upper, n, kInfinity);
    return true;
  }
  bool get_starting_point(Ipopt::Index n, bool, Ipopt::Number* z, bool, Ipopt::Number*, Ipopt::Number*, Ipopt::Index,
                          bool, Ipopt::Number*) override {
    std::fill_n(z, n, 0.0);
    return true;
  }
  bool eval_f(Ipopt::Index n, const Ipopt::Number* z, bool, Ipopt::Number& value) override {
    const Eigen::Map<const Vector> point(z, n);
    value = 0.5 * point.dot(lcp_.M * point) + lcp_.q.dot(point);
    return true;
  }
  bool eval_grad_f(Ipopt::Index n, const Ipopt::Number* z, bool, Ipopt::Number* gradient) override {
    Eigen::Map<Vector>(gradient, n) = lcp_.M * Eigen::Map<const Vector>(z, n) + lcp_.q;
    return true;
  }
  bool eval_g(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Number*) override { return true; }
  bool eval_jac_g(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index, Ipopt::Index*, Ipopt::Index*,
                  Ipopt::Number*) override {
    return true;
  }
  bool eval_h(Ipopt::Index n, const Ipopt::Number*, bool, Ipopt::Number objective_factor, Ipopt::Index,
              const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index* rows, Ipopt::Index* columns,
              Ipopt::Number* values) override {
    Ipopt::Index entry = 0;
    for (Ipopt::Index i = 0; i < n; ++i) {
      for (Ipopt::Index j = 0; j <= i; ++j, ++entry) {
        if (values == nullptr) {
          rows[entry] = i;
          columns[entry] = j;
        } else {
          values[entry] = objective_factor * lcp_.M(i, j);
        }
      }
    }
    return true;
  }

 private:
  const Lcp& lcp_;
};

class IpoptQp final : public MatrixAdapter<IpoptQpSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  void call(const SolveRequest& request, Answer& answer) override {
    const Ipopt::SmartPtr<NonlinearProgram> program = new BoundQp(lcp_);
    run_ipopt(program, settings_, request.time_limit_s, answer);
    if (program->solution().size() == lcp_.size()) answer.z = program->solution();
  }
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ipopt_qp() {
  return define_adapter<IpoptQp, IpoptQpSettings>(
      {.name = "ipopt_qp",
       .summary = "Ipopt on min 1/2 z'Mz + q'z, z >= 0 (frictionless problems)",
       .source = "Waechter, Biegler 2006, Math. Program. 106"});
}

}  // namespace lcpbench
