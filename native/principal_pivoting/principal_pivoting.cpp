#include "native/principal_pivoting/principal_tableau.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/registry.h"
#include "core/settings.h"
#include "core/solver.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"

namespace lcpbench {
namespace {

constexpr Capabilities kMurtyCapabilities{.guarantees = "P-matrices", .obeys_time_limit = true, .allocation_free = true};

constexpr Capabilities kCapabilities{.guarantees = "positive semidefinite M and P-matrices, barring degenerate cycles",
                                     .obeys_time_limit = true,
                                     .allocation_free = true};

constexpr Index kNone = -1;

/// Relative error of M and q: what errors of this size could make 0 counts as 0. M of contacts is a rounded product.
constexpr double kDataError = 1e-14;

/// The settings of every method of principal pivots.
struct PrincipalSettings {
  std::int64_t max_pivots = 0;

  void visit(auto&& field) {
    field("max_pivots", max_pivots, IntegerRange{.min = 0}, "0 stands for max(1000, n^2), the paper's limit");
  }
};

/// A method that exchanges z_i and w_i in a tableau until no basic variable is negative.
class PrincipalSolver : public Solver {
 protected:
  enum class End { kNonnegative, kUnblocked, kNoPivot, kSingularBasis, kPivotLimit, kTimeLimit };

  /// @param no_pivot  static text: what the answer says at End::kNoPivot
  PrincipalSolver(const PrincipalSettings& settings, const char* no_pivot)
      : settings_(settings), no_pivot_(no_pivot) {}

  /// Ends with kUnblocked only after it wrote farkas_. Must not allocate.
  virtual End run(double deadline_s, Counters& counters) = 0;

  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) final;

  bool rebuild_tableau(Counters& counters) {
    ++counters.factorizations;
    return tableau_.rebuild();
  }

  /// Whether the diagonal entry of column k stays positive under relative errors of the data of kDataError: in the
  /// tableau, and computed anew from the data (PrincipalTableau::gains). Writes the error bounds of the column. O(n^2).
  bool has_pivot(Index k, Vector& column_errors) {
    tableau_.column_errors(k, kDataError, column_errors);
    return tableau_.matrix()(k, k) > column_errors(k) && tableau_.gains(k, kDataError);
  }

  PrincipalTableau tableau_;
  std::int64_t pivot_limit_ = 0;
  Vector bounds_;  // n: errors of the constants; murty also writes those of a column there
  Vector farkas_;  // n

 private:
  PrincipalSettings settings_;
  const char* no_pivot_;
  AnswerTest test_;
};

void PrincipalSolver::on_load(const Problem& problem) {
  tableau_.load(make_lcp(problem));
  test_.load(problem);
  const Index n = tableau_.size();
  bounds_.resize(n);
  farkas_.resize(n);
  pivot_limit_ = settings_.max_pivots > 0 ? settings_.max_pivots : std::max<std::int64_t>(1000, n * n);
}

void PrincipalSolver::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = -1, .pivots = 0, .factorizations = 0};
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  const End end = run(deadline_s, answer.counters);
  if (end != End::kUnblocked) tableau_.solution(answer.z);
  switch (end) {
    case End::kNonnegative:
      answer.claim = Claim::kSolved;
      test_.settle(answer, deadline_s);
      return;
    case End::kUnblocked: test_.settle_ray(answer, deadline_s, &farkas_); return;
    case End::kNoPivot: answer.detail = no_pivot_; return;
    case End::kSingularBasis: answer.detail = "the basis is singular to working precision"; return;
    case End::kPivotLimit: answer.claim = Claim::kIterationLimit; return;
    case End::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
  }
}

/// Murty's least-index Bard-type scheme: exchange z_i and w_i of the smallest i whose basic variable is negative.
///
/// Finite for P-matrices, whatever q, in at most 2^n - 1 pivots. Elsewhere it may end at a pivot that is not positive,
/// or cycle until the limit; it never proves that there is no solution. "Negative" means beyond what errors of the data
/// explain. O(n^2) per pivot. [Murty 1974; Cottle, Pang, Stone 1992, section 4.2]
class Murty final : public PrincipalSolver {
 public:
  explicit Murty(const PrincipalSettings& settings)
      : PrincipalSolver(settings, "no positive pivot: M is no P-matrix to working precision") {}
  const Capabilities& capabilities() const override { return kMurtyCapabilities; }

 private:
  End run(double deadline_s, Counters& counters) override;
  Index first_negative();
};

