#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/least_squares.h"
#include "native/lemke/loaded_problem.h"
#include "native/lemke/ordered_lu.h"
#include "native/lemke/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basis of the rules of 2012, as the public code of the paper's authors keeps it: all of B, in the signs of
/// w - M z - cover z0 = q, each column at the place of the variable that it replaced. d = B^-1 (entering column) by
/// OrderedLu; x by updates only. Slot i is the variable of column i.
///
/// On redundant contacts rounding alone decides the paths at small tolerances, so that the rates follow from the order
/// of elimination: this is that order, and the bits are the same at each instruction-set level. A pivot costs 2/3 n^3
/// at most, and far less where w are basic. Memory: n x n numbers for each of M (bare LCPs twice), L and U.
class OrderedBasis {
 public:
  static constexpr bool kRulesOf2012 = true;

  void load(const Input& input) {
    problem_.load(input);
    const Count n = problem_.n();
    const Count padded = P::padded(n);
    lu_.load(n);
    columns_.resize(n);
    eliminated_.resize(n);
    column_.fill(padded, 0);
    for (Buffer<double>* slots : {&x_, &d_, &ratio_}) slots->fill(padded, 0);
    id_.fill(padded, kInfinity<double>);
    slots_ = {padded, x_.data(), d_.data(), ratio_.data(), id_.data(), true};
  }

  const LoadedProblem& problem() const { return problem_; }
  const Slots& slots() const { return slots_; }
  Count slot_of(Count variable) const { return problem_.slot_of[variable]; }

  /// Brings the artificial variable in for w of `row`.
  void start(Count row) {
    const Count n = problem_.n();
    const double value = -problem_.q[row];
    for (Count i = 0; i < n; ++i) put(i, i, problem_.q[i] + problem_.cover(i) * value);
    for (Count i = n; i < slots_.count; ++i) x_[i] = 0;  // an overflow leaves NaN there
    put(row, problem_.artificial(), value);
  }

  /// d for the entering variable, on a singular basis in the least squares. False when that cannot be had.
  template <bool kResolve>
  bool solve(Count entering) {
    static_assert(!kResolve);
    const Count n = problem_.n();
    const bool regular = factor();
    write_column(entering);
    if (!regular) {
      return LeastSquares::solve(
          n, [this, n](Count slot) { return columns_[slot] < n ? columns_[slot] : -1; },
          [this](Count row, Count slot) { return entry(row, columns_[slot]); },
          [this](Count row) { return column_[row]; }, d_.data());
    }
    lu_.solve(column_.data());
    for (Count i = 0; i < n; ++i) d_[i] = column_[i];
    return true;
  }

  void exchange(Count entering, Count leaving, double value) { put(slot_of(leaving), entering, value); }

 private:
  using P = Packed<double>;

  void put(Count slot, Count variable, double value) {
    columns_[slot] = variable;
    id_[slot] = static_cast<double>(variable);
    x_[slot] = value;
    problem_.slot_of[variable] = slot;
  }

  /// False when the basis is singular.
  bool factor() {
    Count same = 0;
    while (same < lu_.done() && columns_[same] == eliminated_[same]) ++same;
    lu_.forget(same);
    for (Count slot = same; slot < problem_.n(); ++slot) {
      const Count variable = columns_[slot];
      eliminated_[slot] = variable;
      if (variable < problem_.n() && lu_.add_unit(variable)) continue;
      write_column(variable);
      if (!lu_.add(column_.data())) return false;
    }
    return true;
  }

  /// B's column of the variable, to column_.
  void write_column(Count variable) {
    const Count n = problem_.n();
    MatrixColumns& M = problem_.M;
    for (Count i = 0; i < slots_.count; ++i) column_[i] = 0;
    if (variable < n) {
      column_[variable] = 1;
    } else if (variable == problem_.artificial()) {
      for (Count i = 0; i < n; ++i) column_[i] = -problem_.cover(i);
    } else if (const Count j = variable - n; j < M.dense()) {
      const double* const column = M.column(j);
      for (Count i = 0; i < M.dense(); ++i) column_[i] = -column[i];
      if (const Count cone = M.cone(j); cone >= 0) column_[M.dense() + cone] = -M.cone_coefficient(j);
    } else {
      for (Count t = M.friction_first(j - M.dense()); t < M.friction_last(j - M.dense()); ++t) column_[t] = -1;
    }
  }

  /// Of a variable that is no w.
  double entry(Count row, Count variable) {
    if (variable == problem_.artificial()) return -problem_.cover(row);
    return -problem_.M.entry(row, variable - problem_.n());
  }

  LoadedProblem problem_;
  OrderedLu lu_;
  Buffer<Count> columns_;     ///< the basic variables in their order
  Buffer<Count> eliminated_;  ///< likewise of what lu_ holds
  Buffer<double> column_;
  Buffer<double> x_, d_, ratio_, id_;
  Slots slots_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
