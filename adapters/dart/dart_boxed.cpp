// DART's boxed solvers: DantzigBoxedLcpSolver, the first of its constraint solver, and PgsBoxedLcpSolver, the second.
//
// DantzigBoxedLcpSolver::solve() is one call of dSolveLCP in DART's copy of ODE's code.
#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <algorithm>
#include <limits>
#include <vector>

#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>

#include "adapters/round_cone.h"
#endif

namespace lcpbench {
namespace {

struct DartDantzigSettings {
  static constexpr Capabilities capabilities{.needs = Needs::kFactored,
                                             .guarantees = "symmetric positive definite M (no friction)"};

  bool early_termination = true;

  void visit(auto&& field) {
    field("early_termination", early_termination,
          "stop and report a failure at a pivot that is not positive; without it DART never reports one");
  }
};

struct DartPgsSettings {
  static constexpr Capabilities capabilities{
      .needs = Needs::kFactored,
      .guarantees = "converges for symmetric positive definite M (no friction); with friction none",
      .warm_start = true};

  std::int64_t max_iterations = 30;
  double first_tolerance = 1e-6;
  double relative_tolerance = 1e-3;
  double smallest_diagonal = 1e-9;

  void visit(auto&& field) {
    field("max_iterations", max_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "sweeps at most (mMaxIteration); 30 is DART's default");
    field("first_tolerance", first_tolerance, RealRange{.min = 0.0},
          "stop after the first sweep if no unknown changed by more (mDeltaXThreshold); 1e-6 is DART's default");
    field(
        "relative_tolerance", relative_tolerance, RealRange{.min = 0.0},
        "stop when no unknown changed by more, relative to itself (mRelativeDeltaXTolerance); 1e-3 is DART's default");
    field("smallest_diagonal", smallest_diagonal, RealRange{.min = 0.0},
          "rows of a smaller diagonal are left out (mEpsilonForDivision); 1e-9 is DART's default");
  }
};

class DartDantzig;
class DartPgs;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// DART's rows are padded to multiples of four numbers, but for a single one (dPAD of ODE).
Index stride(Index n) { return n > 1 ? ((n - 1) | 3) + 1 : n; }

/// Collects the boxed rows of a problem.
struct RowBuilder {
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> limit;  ///< friction: of |x| / f_N
  std::vector<int> normal_row;

  Index add(double bound, int normal) {
    limit.push_back(bound);
    normal_row.push_back(normal);
    return static_cast<Index>(limit.size()) - 1;
  }
  void add_friction(Index first_direction, int edges, double mu, int normal) {
    if (edges == 2) {
      entries.emplace_back(first_direction, add(mu, normal), 1.0);
      return;
    }
    const Index sum = add(mu / 2, normal);
    const Index difference = add(mu / 2, normal);
    entries.emplace_back(first_direction, sum, 1.0);
    entries.emplace_back(first_direction + 1, sum, 1.0);
    entries.emplace_back(first_direction, difference, 1.0);
    entries.emplace_back(first_direction + 1, difference, -1.0);
  }
};

/// Contacts in the boxed form of DART: A x = b + w with bounds on x, where a friction row's bounds are proportional to
/// the unknown of its normal row.
///
/// A pyramid of 4 edges is exactly the square |a| <= mu f_N / 2, |c| <= mu f_N / 2 on the rows t1 + t2 and t1 - t2,
/// and one of 2 edges is |a| <= mu f_N on the row t1. A pyramid of more edges is no box.
class BoxedContacts {
 public:
  /// @returns why the form does not hold the problem, or "".
  std::string load(const ContactProblem& contact) {
    layout_ = contact_layout(contact);
    RowBuilder rows;
    for (Index i = 0; i < layout_.nc; ++i) {
      rows.entries.emplace_back(i, rows.add(std::numeric_limits<double>::infinity(), -1), 1.0);
    }
    for (const Index c : layout_.cone_contact) {
      const auto i = static_cast<std::size_t>(c);
      if (contact.edges[i] > 4) return "a pyramid of more than 4 edges is no box";
      rows.add_friction(layout_.friction_offset() + layout_.friction_begin[i], contact.edges[i], contact.mu(c),
                        static_cast<int>(c));
    }
    lcp_ = form_lcp(contact);
    const auto m = static_cast<Index>(rows.limit.size());
    rows_.resize(lcp_.size(), m);
    rows_.setFromTriplets(rows.entries.begin(), rows.entries.end());
    given_.A.setZero(stride(m), m);
    given_.A.topRows(m) = rows_.transpose() * (lcp_.M * rows_).eval();
    given_.b = -(rows_.transpose() * lcp_.q);
    require_finite(given_.A, given_.b);
    given_.upper = Eigen::Map<const Vector>(rows.limit.data(), m);
    given_.lower = (given_.upper.array() < std::numeric_limits<double>::infinity()).select(-given_.upper, 0.0);
    given_.normal_row = std::move(rows.normal_row);
    return {};
  }

