// Ipopt on the LCP as a mathematical program with complementarity constraints: the product z'w in the objective, or
// Scholtes's relaxation, a sequence of programs with z_i w_i <= t, t falling to zero.
#include <algorithm>
#include <limits>
#include <optional>

#include "adapters/ipopt/ipopt_common.h"
#include "core/timed_solve.h"

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

struct IpoptScholtesSettings : IpoptSettings {
  static constexpr Capabilities capabilities{.guarantees = "none: the relaxed programs are not convex",
                                             .obeys_time_limit = true};

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

class IpoptMpcc;
class IpoptScholtes;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// z, w >= 0 with w - M z = q: min z'w; or with a t some of them that have z_i w_i <= t. The variables are [z; w], the
/// constraints n equalities, then n products where there is a t. @param lcp  outlives the program
class ComplementarityProgram final : public NonlinearProgram {
 public:
  ComplementarityProgram(const Lcp& lcp, Vector start, std::optional<double> t)
      : lcp_(lcp), n_(static_cast<Ipopt::Index>(lcp.size())), start_(std::move(start)), t_(t) {}

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_entries, Ipopt::Index& hessian_entries,
                    IndexStyleEnum& style) override {
    n = 2 * n_;
    m = t_ ? 2 * n_ : n_;
    jacobian_entries = n_ * n_ + (t_ ? 3 : 1) * n_;
    hessian_entries = n_;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Ipopt::Index n, Ipopt::Number* lower, Ipopt::Number* upper, Ipopt::Index m,
                       Ipopt::Number* constraint_lower, Ipopt::Number* constraint_upper) override {
    std::fill_n(lower, n, 0.0);
    std::fill_n(upper, n, kInfinity);
    for (Ipopt::Index i = 0; i < m; ++i) {
      constraint_lower[i] = i < n_ ? lcp_.q(i) : -kInfinity;
      constraint_upper[i] = i < n_ ? lcp_.q(i) : *t_;
    }
    return true;
  }

  bool get_starting_point(Ipopt::Index n, bool, Ipopt::Number* x, bool, Ipopt::Number*, Ipopt::Number*, Ipopt::Index,
                          bool, Ipopt::Number*) override {
    std::copy_n(start_.data(), n, x);
    return true;
  }

  bool eval_f(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Number& value) override {
    value = t_ ? 0 : Eigen::Map<const Vector>(x, n_).dot(Eigen::Map<const Vector>(x + n_, n_));
    return true;
  }

  bool eval_grad_f(Ipopt::Index n, const Ipopt::Number* x, bool, Ipopt::Number* gradient) override {
    for (Ipopt::Index i = 0; i < n; ++i) gradient[i] = t_ ? 0 : x[(i + n_) % n];
    return true;
  }

  bool eval_g(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Index, Ipopt::Number* values) override {
    const Eigen::Map<const Vector> z(x, n_);
    const Eigen::Map<const Vector> w(x + n_, n_);
    Eigen::Map<Vector>(values, n_) = w - lcp_.M * z;
    if (t_) Eigen::Map<Vector>(values + n_, n_) = z.cwiseProduct(w);
    return true;
  }

  bool eval_jac_g(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Index, Ipopt::Index, Ipopt::Index* rows,
                  Ipopt::Index* columns, Ipopt::Number* values) override {
    Ipopt::Index entry = 0;
    const auto add = [&](Ipopt::Index row, Ipopt::Index column, auto value) {
      if (values == nullptr) {
        rows[entry] = row;
        columns[entry] = column;
      } else {
        values[entry] = value();
      }
      ++entry;
    };
    for (Ipopt::Index i = 0; i < n_; ++i) {
      for (Ipopt::Index j = 0; j < n_; ++j) add(i, j, [&] { return -lcp_.M(i, j); });
      add(i, n_ + i, [] { return 1.0; });
      if (!t_) continue;
      add(n_ + i, i, [&] { return x[n_ + i]; });
      add(n_ + i, n_ + i, [&] { return x[i]; });
    }
    return true;
  }

  bool eval_h(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Number objective_factor, Ipopt::Index,
              const Ipopt::Number* multipliers, bool, Ipopt::Index, Ipopt::Index* rows, Ipopt::Index* columns,
              Ipopt::Number* values) override {
    for (Ipopt::Index i = 0; i < n_; ++i) {
      if (values != nullptr) {
        values[i] = t_ ? multipliers[n_ + i] : objective_factor;
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
  Vector start_;
  std::optional<double> t_;
};

/// z = 0 and the nearest w.
Vector first_point(const Lcp& lcp) {
  Vector point(2 * lcp.size());
  point << Vector::Zero(lcp.size()), lcp.q.cwiseMax(0.0);
  return point;
}

class IpoptMpcc final : public MatrixAdapter<IpoptMpccSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  void call(const SolveRequest& request, Answer& answer) override {
    const Index n = lcp_.size();
    const Ipopt::SmartPtr<NonlinearProgram> program = new ComplementarityProgram(lcp_, first_point(lcp_), std::nullopt);
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

/// Ipopt takes no limit of zero.
constexpr double kShortestTimeLimit_s = 1e-3;

class IpoptScholtes final : public MatrixAdapter<IpoptScholtesSettings> {
 public:
  using MatrixAdapter::MatrixAdapter;

 private:
  void call(const SolveRequest& request, Answer& answer) override {
    const Index n = lcp_.size();
    const double begin_s = wall_clock_s();
    const double tolerance = settings_.residual_tolerance * std::max(1.0, lcp_.q.lpNorm<Eigen::Infinity>());
    Vector point = first_point(lcp_);
    std::int64_t iterations = 0;
    double t = settings_.first_relaxation;  // of the last program
    for (std::int64_t i = 0; i < settings_.programs; ++i) {
      if (i > 0) t *= settings_.reduction;
      answer.counters.iterations = 0;
      const Ipopt::SmartPtr<NonlinearProgram> program = new ComplementarityProgram(lcp_, point, t);
      run_ipopt(program, settings_, std::max(kShortestTimeLimit_s, request.time_limit_s - (wall_clock_s() - begin_s)),
                answer, {.constant_derivatives = false, .mu_init = std::min(0.1, t)});
      if (program->solution().size() == 2 * n) point = program->solution();
      iterations += answer.counters.iterations;
      if (residual(point.head(n)) <= tolerance || answer.claim == Claim::kTimeLimit) break;
    }
    answer.counters.iterations = iterations;
    answer.z = point.head(n);
    const bool solved = residual(answer.z) <= tolerance;  // what Ipopt says is of the last program, not of the LCP
    if (solved) answer.claim = Claim::kSolved;
    if (!solved && answer.claim == Claim::kSolved) answer.claim = Claim::kNumericalFailure;
    answer.detail += ", t = " + format_real(t);
  }

  /// Infinity for a z that is not finite: a maximum need not see NaN.
  double residual(const Vector& z) const {
    const Vector w = lcp_.M * z + lcp_.q;
    if (!z.allFinite() || !w.allFinite()) return std::numeric_limits<double>::infinity();
    return z.cwiseMin(w).lpNorm<Eigen::Infinity>();
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

SolverDefinition lcpbench_solver_ipopt_scholtes() {
  return define_adapter<IpoptScholtes, IpoptScholtesSettings>(
      {.name = "ipopt_scholtes",
       .summary = "Ipopt on a sequence of relaxed complementarity programs, z_i w_i <= t",
       .source = "Scholtes 2001, SIAM J. Optim. 11; Waechter, Biegler 2006"});
}

}  // namespace lcpbench
