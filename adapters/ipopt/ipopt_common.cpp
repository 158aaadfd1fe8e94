#include "adapters/ipopt/ipopt_common.h"

#include <algorithm>
#include <utility>

namespace lcpbench {

namespace {

class ComplementarityProgram final : public QuietProgram {
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

}  // namespace

Ipopt::SmartPtr<QuietProgram> complementarity_program(const Lcp& lcp, Vector start, std::optional<double> t) {
  return new ComplementarityProgram(lcp, std::move(start), t);
}

Claim ipopt_claim(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level: return Claim::kSolved;
    case Ipopt::Infeasible_Problem_Detected: return Claim::kUnsolvable;
    case Ipopt::Maximum_Iterations_Exceeded: return Claim::kIterationLimit;
    case Ipopt::Maximum_CpuTime_Exceeded: return Claim::kTimeLimit;
    default: return Claim::kNumericalFailure;
  }
}

void run_ipopt(const Ipopt::SmartPtr<QuietProgram>& program, const IpoptSettings& settings, double time_limit_s,
               Answer& answer, const IpoptHints& hints) {
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
  options->SetNumericValue("mu_init", hints.mu_init);
  options->SetStringValue("hessian_constant", hints.constant_derivatives ? "yes" : "no");
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
