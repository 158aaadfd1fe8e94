#include "study/certify/exact_lemke.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace lcpbench::exact {
namespace {

/// The most words of 64 bits that all entries together may take: 512 MiB.
constexpr double kMostWords = 64.0 * 1024 * 1024;
/// Words of computed entries that count as one step of work, see Deadline::passed().
constexpr double kWordsAStep = 64;

/// The equations w - M z - e z_0 = q, e all ones, solved for the basic variables. Columns: w_i is i, z_i is n + i, the
/// artificial z_0 is 2 n, q is 2 n + 1. The column of a basic variable is the denominator in its row, else zero.
class Tableau {
 public:
  /// @param lcp  [q M] times the denominator, whose power r - 1 divides every minor of it of order r
  Tableau(const IntegerMatrix& lcp, const Integer& denominator)
      : n_(lcp.rows()), rows_(n_, 2 * n_ + 2), basic_(range(0, n_)), denominator_(denominator) {
    for (Index i = 0; i < n_; ++i) {
      fmpz_set(rows_(i, i), denominator.get());
      for (Index j = 0; j < n_; ++j) fmpz_neg(rows_(i, n_ + j), lcp(i, 1 + j));
      fmpz_neg(rows_(i, 2 * n_), denominator.get());
      fmpz_set(rows_(i, 2 * n_ + 1), lcp(i, 0));
    }
  }

  Index artificial() const { return 2 * n_; }
  Index complement(Index variable) const { return variable < n_ ? variable + n_ : variable - n_; }
  Index basic(Index row) const { return basic_[index(row)]; }
  const Integer& denominator() const { return denominator_; }

  /// The row where the artificial variable enters: that of the least q_i; of several the last, which comes first in
  /// lexicographic order. -1 when q >= 0. @pre no pivot was made
  Index first_row() const {
    Index row = -1;
    for (Index i = 0; i < n_; ++i) {
      if (rows_.sign(i, 2 * n_ + 1) >= 0) continue;
      if (row < 0 || fmpz_cmp(rows_(i, 2 * n_ + 1), rows_(row, 2 * n_ + 1)) <= 0) row = i;
    }
    return row;
  }

  /// The lexicographic ratio test: the row whose basic variable is the first to fall to zero as the variable of column
  /// s grows; if the artificial variable is among those that reach zero together, its row. -1 when none falls: a ray.
  Index blocking_row(Index s) const {
    std::vector<Index> rows;
    for (Index i = 0; i < n_; ++i) {
      if (rows_.sign(i, s) > 0) rows.push_back(i);
    }
    keep_smallest(rows, s, 2 * n_ + 1);
    for (const Index i : rows) {
      if (basic(i) == artificial()) return i;
    }
    for (Index j = 0; j < n_ && rows.size() > 1; ++j) keep_smallest(rows, s, j);
    return rows.empty() ? -1 : rows.front();
  }

  /// Makes the variable of column s basic in row r.
  /// @returns false when the deadline passed or the entries take too much memory: the tableau is then of no use
  bool pivot(Index r, Index s, const Deadline& deadline) {
    const Integer pivot(rows_(r, s));
    double words = 0;
    double counted = 0;
    for (Index i = 0; i < n_; ++i) {
      if (i == r) continue;
      const auto work = 1 + static_cast<std::int64_t>((words - counted) / kWordsAStep);
      if (deadline.passed(work) || words > kMostWords) return false;
      counted = words;
      const Integer factor(rows_(i, s));
      for (Index j = 0; j < rows_.cols(); ++j) {
        fmpz_fmms(rows_(i, j), rows_(i, j), pivot.get(), factor.get(), rows_(r, j));
        fmpz_divexact(rows_(i, j), rows_(i, j), denominator_.get());
        words += static_cast<double>(fmpz_size(rows_(i, j)));
      }
    }
    basic_[index(r)] = s;
    denominator_ = pivot;
    if (fmpz_sgn(pivot.get()) < 0) {
      fmpz_neg(denominator_.get(), denominator_.get());
      fmpz_mat_neg(rows_.get(), rows_.get());
    }
    return true;
  }

  /// z of the basic variables in units of the column, times the denominator. @param sign  of the column
  IntegerMatrix z(Index column, slong sign) const {
    IntegerMatrix z(n_);
    for (Index i = 0; i < n_; ++i) {
      const Index variable = basic(i);
      if (variable >= n_ && variable < 2 * n_) fmpz_mul_si(z(variable - n_), rows_(i, column), sign);
    }
    return z;
  }
  IntegerMatrix vertex() const { return z(2 * n_ + 1, 1); }
  IntegerMatrix ray(Index entering) const {
    IntegerMatrix direction = z(entering, -1);
    if (entering >= n_ && entering < 2 * n_) fmpz_set(direction(entering - n_), denominator_.get());
    return direction;
  }

 private:
  /// Keeps of `rows` those of the smallest ratio of column j to column s.
  void keep_smallest(std::vector<Index>& rows, Index s, Index j) const {
    std::vector<Index> kept;
    Integer difference;
    for (const Index i : rows) {
      if (!kept.empty()) {
        const Index b = kept.front();
        fmpz_fmms(difference.get(), rows_(i, j), rows_(b, s), rows_(b, j), rows_(i, s));
        const int sign = fmpz_sgn(difference.get());
        if (sign > 0) continue;
        if (sign < 0) kept.clear();
      }
      kept.push_back(i);
    }
    rows = std::move(kept);
  }

