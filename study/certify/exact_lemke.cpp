#include "study/certify/exact_lemke.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
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
  explicit Dictionary(const IntegerLcp& lcp)
      : n_(lcp.size()), entries_(n_, n_ + 2), basic_(index(n_)), nonbasic_(index(n_ + 2)), column_of_(index(n_), -1) {
    denominator_ = lcp.denominator;
    std::iota(basic_.begin(), basic_.end(), Index{0});
    nonbasic_[0] = -1;  // the column of constants
    std::iota(nonbasic_.begin() + 1, nonbasic_.end(), n_);
    for (Index i = 0; i < n_; ++i) {
      fmpz_set(entries_(i, 0), lcp.q[index(i)].get());
      for (Index j = 0; j < n_; ++j) fmpz_set(entries_(i, 1 + j), lcp.M(i, j));
      fmpz_set(entries_(i, n_ + 1), lcp.denominator.get());
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
      if (fmpz_sgn(entries_(i, 0)) >= 0) continue;
      if (row < 0 || fmpz_cmp(entries_(i, 0), entries_(row, 0)) <= 0) row = i;
    }
    return row;
  }

  /// The lexicographic ratio test: the row whose basic variable is the first to fall to zero as the variable of column
  /// s grows; if the artificial variable is among those that reach zero together, its row. -1 when none falls: a ray.
  Index blocking_row(Index s) const {
    std::vector<Index> rows;
    for (Index i = 0; i < n_; ++i) {
      if (fmpz_sgn(entries_(i, s)) < 0) rows.push_back(i);
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
    if (pivot.sign() < 0) negate();
    exchange(r, s);
    return true;
  }

 private:
  void negate() {
    fmpz_neg(denominator_.get(), denominator_.get());
    fmpz_mat_neg(entries_.get(), entries_.get());
  }

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
        if (difference.sign() > 0) continue;
        if (difference.sign() < 0) kept.clear();
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

/// Entry i is the one of the dictionary's column in the row of z_i; 0 where z_i is not basic.
IntegerVector basic_z(const Dictionary& dictionary, Index n, Index column) {
  IntegerVector z(index(n));
  for (Index i = 0; i < n; ++i) {
    const Index variable = dictionary.basic(i);
    if (variable >= n && variable < 2 * n) fmpz_set(z[index(variable - n)].get(), dictionary(i, column));
  }
  return z;
}

LemkeOutcome at_vertex(const Dictionary& dictionary, Index n) {
  return {LemkeEnding::kSolution, basic_z(dictionary, n, 0), dictionary.denominator()};
}

LemkeOutcome along_ray(const Dictionary& dictionary, Index n, Index s, Index entering) {
  LemkeOutcome outcome{LemkeEnding::kRay, basic_z(dictionary, n, s), Integer(1)};
  if (entering >= n) outcome.z[index(entering - n)] = dictionary.denominator();
  return outcome;
}

}  // namespace

LemkeOutcome exact_lemke(const IntegerLcp& lcp, const Deadline& deadline) {
  const Index n = lcp.size();
  Dictionary dictionary(lcp);
  Index row = dictionary.first_row();
  Index entering = dictionary.artificial();
  if (row < 0) return at_vertex(dictionary, n);
  while (true) {
    const Index leaving = dictionary.basic(row);
    if (!dictionary.pivot(row, dictionary.column(entering), deadline)) return {};
    if (leaving == dictionary.artificial()) return at_vertex(dictionary, n);
    entering = dictionary.complement(leaving);
    const Index column = dictionary.column(entering);
    row = dictionary.blocking_row(column);
    if (row < 0) return along_ray(dictionary, n, column, entering);
  }
}

}  // namespace lcpbench::exact
