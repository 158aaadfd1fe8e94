// Ipopt on the LCP as a mathematical program with complementarity constraints: the product z'w in the objective.
#include <algorithm>

#include "adapters/ipopt/ipopt_common.h"

namespace lcpbench {
namespace {

struct IpoptMpccSettings : IpoptSettings {
  static constexpr Capabilities capabilities{.guarantees = "none: a local minimum with z'w > 0 is no solution",
                                             .obeys_time_limit = true};

  double complementarity_tolerance = 1e-6;

  void visit(auto&& field) {
    IpoptSettings::visit(field);
    field("complementarity_tolerance", complementarity_tolerance, RealRange{.min = 0.0},
          "a local minimum claims to be a solution when z'w <= this times max(1, max|q|)");
  }
};

class IpoptMpcc;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// min z'w with z, w >= 0 and w - M z = q. The variables are [z; w]. @param lcp  outlives the program
class ComplementarityProgram final : public NonlinearProgram {
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
    std::copy_n(lcp_.q.data(), m, constraint_lower);
    std::copy_n(lcp_.q.data(), m, constraint_upper);
    return true;
  }

  /// z = 0 and the nearest w.
  bool get_starting_point(Ipopt::Index, bool, Ipopt::Number* x, bool, Ipopt::Number*, Ipopt::Number*, Ipopt::Index,
                          bool, Ipopt::Number*) override {
    std::fill_n(x, n_, 0.0);
    Eigen::Map<Vector>(x + n_, n_) = lcp_.q.cwiseMax(0.0);
    return true;
  }

  bool eval_f(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Number& value) override {
    value = Eigen::Map<const Vector>(x, n_).dot(Eigen::Map<const Vector>(x + n_, n_));
    return true;
  }

  bool eval_grad_f(Ipopt::Index n, const Ipopt::Number* x, bool, Ipopt::Number* gradient) override {
    for (Ipopt::Index i = 0; i < n; ++i) gradient[i] = x[(i + n_) % n];
    return true;
  }

  bool eval_g(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Index, Ipopt::Number* values) override {
    Eigen::Map<Vector>(values, n_) = Eigen::Map<const Vector>(x + n_, n_) - lcp_.M * Eigen::Map<const Vector>(x, n_);
    return true;
  }

  bool eval_jac_g(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index, Ipopt::Index* rows,
                  Ipopt::Index* columns, Ipopt::Number* values) override {
    Ipopt::Index entry = 0;
    const auto add = [&](Ipopt::Index row, Ipopt::Index column, double value) {
      if (values == nullptr) {
        rows[entry] = row;
        columns[entry] = column;
      } else {
        values[entry] = value;
      }
      ++entry;
    };
    for (Ipopt::Index i = 0; i < n_; ++i) {
      for (Ipopt::Index j = 0; j < n_; ++j) add(i, j, -lcp_.M(i, j));
      add(i, n_ + i, 1.0);
    }
    return true;
  }

  bool eval_h(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Number objective_factor, Ipopt::Index,
              const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index* rows, Ipopt::Index* columns,
              Ipopt::Number* values) override {
    for (Ipopt::Index i = 0; i < n_; ++i) {
      if (values != nullptr) {
        values[i] = objective_factor;
        continue;
      }
      rows[i] = n_ + i;
      columns[i] = i;
    }
    return true;
  }

 private:
  const Lcp& lcp_;
  Ipopt::Index n_;
};

class IpoptMpcc final : public MatrixAdapter<IpoptMpccSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  void call(const SolveRequest& request, Answer& answer) override {
    const Index n = lcp_.size();
    const Ipopt::SmartPtr<NonlinearProgram> program = new ComplementarityProgram(lcp_);
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
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_ipopt_mpcc() {
  return define_adapter<IpoptMpcc, IpoptMpccSettings>(
      {.name = "ipopt_mpcc",
       .summary = "Ipopt on min z'w, w = Mz + q, z >= 0, w >= 0 (complementarity program)",
       .source = "Waechter, Biegler 2006; Luo, Pang, Ralph 1996 for the program"});
}

}  // namespace lcpbench