  Index n_;
  IntegerMatrix rows_;
  std::vector<Index> basic_;
  Integer denominator_;
};

/// @param z  of a vertex, or of the direction of a ray, times the tableau's denominator
LemkeEnding follow(Tableau& tableau, IntegerMatrix& z, const Deadline& deadline) {
  Index entering = tableau.artificial();
  for (Index row = tableau.first_row(); row >= 0; row = tableau.blocking_row(entering)) {
    const Index leaving = tableau.basic(row);
    if (!tableau.pivot(row, entering, deadline)) return LemkeEnding::kGaveUp;
    if (leaving == tableau.artificial()) {
      z = tableau.vertex();
      return LemkeEnding::kSolution;
    }
    entering = tableau.complement(leaving);
  }
  const bool is_solved = entering == tableau.artificial();  // from the beginning
  z = is_solved ? tableau.vertex() : tableau.ray(entering);
  return is_solved ? LemkeEnding::kSolution : LemkeEnding::kRay;
}

/// Makes the denominator of A X = denominator B the determinant: so that the entries, and those that Lemke's method
/// makes of them, are minors of the data.
void over_determinant(const IntegerMatrix& A, IntegerMatrix& X, Integer& denominator) {
  if (A.rows() == 0) return;
  Integer factor;
  fmpz_mat_det_modular_given_divisor(factor.get(), A.get(), denominator.get(), 1);
  fmpz_divexact(factor.get(), factor.get(), denominator.get());
  fmpz_abs(factor.get(), factor.get());
  fmpz_mul(denominator.get(), denominator.get(), factor.get());
  fmpz_mat_scalar_mul_fmpz(X.get(), X.get(), factor.get());
}

}  // namespace

LemkeOutcome exact_lemke(const ExactSystem& system, const std::vector<Index>& basis, std::vector<Index> kept,
                         const Deadline& deadline) {
  // The square equations of p and of the basis, in the same order of rows and columns.
  std::vector<Index> equations = range(0, system.potentials);
  for (const Index i : basis) equations.push_back(system.row_of(i));
  const auto columns_of = [](std::vector<Index> rows) {
    for (Index& row : rows) ++row;  // column 0 is that of constants
    return rows;
  };
  std::vector<Index> chosen;
  IntegerMatrix A = part(system.rows, equations, columns_of(equations));
  const std::vector<Index> independent = independent_columns(A, deadline);
  for (const Index k : independent) chosen.push_back(equations[index(k)]);
  for (const Index row : equations) {
    const bool is_left_out = std::find(chosen.begin(), chosen.end(), row) == chosen.end();
    if (is_left_out && row >= system.potentials) kept.push_back(row - system.potentials);
  }
  A = part(A, independent, independent);
  if (independent.size() < equations.size() && independent_columns(A, deadline).size() < independent.size()) return {};

  std::vector<Index> rows;     // of the LCP that is left
  std::vector<Index> columns;  // that of the constants, then those of its z
  columns.push_back(0);
  for (const Index i : kept) {
    rows.push_back(system.row_of(i));
    columns.push_back(system.column_of(i));
  }
  IntegerMatrix X;  // [p; z of the basis] = (column 0 + the others times z of `kept`) / -denominator
  Integer denominator;
  solve(A, part(system.rows, chosen, columns), X, denominator, deadline);
  over_determinant(A, X, denominator);
  IntegerMatrix lcp = part(system.rows, rows, columns);
  fmpz_mat_scalar_mul_fmpz(lcp.get(), lcp.get(), denominator.get());
  const IntegerMatrix eliminated = part(system.rows, rows, columns_of(chosen)) * X;
  fmpz_mat_sub(lcp.get(), lcp.get(), eliminated.get());

  Tableau tableau(lcp, denominator);
  IntegerMatrix z;
  LemkeOutcome outcome{follow(tableau, z, deadline)};
  if (outcome.ending == LemkeEnding::kRay) {
    outcome.x = IntegerMatrix(system.size);
    for (Index j = 0; j < z.rows(); ++j) fmpz_set(outcome.x(kept[index(j)]), z(j));
  }
  if (outcome.ending != LemkeEnding::kSolution) return outcome;
  outcome.x = Point(system.rows.cols());
  IntegerMatrix over(std::ssize(columns));  // [denominator; z of `kept`]
  fmpz_set(over(0), tableau.denominator().get());
  for (Index j = 1; j < over.rows(); ++j) fmpz_set(over(j), z(j - 1));
  const IntegerMatrix decided = X * over;
  for (Index i = 0; i < decided.rows(); ++i) fmpz_neg(outcome.x(1 + chosen[index(i)]), decided(i));
  for (Index j = 0; j < over.rows(); ++j) fmpz_mul(outcome.x(columns[index(j)]), over(j), denominator.get());
  return outcome;
}

}  // namespace lcpbench::exact