  /// Writes z: opposite directions carry the two signs of a friction impulse, lambda is the largest slip along a
  /// direction. @param start  a z, or null: x starts at zero. @returns what the library returned.
  bool solve(dart::constraint::BoxedLcpSolver& solver, bool early_termination, const Vector* start, Vector& z) {
    constexpr int kUnbounded = 0;
    x_.setZero(given_.b.size());
    if (start != nullptr) start_at(*start);
    destroyed_ = given_;
    const bool solved = solver.solve(static_cast<int>(x_.size()), destroyed_.A.data(), x_.data(), destroyed_.b.data(),
                                     kUnbounded, destroyed_.lower.data(), destroyed_.upper.data(),
                                     destroyed_.normal_row.data(), early_termination);
    z = rows_ * x_;
    if (frictional()) split_friction(z);
    return solved;
  }

  bool frictional() const { return layout_.cones > 0; }

 private:
  void start_at(const Vector& z) {
    Vector merged = z;
    for_each_pyramid([&](Index begin, Index half) {
      merged.segment(begin, half) -= merged.segment(begin + half, half);
    });
    for (Index k = 0; k < x_.size(); ++k) x_(k) = rows_.col(k).dot(merged) / rows_.col(k).squaredNorm();
  }

  void split_friction(Vector& z) const {
    for_each_pyramid([&](Index begin, Index half) {
      for (Index k = begin; k < begin + half; ++k) {
        z(k + half) = std::max(-z(k), 0.0);
        z(k) = std::max(z(k), 0.0);
      }
    });
    complete_slip_bounds(lcp_, layout_, z);
  }

  /// visit(where a contact's directions begin in z, half their number)
  template <class Visit>
  void for_each_pyramid(Visit&& visit) const {
    for (const Index c : layout_.cone_contact) {
      const Index begin = layout_.friction_begin[static_cast<std::size_t>(c)];
      const Index end = layout_.friction_begin[static_cast<std::size_t>(c) + 1];
      visit(layout_.friction_offset() + begin, (end - begin) / 2);
    }
  }

  Lcp lcp_;
  ContactLayout layout_;
  SparseMatrix rows_;  ///< n x m: what each of the m boxed unknowns adds to z, opposite directions merged
  struct Boxed {
    Matrix A;  ///< in DART's stride
    Vector b, lower, upper;
    std::vector<int> normal_row;  ///< m: of a friction row, else -1
  };
  Boxed given_;
  Boxed destroyed_;  ///< what the library works in
  Vector x_;
};

class DartDantzig final : public Adapter<DartDantzigSettings> {
 public:
  using Adapter::Adapter;

 private:
  std::string take(const Problem& problem) override { return contacts_.load(*problem.contact()); }

  void call(const SolveRequest&, Answer& answer) override {
    const bool solved = contacts_.solve(solver_, settings_.early_termination, nullptr, answer.z);
    answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    if (!solved) {
      answer.detail = "solve returned false";
    } else if (contacts_.frictional()) {
      answer.detail = "another problem: friction limited by the normal impulses of a solve without friction";
    }
  }

  BoxedContacts contacts_;
  dart::constraint::DantzigBoxedLcpSolver solver_;
};

class DartPgs final : public Adapter<DartPgsSettings> {
 public:
  explicit DartPgs(const DartPgsSettings& settings) : Adapter(settings) {
    solver_.setOption({static_cast<int>(settings.max_iterations), settings.first_tolerance, settings.relative_tolerance,
                       settings.smallest_diagonal});
  }

 private:
  std::string take(const Problem& problem) override { return contacts_.load(*problem.contact()); }

  void call(const SolveRequest& request, Answer& answer) override {
    constexpr bool kIgnored = false;  // the method has no early termination
    const bool solved = contacts_.solve(solver_, kIgnored, request.start, answer.z);
    answer.claim = solved ? Claim::kSolved : Claim::kIterationLimit;
  }

  BoxedContacts contacts_;
  dart::constraint::PgsBoxedLcpSolver solver_;
};

#endif

}  // namespace

SolverDefinition lcpbench_solver_dart_dantzig() {
  return define_adapter<DartDantzig, DartDantzigSettings>(
      {.name = "dart_dantzig",
       .summary = "DART's DantzigBoxedLcpSolver: ODE's principal pivoting, with DART's friction rows",
       .source =
           "DART, dart/constraint/DantzigBoxedLcpSolver, which calls ODE's dSolveLCP; after Baraff, SIGGRAPH 1994"});
}

SolverDefinition lcpbench_solver_dart_pgs() {
  return define_adapter<DartPgs, DartPgsSettings>(
      {.name = "dart_pgs",
       .summary = "DART's PgsBoxedLcpSolver: projected Gauss-Seidel, with DART's friction rows",
       .source = "DART, dart/constraint/PgsBoxedLcpSolver"});
}

}  // namespace lcpbench