/// The smallest i whose basic variable is negative or NaN; -1: none. Writes the error bounds of the constants. O(n^2)
Index Murty::first_negative() {
  const Index n = tableau_.size();
  tableau_.constant_errors(kDataError, bounds_);
  for (Index i = 0; i < n; ++i) {
    if (!(tableau_.constants()(i) >= -bounds_(i))) return i;
  }
  return -1;
}

Murty::End Murty::run(double deadline_s, Counters& counters) {
  const Index n = tableau_.size();
  tableau_.reset();
  for (;;) {
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    const Index i = first_negative();
    const bool can_go_on = i >= 0 && has_pivot(i, bounds_);
    // An end other than a limit counts only in a tableau without rounding errors of earlier pivots. Rebuilding it after
    // more than n pivots costs O(n^2) for each of them.
    if (tableau_.pivots_since_rebuild() > (can_go_on ? n : 0)) {
      if (!rebuild_tableau(counters)) return End::kSingularBasis;
      continue;
    }
    if (i < 0) return End::kNonnegative;
    if (!can_go_on) return End::kNoPivot;
    if (counters.pivots >= pivot_limit_) return End::kPivotLimit;
    tableau_.pivot(i);
    ++counters.pivots;
  }
}

/// The symmetric principal pivoting method of Dantzig and Cottle.
///
/// The most negative w_r is distinguished and its complement (or, once it is nonbasic, w_r itself) raised until w_r is
/// 0. A basic variable that reaches its bound first is exchanged with its complement, or, where its diagonal entry is
/// zero, together with the pair r. The bound is 0, but for w_i that are negative still: those must not fall below a
/// fixed value under all of q. Solves or proves infeasible every LCP with positive semidefinite M, symmetric or not,
/// and every one with a P-matrix, barring degenerate cycles; ties in the ratio test go to the larger pivot, which is no
/// anticycling rule. Other M are tried: the claims are checked on the data, so they hold there too.
///
/// A raise that nothing blocks gives u = e_r - (row r of the tableau over the nonbasic w) with u >= 0, M'u <= 0 and
/// q'u < 0 to within rounding. kUnsolvable is claimed only where AnswerTest proves it, for bare LCPs exactly. Else the
/// claim is kNumericalFailure, with `detail` "ray", or "no usable pivot" where u misses these conditions. O(n^2) per
/// pivot. [Dantzig, Cottle 1967; Cottle, Pang, Stone 1992, section 4.3]
class PrincipalPivoting final : public PrincipalSolver {
 public:
  explicit PrincipalPivoting(const PrincipalSettings& settings)
      : PrincipalSolver(settings, "no usable pivot: M is not positive semidefinite to working precision") {}
  const Capabilities& capabilities() const override { return kCapabilities; }

 protected:
  void on_load(const Problem& problem) override;

 private:
  struct Block {
    Index pair = kNone;  ///< kNone: nothing blocks
    double step = 0;     ///< of the driving variable, >= 0
  };

  void start();
  End run(double deadline_s, Counters& counters) override;
  End make_nonnegative(Index r, double deadline_s, Counters& counters);
  Index next_distinguished() const;
  double value_of_w(Index i) const;
  double lower_bound(Index i) const;
  void refresh_values(Index r);
  bool rebuild(Index r, Counters& counters);
  Block block_upwards(Index r, bool has_pivot) const;
  Block block_downwards(Index r) const;
  Block first_to_fall(Index r, double direction, Block first) const;
  bool vanishes(Index r) const { return !tableau_.z_is_basic(r) && basic_(r) >= -bounds_(r); }
  void finish(Index r, Counters& counters);
  bool exchange_blocking(Index k, Index r, Counters& counters);
  bool find_farkas_vector(Index r);

  Vector nonbasic_;              // n: values of the nonbasic variables
  Vector basic_;                 // n: values of the basic ones
  std::vector<char> unsettled_;  // n: w_i was negative from the start on and is bounded by floor_, not by 0
  double floor_ = 0;
  Vector column_bounds_;  // n: errors of the column last looked at
};

void PrincipalPivoting::on_load(const Problem& problem) {
  PrincipalSolver::on_load(problem);
  const Index n = tableau_.size();
  for (Vector* vector : {&nonbasic_, &basic_, &column_bounds_}) vector->resize(n);
  unsettled_.resize(static_cast<std::size_t>(n));
}

