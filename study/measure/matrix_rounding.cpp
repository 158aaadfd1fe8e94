// How the share solved depends on what rounding makes of M: one CSV row for each set and way of forming M. Not a test;
// results/adapters/README.md has its commands.
//
//   matrix_rounding TRIALS SEED FORM[,FORM...]|all SOLVER SET...
//
// Frictionless sets only. M = N'G*N is symmetric and positive semidefinite; in double precision it is neither. The same
// problems are solved with M
//   given       as every adapter gets it: N'(G* N) with the inverse of G, all of it
//   lower       its lower triangle, mirrored
//   upper       its upper triangle, mirrored
//   mean        (M + M')/2
//   gram        V'V, where V = S^(-1/2) U'N and G = U S U' (eigenvalues at most ngc eps times the largest: left out)
//   scaled      lower, times the power of two that brings its largest entry to 1/2 to 1; z is scaled back
//   nearest     each entry the double nearest to the true one (113 bits, then one rounding), symmetric
// and counted as solved by the verdict (of the raw data, whichever M the solver was given), and by
// max|min(z, Mz + q)| <= 1e-6 max(1, max|q|) of the M given, in double; each once whatever the solver says of its
// answer and once for the answers that it says are solutions. `indefinite` counts the M with an eigenvalue below -n eps
// max|eigenvalue| (of (M + M')/2).

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "generators/sets.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/quad_lcp.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kNatural = 1e-6;

Matrix mirrored_lower(const Matrix& M) { return M.selfadjointView<Eigen::Lower>(); }
Matrix mirrored_upper(const Matrix& M) { return M.selfadjointView<Eigen::Upper>(); }

Matrix gram(const ContactProblem& problem) {
  const Matrix G = dense_inertia(problem.inertia);
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(G);
  const Vector& values = eigen.eigenvalues();
  const double cut = static_cast<double>(G.rows()) * kEps * values.cwiseAbs().maxCoeff();
  Vector scale(values.size());
  for (Index i = 0; i < values.size(); ++i) scale(i) = values(i) > cut ? 1.0 / std::sqrt(values(i)) : 0.0;
  const Matrix V = scale.asDiagonal() * (eigen.eigenvectors().transpose() * to_dense(problem.N));
  return mirrored_lower(V.transpose() * V);
}

Matrix nearest(const ContactProblem& problem) {
  ContactProblem at_rest = problem;
  at_rest.v.setZero();  // then w = M z
  const QuadInertia inertia(at_rest.inertia);
  ContactQuadLcp lcp(at_rest, inertia);
  const auto n = static_cast<Index>(lcp.size());
  Matrix M(n, n);
  for (Index j = 0; j < n; ++j) {
    QuadVector unit(lcp.size(), Quad(0));
    unit[static_cast<std::size_t>(j)] = 1;
    const QuadVector u = lcp.response(unit);
    for (Index i = j; i < n; ++i) M(i, j) = static_cast<double>(lcp.row(static_cast<std::size_t>(i), unit, u));
  }
  return mirrored_lower(M);
}

/// The power of two that brings the largest entry to 1/2 to 1.
double unit_scale(const Matrix& M) { return std::ldexp(1.0, -std::ilogb(M.cwiseAbs().maxCoeff()) - 1); }

struct Form {
  const char* name;
  std::function<Problem(const Problem&)> apply;
  std::function<double(const Problem&)> z_scale = [](const Problem&) { return 1.0; };  ///< back to the problem's units
};

Problem with_matrix(const Problem& problem, Matrix M) {
  Lcp lcp = problem.lcp();
  lcp.M = std::move(M);
  return Problem(problem.name(), std::move(lcp));
}

