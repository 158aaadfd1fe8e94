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

/// denominator * basic_i = D_i0 + sum_j D_ij nonbasic_j, with denominator > 0; at first w = q + M z + e z_0, with e all
/// ones and the artificial variable z_0. Numbers of the variables: w_i is i, z_i is n + i, z_0 is 2 n.
class Dictionary {
 public:
  /// @param lcp  [q M] times the denominator, whose power r - 1 divides every minor of it of order r
  Dictionary(const IntegerMatrix& lcp, const Integer& denominator)
      : n_(lcp.rows()),
        entries_(n_, n_ + 2),
        basic_(range(0, n_)),
        nonbasic_(range(n_ - 1, 2 * n_ + 1)),
        column_of_(index(n_), -1),
        denominator_(denominator) {
    nonbasic_[0] = -1;  // the column of constants
    for (Index i = 0; i < n_; ++i) {
      for (Index j = 0; j <= n_; ++j) fmpz_set(entries_(i, j), lcp(i, j));
      fmpz_set(entries_(i, n_ + 1), denominator.get());
    }
  }

  Index artificial() const { return 2 * n_; }
  Index complement(Index variable) const { return variable < n_ ? variable + n_ : variable - n_; }
  Index basic(Index row) const { return basic_[index(row)]; }
  const fmpz* operator()(Index i, Index j) const { return entries_(i, j); }
  const Integer& denominator() const { return denominator_; }

  Index column(Index variable) const {
    return std::find(nonbasic_.begin(), nonbasic_.end(), variable) - nonbasic_.begin();
  }

  /// The row where the artificial variable enters: that of the least q_i; of several the last, which comes first in
  /// lexicographic order. -1 when q >= 0. @pre no pivot was made
  Index first_row() const {
    Index row = -1;
    for (Index i = 0; i < n_; ++i) {
      if (entries_.sign(i, 0) >= 0) continue;
      if (row < 0 || fmpz_cmp(entries_(i, 0), entries_(row, 0)) <= 0) row = i;
    }
    return row;
  }

  /// The lexicographic ratio test: the row whose basic variable is the first to fall to zero as the variable of column
  /// s grows; if the artificial variable is among those that reach zero together, its row. -1 when none falls: a ray.
  Index blocking_row(Index s) const {
    std::vector<Index> rows;
    for (Index i = 0; i < n_; ++i) {
      if (entries_.sign(i, s) < 0) rows.push_back(i);
    }
    keep_smallest(rows, s, [&](Index i, Integer& value) { fmpz_set(value.get(), entries_(i, 0)); });
    for (const Index i : rows) {
      if (basic(i) == artificial()) return i;
    }
    for (Index j = 0; j < n_ && rows.size() > 1; ++j) {
      keep_smallest(rows, s, [&](Index i, Integer& value) { set_inverse_entry(i, j, value); });
    }
    return rows.empty() ? -1 : rows.front();
  }

  /// Exchanges the basic variable of row r with the nonbasic one of column s.
  /// @returns false when the deadline passed or the entries take too much memory: the dictionary is then of no use
  bool pivot(Index r, Index s, const Deadline& deadline) {
    const Integer old_denominator = denominator_;
    Integer pivot;
    fmpz_set(pivot.get(), entries_(r, s));
    double words = 0;
    double counted = 0;
    for (Index i = 0; i < n_; ++i) {
      if (i == r) continue;
      const auto work = 1 + static_cast<std::int64_t>((words - counted) / kWordsAStep);
      if (deadline.passed(work) || words > kMostWords) return false;
      counted = words;
      for (Index j = 0; j < n_ + 2; ++j) {
        if (j == s) continue;
        fmpz_fmms(entries_(i, j), entries_(i, j), pivot.get(), entries_(i, s), entries_(r, j));
        fmpz_divexact(entries_(i, j), entries_(i, j), old_denominator.get());
        words += static_cast<double>(fmpz_size(entries_(i, j)));
      }
    }
    for (Index j = 0; j < n_ + 2; ++j) {
      if (j != s) fmpz_neg(entries_(r, j), entries_(r, j));
    }
    fmpz_set(entries_(r, s), old_denominator.get());
    denominator_ = pivot;
    if (fmpz_sgn(pivot.get()) < 0) {
      fmpz_neg(denominator_.get(), denominator_.get());
      fmpz_mat_neg(entries_.get(), entries_.get());
    }
    exchange(r, s);
    return true;
  }