void PrincipalPivoting::start() {
  tableau_.reset();
  nonbasic_.setZero();
  bounds_.setZero();  // the constants are the data
  basic_ = tableau_.lcp().q;
  for (Index i = 0; i < tableau_.size(); ++i) unsettled_[static_cast<std::size_t>(i)] = basic_(i) < 0;
  floor_ = -2 * tableau_.largest_q();  // any value below all of q
}

double PrincipalPivoting::value_of_w(Index i) const { return tableau_.z_is_basic(i) ? nonbasic_(i) : basic_(i); }

/// Of the basic variable of pair i.
double PrincipalPivoting::lower_bound(Index i) const {
  return !tableau_.z_is_basic(i) && unsettled_[static_cast<std::size_t>(i)] ? floor_ : 0.0;
}

Index PrincipalPivoting::next_distinguished() const {
  Index next = kNone;
  for (Index i = 0; i < tableau_.size(); ++i) {
    if (!unsettled_[static_cast<std::size_t>(i)]) continue;
    if (next < 0 || value_of_w(i) < value_of_w(next)) next = i;
  }
  return next;
}

/// The w_i that came to 0 while another was driven are settled. Not w_r itself: as long as its complement is off 0 it
/// has to be exchanged, also where its own value already vanishes.
void PrincipalPivoting::refresh_values(Index r) {
  basic_ = tableau_.constants();
  basic_.noalias() += tableau_.matrix() * nonbasic_;
  tableau_.constant_errors(kDataError, bounds_);
  for (Index i = 0; i < tableau_.size(); ++i) {
    if (i != r && !tableau_.z_is_basic(i) && basic_(i) >= -bounds_(i)) unsettled_[static_cast<std::size_t>(i)] = false;
  }
}

bool PrincipalPivoting::rebuild(Index r, Counters& counters) {
  if (!rebuild_tableau(counters)) return false;
  refresh_values(r);
  return basic_.allFinite();
}

/// The first basic variable to reach its bound when the nonbasic one of pair r moves in `direction`, if it comes before
/// `first`. Ties go to the larger entry, but to r where that brings another below its bound by errors only: else two
/// that are 0 but for rounding can take turns for ever. Expects the errors of column r in column_bounds_.
PrincipalPivoting::Block PrincipalPivoting::first_to_fall(Index r, double direction, Block first) const {
  const auto column = tableau_.matrix().col(r);
  for (Index i = 0; i < tableau_.size(); ++i) {
    const double fall = -direction * column(i);
    if (i == r || !(fall > column_bounds_(i))) continue;
    const double step = std::max(basic_(i) - lower_bound(i), 0.0) / fall;
    if (first.pair == r) {
      if (step + bounds_(i) / fall < first.step) first = {i, step};
    } else if (step < first.step ||
               (first.pair != kNone && step == first.step && fall > std::abs(column(first.pair)))) {
      first = {i, step};
    }
  }
  return first;
}

/// Raising the driving variable until w_r is 0, which is a block by r itself, or another reaches its bound. A basic w_r
/// comes to 0 only if column r has a pivot.
PrincipalPivoting::Block PrincipalPivoting::block_upwards(Index r, bool has_pivot) const {
  Block first{kNone, std::numeric_limits<double>::infinity()};
  if (tableau_.z_is_basic(r)) {
    first = {r, -nonbasic_(r)};
  } else if (has_pivot) {
    first = {r, std::max(-basic_(r) / tableau_.matrix()(r, r), 0.0)};
  }
  return first_to_fall(r, 1, first);
}

/// w_r counts as 0 wherever the driving variable is: that one goes back to 0, or until another reaches its bound.
PrincipalPivoting::Block PrincipalPivoting::block_downwards(Index r) const {
  return first_to_fall(r, -1, {r, nonbasic_(r)});
}

/// Ends the major cycle of pair r: w_r becomes nonbasic at 0, by a pivot if it is basic. What is basic has to be
/// computed anew afterwards (refresh_values). O(n^2). @pre column r has a pivot, where w_r is basic
void PrincipalPivoting::finish(Index r, Counters& counters) {
  if (!tableau_.z_is_basic(r)) {
    tableau_.pivot(r);
    ++counters.pivots;
  }
  nonbasic_(r) = 0;
  unsettled_[static_cast<std::size_t>(r)] = false;
}

/// Makes basic variable k nonbasic at its bound, the driving variable of pair r having moved that far.
bool PrincipalPivoting::exchange_blocking(Index k, Index r, Counters& counters) {
  const double bound = lower_bound(k);
  if (has_pivot(k, column_bounds_)) {
    tableau_.pivot(k);
    nonbasic_(k) = bound;
  } else {
    if (!(std::abs(tableau_.matrix()(r, k)) > column_bounds_(r) && tableau_.determinant(k, r) > 0)) return false;
    tableau_.pivot(k, r);
    nonbasic_(k) = bound;
    nonbasic_(r) = basic_(r);  // was basic at this value; what was driven is basic now
  }
  ++counters.pivots;
  return true;
}

