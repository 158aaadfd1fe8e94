// Ipopt on the LCP through Scholtes's relaxation: a sequence of programs with z_i w_i <= t, t falling to zero.
#include <algorithm>
#include <limits>

#include "adapters/define_adapter.h"
#include "adapters/ipopt/ipopt_common.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

constexpr Capabilities kCapabilities{.guarantees = "none: the relaxed programs are not convex",
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

/// Find z, w >= 0 with w - M z = q and z_i w_i <= t. The variables are [z; w], the constraints n equalities, then n
/// products.
class RelaxedProgram final : public QuietProgram {
 public:
  RelaxedProgram(const Lcp& lcp, double t, Vector start)
      : lcp_(lcp), n_(static_cast<Ipopt::Index>(lcp.size())), t_(t), start_(std::move(start)) {}

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_entries, Ipopt::Index& hessian_entries,
                    IndexStyleEnum& style) override {
    n = 2 * n_;
    m = 2 * n_;
    jacobian_entries = n_ * n_ + 3 * n_;
    hessian_entries = n_;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Ipopt::Index n, Ipopt::Number* lower, Ipopt::Number* upper, Ipopt::Index,
                       Ipopt::Number* constraint_lower, Ipopt::Number* constraint_upper) override {
    std::fill_n(lower, n, 0.0);
    std::fill_n(upper, n, kInfinity);
    for (Ipopt::Index i = 0; i < n_; ++i) constraint_lower[i] = constraint_upper[i] = lcp_.q(i);
    std::fill_n(constraint_lower + n_, n_, -kInfinity);
    std::fill_n(constraint_upper + n_, n_, t_);
    return true;
  }
  bool get_starting_point(Ipopt::Index n, bool, Ipopt::Number* x, bool, Ipopt::Number*, Ipopt::Number*, Ipopt::Index,
                          bool, Ipopt::Number*) override {
    std::copy_n(start_.data(), n, x);
    return true;
  }
  bool eval_f(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Number& value) override {
    value = 0;
    return true;
  }
  bool eval_grad_f(Ipopt::Index n, const Ipopt::Number*, bool, Ipopt::Number* gradient) override {
    std::fill_n(gradient, n, 0.0);
    return true;
  }
  bool eval_g(Ipopt::Index, const Ipopt::Number* x, bool, Ipopt::Index, Ipopt::Number* values) override {
    const Eigen::Map<const Vector> z(x, n_);
    const Eigen::Map<const Vector> w(x + n_, n_);
    Eigen::Map<Vector>(values, n_) = w - lcp_.M * z;
    Eigen::Map<Vector>(values + n_, n_) = z.cwiseProduct(w);
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
      add(n_ + i, i, [&] { return x[n_ + i]; });
      add(n_ + i, n_ + i, [&] { return x[i]; });
    }
    return true;
  }
  bool eval_h(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Number, Ipopt::Index, const Ipopt::Number* multipliers,
              bool, Ipopt::Index, Ipopt::Index* rows, Ipopt::Index* columns, Ipopt::Number* values) override {
    for (Ipopt::Index i = 0; i < n_; ++i) {
      if (values == nullptr) {
        rows[i] = n_ + i;
        columns[i] = i;
      } else {
        values[i] = multipliers[n_ + i];
      }
    }
    return true;
  }

 private:
  const Lcp& lcp_;
  Ipopt::Index n_;
  double t_;
  Vector start_;
};

/// Ipopt takes no limit of zero.
constexpr double kShortestTimeLimit_s = 1e-3;

class IpoptScholtes final : public Solver {
 public:
  explicit IpoptScholtes(const IpoptScholtesSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override { return kCapabilities; }

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
    Vector point(2 * n);
    point << Vector::Zero(n), lcp_.q.cwiseMax(0.0);
    std::int64_t iterations = 0;
    double t = settings_.first_relaxation;
    for (std::int64_t i = 0; i < settings_.programs; ++i, t *= settings_.reduction) {
      const Ipopt::SmartPtr<QuietProgram> program = new RelaxedProgram(lcp_, t, point);
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
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