std::vector<Form> forms() {
  return {{"given", [](const Problem& p) { return p; }},
          {"lower", [](const Problem& p) { return with_matrix(p, mirrored_lower(p.lcp().M)); }},
          {"upper", [](const Problem& p) { return with_matrix(p, mirrored_upper(p.lcp().M)); }},
          {"mean", [](const Problem& p) { return with_matrix(p, 0.5 * (p.lcp().M + p.lcp().M.transpose())); }},
          {"gram", [](const Problem& p) { return with_matrix(p, gram(*p.contact())); }},
          {"scaled", [](const Problem& p) { return with_matrix(p, unit_scale(p.lcp().M) * mirrored_lower(p.lcp().M)); },
           [](const Problem& p) { return unit_scale(p.lcp().M); }},
          {"nearest", [](const Problem& p) { return with_matrix(p, nearest(*p.contact())); }}};
}

bool indefinite(const Matrix& M) {
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(0.5 * (M + M.transpose()), Eigen::EigenvaluesOnly);
  const Vector& values = eigen.eigenvalues();
  return values.minCoeff() < -static_cast<double>(M.rows()) * kEps * values.cwiseAbs().maxCoeff();
}

bool naturally_solved(const Lcp& lcp, const Vector& z) {
  if (z.size() != lcp.size() || !z.allFinite()) return false;
  const Vector w = lcp.M * z + lcp.q;
  return z.cwiseMin(w).cwiseAbs().maxCoeff() <= kNatural * std::max(1.0, lcp.q.cwiseAbs().maxCoeff());
}

struct Counts {
  int claimed = 0;
  int solved = 0;
  int claimed_and_solved = 0;
  int natural = 0;
  int claimed_and_natural = 0;
  int indefinite = 0;
};

Counts count(TimedSolver& solver, const Form& form, const ProblemSet& set, std::int64_t trials, std::uint64_t seed) {
  Counts counts;
  for (std::int64_t trial = 0; trial < trials; ++trial) {
    const Problem problem = set.generate(seed, trial);
    const Problem given = form.apply(problem);
    TimedAnswer result;
    solver.run(given, {}, result);
    const bool claimed = result.answer.claim == Claim::kSolved;
    const bool natural = naturally_solved(given.lcp(), result.answer.z);
    result.answer.z *= form.z_scale(problem);
    const bool solved = Evaluator(problem).errors(result.answer).solved;
    counts.claimed += claimed;
    counts.solved += solved;
    counts.claimed_and_solved += claimed && solved;
    counts.natural += natural;
    counts.claimed_and_natural += claimed && natural;
    counts.indefinite += indefinite(given.lcp().M);
  }
  return counts;
}

bool wanted(const std::string& names, const std::string& form) {
  return names == "all" || ("," + names + ",").find("," + form + ",") != std::string::npos;
}

void measure(const std::string& names, const std::string& solver, const std::string& set, std::int64_t trials,
             std::uint64_t seed) {
  const auto opened = open_solver(parse_spec(solver));
  const auto problems = open_set(set);
  for (const Form& form : forms()) {
    if (!wanted(names, form.name)) continue;
    const Counts c = count(*opened, form, *problems, trials, seed);
    std::printf("\"%s\",\"%s\",%s,%lld,%d,%d,%d,%d,%d,%d\n", set.c_str(), solver.c_str(), form.name,
                static_cast<long long>(trials), c.indefinite, c.claimed, c.solved, c.claimed_and_solved, c.natural,
                c.claimed_and_natural);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 6) {
    std::fprintf(stderr, "matrix_rounding TRIALS SEED FORM[,FORM...]|all SOLVER SET...\n");
    return 2;
  }
  std::printf(
      "set,solver,matrix,trials,indefinite,claimed,solved,claimed_and_solved,natural_1e-6,claimed_and_natural_1e-6\n");
  try {
    for (int i = 5; i < argc; ++i) {
      lcpbench::measure(argv[3], argv[4], argv[i], std::atoll(argv[1]), std::strtoull(argv[2], nullptr, 10));
    }
  } catch (const lcpbench::InputError& error) {
    std::fprintf(stderr, "matrix_rounding: %s\n", error.what());
    return 2;
  }
}
