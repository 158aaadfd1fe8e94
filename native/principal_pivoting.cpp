#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/principal_tableau.h"

namespace lcpbench {
namespace {

enum class Distinguished { kLeastIndex, kMostNegative };

struct PrincipalPivotingSettings {
  std::int64_t max_pivots = 0;
  Distinguished distinguished = Distinguished::kMostNegative;
  double pivot_tolerance = 1e-12;
  double accept_residual = 1e-6;

  void visit(auto&& field) {
    field("max_pivots", max_pivots, IntegerRange{.min = 0}, "0 stands for max(1000, n^2), the paper's limit");
    field("distinguished", distinguished,
          Choices<Distinguished>{
              {{"least_index", Distinguished::kLeastIndex}, {"most_negative", Distinguished::kMostNegative}}},
          "which negative w is made nonnegative next");
    field("pivot_tolerance", pivot_tolerance, RealRange{.min = 0},
          "a pivot must exceed this times the sum of the magnitudes of which it is the difference");
    field("accept_residual", accept_residual, RealRange{.min = 0},
          "claim solved only when max|min(c_i z_i, w_i)| <= this * max|q|, c_i the largest |entry| of M's column i");
  }
};

/// The symmetric principal pivoting method of Dantzig and Cottle.
///
/// A negative w_r is distinguished and its complement (or, once it is nonbasic, w_r itself) raised until w_r is 0. A
/// basic variable that reaches its bound first is exchanged with its complement, or, where its diagonal entry is zero,
/// together with the pair r. The bound is 0, but for w_i that are negative still: those must not fall below a fixed
/// value under all of q. Solves or proves infeasible every LCP with positive semidefinite M, symmetric or not, and
/// every one with a P-matrix, barring degenerate cycles; ties in the ratio test go to the larger pivot, which is no
/// anticycling rule. Other M are tried: the claims are checked on the data, so they hold there too.
///
/// An unblocked raise gives u = (row r of the tableau) >= 0 with M'u <= 0 and q'u < 0, returned as Answer::farkas; it
/// is claimed only where that holds on the data to rounding. O(n^2) per pivot. [Dantzig, Cottle 1967; Cottle, Pang,
/// Stone 1992, section 4.3]
class PrincipalPivoting final : public Solver {
 public:
  explicit PrincipalPivoting(const PrincipalPivotingSettings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override;

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  enum class End { kNonnegative, kUnblocked, kNoPivot, kSingularBasis, kPivotLimit, kTimeLimit };
  struct Block {
    Index pair = -1;  ///< -1: nothing blocks
    double step = 0;
  };

  void start();
  End run(double deadline_s, Counters& counters);
  End make_nonnegative(Index r, double deadline_s, Counters& counters);
  Index next_distinguished() const;
  double value_of_w(Index i) const;
  double lower_bound(Index i) const;
  void refresh_values();
  bool rebuild(Counters& counters);
  double room_of_distinguished(Index r) const;
  Block find_block(Index r) const;
  bool exchange_blocking(Index k, Index r, Counters& counters);
  bool find_farkas_vector(Index r);

  PrincipalPivotingSettings settings_;
  PrincipalTableau tableau_;
  Vector nonbasic_;              // n: values of the nonbasic variables
  Vector basic_;                 // n: values of the basic ones
  std::vector<char> unsettled_;  // n: w_i was negative from the start on and is bounded by floor_, not by 0
  double floor_ = 0;
  Vector bounds_;  // n: of the rounding errors of the constants
  Vector farkas_;  // n
  std::int64_t limit_ = 0;
};

void PrincipalPivoting::on_load(const Problem& problem) {
  tableau_.load(make_lcp(problem));
  const Index n = tableau_.size();
  for (Vector* vector : {&nonbasic_, &basic_, &bounds_, &farkas_}) vector->resize(n);
  unsettled_.resize(static_cast<std::size_t>(n));
  limit_ = settings_.max_pivots > 0 ? settings_.max_pivots : std::max<std::int64_t>(1000, n * n);
}

void PrincipalPivoting::start() {
  tableau_.reset();
  nonbasic_.setZero();
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
  Index next = -1;
  for (Index i = 0; i < tableau_.size(); ++i) {
    if (!unsettled_[static_cast<std::size_t>(i)]) continue;
    if (next < 0) next = i;
    if (settings_.distinguished == Distinguished::kMostNegative && value_of_w(i) < value_of_w(next)) next = i;
  }
  return next;
}

void PrincipalPivoting::refresh_values() {
  basic_ = tableau_.constants();
  basic_.noalias() += tableau_.matrix() * nonbasic_;
  tableau_.error_bounds(static_cast<double>(tableau_.size()) * std::numeric_limits<double>::epsilon(), bounds_);
  for (Index i = 0; i < tableau_.size(); ++i) {
    auto& unsettled = unsettled_[static_cast<std::size_t>(i)];
    if (unsettled && value_of_w(i) >= (tableau_.z_is_basic(i) ? 0.0 : -bounds_(i))) unsettled = false;
  }
}

bool PrincipalPivoting::rebuild(Counters& counters) {
  ++counters.factorizations;
  if (!tableau_.rebuild()) return false;
  refresh_values();
  return basic_.allFinite();
}

/// How far the driving variable can go until w_r is 0.
double PrincipalPivoting::room_of_distinguished(Index r) const {
  if (tableau_.z_is_basic(r)) return -nonbasic_(r);
  if (!tableau_.usable_diagonal(r, settings_.pivot_tolerance)) return std::numeric_limits<double>::infinity();
  return -basic_(r) / tableau_.matrix()(r, r);
}

/// The first basic variable to reach its bound when the nonbasic one of pair r rises; r itself when that is w_r at 0.
/// A fall of no more than rounding, relative to the largest in the column, blocks nothing.
PrincipalPivoting::Block PrincipalPivoting::find_block(Index r) const {
  const auto column = tableau_.matrix().col(r);
  const double noise = settings_.pivot_tolerance * column.cwiseAbs().maxCoeff();
  Block first{-1, room_of_distinguished(r)};
  if (std::isfinite(first.step)) first.pair = r;
  for (Index i = 0; i < tableau_.size(); ++i) {
    if (i == r || !(column(i) < -noise)) continue;
    const double step = std::max(basic_(i) - lower_bound(i), 0.0) / -column(i);
    const bool better_tie = step == first.step && first.pair != r && first.pair >= 0 && column(i) < column(first.pair);
    if (step < first.step || better_tie) first = {i, step};
  }
  return first;
}

/// Makes basic variable k nonbasic at its bound, the driving variable of pair r having been raised that far.
bool PrincipalPivoting::exchange_blocking(Index k, Index r, Counters& counters) {
  const double bound = lower_bound(k);
  if (tableau_.usable_diagonal(k, settings_.pivot_tolerance)) {
    tableau_.pivot(k);
    nonbasic_(k) = bound;
  } else {
    const Matrix& M = tableau_.matrix();
    const double magnitude = std::abs(M(k, k) * M(r, r)) + std::abs(M(k, r) * M(r, k));
    if (!(std::abs(tableau_.determinant(k, r)) > settings_.pivot_tolerance * magnitude)) return false;
    tableau_.pivot(k, r);
    nonbasic_(k) = bound;
    nonbasic_(r) = basic_(r);  // was basic at this value; what was driven is basic now
  }
  ++counters.pivots;
  return true;
}

PrincipalPivoting::End PrincipalPivoting::make_nonnegative(Index r, double deadline_s, Counters& counters) {
  while (unsettled_[static_cast<std::size_t>(r)]) {
    if (!(wall_clock_s() < deadline_s)) return End::kTimeLimit;
    if (tableau_.pivots_since_rebuild() > tableau_.size() && !rebuild(counters)) return End::kSingularBasis;
    const Block block = find_block(r);
    if (block.pair < 0) {
      if (tableau_.pivots_since_rebuild() == 0) return End::kUnblocked;
      if (!rebuild(counters)) return End::kSingularBasis;
      continue;
    }
    if (counters.pivots >= limit_) return End::kPivotLimit;
    nonbasic_(r) += block.step;
    basic_ += block.step * tableau_.matrix().col(r);
    if (block.pair != r) {
      if (!exchange_blocking(block.pair, r, counters)) return End::kNoPivot;
    } else {
      if (!tableau_.z_is_basic(r)) {
        tableau_.pivot(r);
        ++counters.pivots;
      }
      nonbasic_(r) = 0;
      unsettled_[static_cast<std::size_t>(r)] = false;
    }
    refresh_values();
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
  if (tableau_.pivots_since_rebuild() > 0 && !rebuild(counters)) return End::kSingularBasis;
  return End::kNonnegative;
}

/// u = e_r - (row r over the nonbasic w), whether it proves on the data, to within their rounding, that no z >= 0 has
/// M z + q >= 0: u >= 0, M'u <= 0, q'u < 0.
bool PrincipalPivoting::find_farkas_vector(Index r) {
  const Lcp& lcp = tableau_.lcp();
  const Index n = tableau_.size();
  const double rounding = 4 * static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  farkas_.setZero();
  for (Index j = 0; j < n; ++j) {
    if (tableau_.z_is_basic(j)) farkas_(j) = std::max(-tableau_.matrix()(r, j), 0.0);
  }
  if (tableau_.z_is_basic(r)) return false;
  farkas_(r) = 1;
  for (Index j = 0; j < n; ++j) {
    const auto column = lcp.M.col(j);
    if (!(column.dot(farkas_) <= rounding * column.cwiseAbs().dot(farkas_))) return false;
  }
  // Errors of M'u count as much as q'u would have to: the margin is the square root of the round-off.
  return lcp.q.dot(farkas_) < -0x1p-26 * lcp.q.cwiseAbs().dot(farkas_);
}

void PrincipalPivoting::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = -1, .pivots = 0, .factorizations = 0};
  const End end = run(wall_clock_s() + request.time_limit_s, answer.counters);
  if (end != End::kUnblocked) tableau_.solution(answer.z);
  switch (end) {
    case End::kNonnegative:
      if (tableau_.residual(answer.z) <= settings_.accept_residual * tableau_.largest_q()) {
        answer.claim = Claim::kSolved;
      } else {
        answer.detail = "the final basis is too ill-conditioned for the accuracy asked for";
      }
      return;
    case End::kUnblocked:
      answer.claim = Claim::kUnsolvable;
      answer.farkas = farkas_;
      answer.detail = "u >= 0 with M'u <= 0 and q'u < 0, to rounding";
      return;
    case End::kNoPivot: answer.detail = "no usable pivot: M is not positive semidefinite to working precision"; return;
    case End::kSingularBasis: answer.detail = "the basis is singular to working precision"; return;
    case End::kPivotLimit: answer.claim = Claim::kIterationLimit; return;
    case End::kTimeLimit: answer.claim = Claim::kTimeLimit; return;
  }
}

constexpr Capabilities kCapabilities{.guarantees = "positive semidefinite M and P-matrices, barring degenerate cycles",
                                     .obeys_time_limit = true,
                                     .allocation_free = true};

const Capabilities& PrincipalPivoting::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_principal_pivoting() {
  return define_solver<PrincipalPivoting, PrincipalPivotingSettings>(
      {.name = "principal_pivoting",
       .summary = "symmetric principal pivoting method; proves infeasibility of monotone problems",
       .source = "Dantzig, Cottle 1967: Positive (semi-)definite programming; Cottle, Pang, Stone 1992, section 4.3",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