 private:
  void exchange(Index r, Index s) {
    std::swap(basic_[index(r)], nonbasic_[index(s)]);
    if (basic(r) < n_) column_of_[index(basic(r))] = -1;
    if (const Index left = nonbasic_[index(s)]; left < n_) column_of_[index(left)] = s;
  }

  // Entry (i, j) of the basis inverse, times the denominator: the derivative of basic_i by q_j.
  void set_inverse_entry(Index i, Index j, Integer& value) const {
    const Index column = column_of_[index(j)];
    if (column >= 0)
      fmpz_neg(value.get(), entries_(i, column));
    else if (basic(i) == j)
      value = denominator_;
    else
      fmpz_zero(value.get());
  }

  // Keeps of `rows` those of the smallest value(row) / -D(row, s).
  template <class Value>
  void keep_smallest(std::vector<Index>& rows, Index s, Value&& value) const {
    std::vector<Index> kept;
    Integer best;
    Integer own;
    Integer difference;
    for (const Index i : rows) {
      value(i, own);
      if (!kept.empty()) {
        // own / -D_is - best / -D_bs, times the product of the two positive denominators
        const Index b = kept.front();
        fmpz_fmms(difference.get(), best.get(), entries_(i, s), own.get(), entries_(b, s));
        const int sign = fmpz_sgn(difference.get());
        if (sign > 0) continue;
        if (sign < 0) kept.clear();
      }
      if (kept.empty()) std::swap(best, own);
      kept.push_back(i);
    }
    rows = std::move(kept);
  }

  Index n_;
  IntegerMatrix entries_;  // n x (n + 2)
  std::vector<Index> basic_;
  std::vector<Index> nonbasic_;
  std::vector<Index> column_of_;  // of w_i where it is nonbasic, else -1
  Integer denominator_{1};
};

/// The z of a vertex or of the direction of a ray, and what they are over.
struct Path {
  LemkeEnding ending = LemkeEnding::kGaveUp;
  IntegerMatrix z{};
  Integer denominator{1};
};

/// Entry i is the one of the dictionary's column in the row of z_i; 0 where z_i is not basic.
Path ended(LemkeEnding ending, const Dictionary& dictionary, Index n, Index column) {
  Path path{ending, IntegerMatrix(n), dictionary.denominator()};
  for (Index i = 0; i < n; ++i) {
    const Index variable = dictionary.basic(i);
    if (variable >= n && variable < 2 * n) fmpz_set(path.z(variable - n), dictionary(i, column));
  }
  return path;
}

/// @param lcp,denominator  as Dictionary takes them
Path followed(const IntegerMatrix& lcp, const Integer& denominator, const Deadline& deadline) {
  const Index n = lcp.rows();
  Dictionary dictionary(lcp, denominator);
  Index row = dictionary.first_row();
  Index entering = dictionary.artificial();
  if (row < 0) return ended(LemkeEnding::kSolution, dictionary, n, 0);
  while (true) {
    const Index leaving = dictionary.basic(row);
    if (!dictionary.pivot(row, dictionary.column(entering), deadline)) return {};
    if (leaving == dictionary.artificial()) return ended(LemkeEnding::kSolution, dictionary, n, 0);
    entering = dictionary.complement(leaving);
    const Index column = dictionary.column(entering);
    row = dictionary.blocking_row(column);
    if (row >= 0) continue;
    Path ray = ended(LemkeEnding::kRay, dictionary, n, column);
    if (entering >= n) fmpz_set(ray.z(entering - n), dictionary.denominator().get());
    return ray;
  }
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

  const Path path = followed(lcp, denominator, deadline);
  LemkeOutcome outcome{path.ending, IntegerMatrix(path.ending == LemkeEnding::kRay ? system.size : system.rows.cols())};
  if (path.ending == LemkeEnding::kRay) {
    for (std::size_t j = 0; j < kept.size(); ++j) fmpz_set(outcome.x(kept[j]), path.z(static_cast<Index>(j)));
  }
  if (path.ending != LemkeEnding::kSolution) return outcome;
  IntegerMatrix over(std::ssize(columns));  // [denominator; z of `kept`]
  fmpz_set(over(0), path.denominator.get());
  for (Index j = 1; j < over.rows(); ++j) fmpz_set(over(j), path.z(j - 1));
  const IntegerMatrix decided = X * over;
  for (Index i = 0; i < decided.rows(); ++i) fmpz_neg(outcome.x(1 + chosen[index(i)]), decided(i));
  for (Index j = 0; j < over.rows(); ++j) fmpz_mul(outcome.x(columns[index(j)]), over(j), denominator.get());
  return outcome;
}

}  // namespace lcpbench::exact