PrincipalPivoting::End PrincipalPivoting::make_nonnegative(Index r, double deadline_s, Counters& counters) {
  bool vanished = false;  // once w_r is 0 to within errors it stays so: nothing but those moves it from there on
  while (unsettled_[static_cast<std::size_t>(r)]) {
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    if (tableau_.pivots_since_rebuild() > tableau_.size() && !rebuild(r, counters)) return End::kSingularBasis;
    if (counters.pivots >= pivot_limit_) return End::kPivotLimit;
    const bool regular = has_pivot(r, column_bounds_);
    vanished = vanished || vanishes(r);
    if (vanished && regular) {
      finish(r, counters);
    } else {
      const Block block = vanished ? block_downwards(r) : block_upwards(r, regular);
      if (block.pair == kNone) {
        if (tableau_.pivots_since_rebuild() == 0) return End::kUnblocked;
        if (!rebuild(r, counters)) return End::kSingularBasis;
        continue;
      }
      const double move = vanished ? -block.step : block.step;
      nonbasic_(r) += move;
      basic_ += move * tableau_.matrix().col(r);
      if (block.pair != r) {
        if (!exchange_blocking(block.pair, r, counters)) return End::kNoPivot;
      } else if (vanished) {  // z_r is back at 0, and w_r stays basic
        unsettled_[static_cast<std::size_t>(r)] = false;
        nonbasic_(r) = 0;
      } else {
        finish(r, counters);
      }
    }
    refresh_values(r);
    if (!basic_.allFinite()) return End::kSingularBasis;
  }
  return End::kNonnegative;
}

PrincipalPivoting::End PrincipalPivoting::run(double deadline_s, Counters& counters) {
  start();
  for (Index r = next_distinguished(); r >= 0; r = next_distinguished()) {
    const End end = make_nonnegative(r, deadline_s, counters);
    if (end == End::kUnblocked && find_farkas_vector(r)) return end;
    if (end != End::kNonnegative) return end == End::kUnblocked ? End::kNoPivot : end;
  }
  if (tableau_.pivots_since_rebuild() > 0 && !rebuild(kNone, counters)) return End::kSingularBasis;
  return End::kNonnegative;
}

/// Writes u = e_r - (row r over the nonbasic w) to farkas_. @returns whether it proves on the data, to within rounding,
/// that no z >= 0 has M z + q >= 0: u >= 0, M'u <= 0, q'u < 0.
bool PrincipalPivoting::find_farkas_vector(Index r) {
  const Lcp& lcp = tableau_.lcp();
  const Index n = tableau_.size();
  if (tableau_.z_is_basic(r)) return false;
  farkas_.setZero();
  for (Index j = 0; j < n; ++j) {
    if (tableau_.z_is_basic(j)) farkas_(j) = std::max(-tableau_.matrix()(r, j), 0.0);
  }
  farkas_(r) = 1;
  for (Index j = 0; j < n; ++j) {
    const auto column = lcp.M.col(j);
    if (!(column.dot(farkas_) <= kDataError * column.cwiseAbs().dot(farkas_))) return false;
  }
  // M'u <= 0 holds only to within rounding, so that a large z could outweigh a q'u that is negative by rounding. The
  // margin of q'u is the square root of the round-off.
  return lcp.q.dot(farkas_) < -0x1p-26 * lcp.q.cwiseAbs().dot(farkas_);
}

}  // namespace

SolverDefinition lcpbench_solver_murty() {
  return define_solver<Murty, PrincipalSettings>(
      {.name = "murty",
       .summary = "least-index principal pivoting (Bard type), for P-matrices",
       .source = "Murty 1974: Note on a Bard-type scheme for solving the complementarity problem; Cottle, Pang, Stone "
                 "1992, section 4.2",
       .capabilities = kMurtyCapabilities});
}

SolverDefinition lcpbench_solver_principal_pivoting() {
  return define_solver<PrincipalPivoting, PrincipalSettings>(
      {.name = "principal_pivoting",
       .summary = "symmetric principal pivoting method; proves infeasibility of monotone problems",
       .source = "Dantzig, Cottle 1967: Positive (semi-)definite programming; Cottle, Pang, Stone 1992, section 4.3",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
