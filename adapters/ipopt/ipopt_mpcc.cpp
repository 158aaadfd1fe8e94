// Ipopt on the LCP as a mathematical program with complementarity constraints, the product z'w in the objective.
#include "adapters/define_adapter.h"
#include "adapters/ipopt/ipopt_common.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.guarantees = "none: a local minimum with z'w > 0 is no solution",
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

/// min z'w subject to w - M z = q, z >= 0, w >= 0; the variables are [z; w].
class ComplementarityProgram final : public QuietProgram {
 public:
  explicit ComplementarityProgram(const Lcp& lcp) : lcp_(lcp), n_(static_cast<Ipopt::Index>(lcp.size())) {}

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_entries, Ipopt::Index& hessian_entries,
                    IndexStyleEnum& style) override {
    n = 2 * n_;
    m = n_;
    jacobian_entries = n_ * n_ + n_;
    hessian_entries = n_;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Ipopt::Index n, Ipopt::Number* lower, Ipopt::Number* upper, Ipopt::Index m,
                       Ipopt::Number* constraint_lower, Ipopt::Number* constraint_upper) override {
    std::fill_n(lower, n, 0.0);
    std::fill_n(upper, n, kInfinity);
    for (Ipopt::Index i = 0; i < m; ++i) constraint_lower[i] = constraint_upper[i] = lcp_.q(i);
    return true;
  }
  bool get_starting_point(Ipopt::Index, bool, Ipopt::Number* x, bool, Ipopt::Number*, Ipopt::Number*, Ipopt::Index,
                          bool, Ipopt::Number*) override {
    std::fill_n(x, n_, 0.0);
    for (Ipopt::Index i = 0; i < n_; ++i) x[n_ + i] = std::max(lcp_.q(i), 0.0);
    return true;
  }
  bool eval_f(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Number& value) override {
    value = Eigen::Map<const Vector>(x, n_).dot(Eigen::Map<const Vector>(x + n_, n_));
    return true;
  }
  bool eval_grad_f(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Number* gradient) override {
    std::copy_n(x + n_, n_, gradient);
    std::copy_n(x, n_, gradient + n_);
    return true;
  }
  bool eval_g(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Index, Ipopt::Number* values) override {
    Eigen::Map<Vector>(values, n_) = Eigen::Map<const Vector>(x + n_, n_) - lcp_.M * Eigen::Map<const Vector>(x, n_);
    return true;
  }
  bool eval_jac_g(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index, Ipopt::Index* rows,
                  Ipopt::Index* columns, Ipopt::Number* values) override {
    Ipopt::Index entry = 0;
    for (Ipopt::Index i = 0; i < n_; ++i) {
      for (Ipopt::Index j = 0; j <= n_; ++j, ++entry) {
        if (values == nullptr) {
          rows[entry] = i;
          columns[entry] = j < n_ ? j : n_ + i;
        } else {
          values[entry] = j < n_ ? -lcp_.M(i, j) : 1.0;
        }
      }
    }
    return true;
  }
  bool eval_h(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Number objective_factor, Ipopt::Index,
              const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index* rows, Ipopt::Index* columns,
              Ipopt::Number* values) override {
    for (Ipopt::Index i = 0; i < n_; ++i) {
      if (values == nullptr) {
        rows[i] = n_ + i;
        columns[i] = i;
      } else {
        values[i] = objective_factor;
      }
    }
    return true;
  }

 private:
  const Lcp& lcp_;
  Ipopt::Index n_;
};

class IpoptMpcc final : public Solver {
 public:
  explicit IpoptMpcc(const IpoptMpccSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem& problem) override { lcp_ = make_lcp(problem); }

  void on_solve(const SolveRequest& request, Answer& answer) override {
    const Index n = lcp_.size();
    if (n == 0) {
      answer.claim = Claim::kSolved;
      return;
    }
    const Ipopt::SmartPtr<QuietProgram> program = new ComplementarityProgram(lcp_);
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
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
