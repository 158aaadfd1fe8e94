#pragma once

#include <Eigen/Core>
#include <Eigen/LU>

#include "native/kernels/pack.h"
#include "native/lemke/loaded_problem.h"
#include "native/lemke/ratio_test.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basis of `lemke{engine=dense}`, the reference of all time ratios, which is simple on purpose. B, n x n, consists
/// of the basic columns of w - M z - cover z0 = q. x = B^-1 q and d = B^-1 (entering column) come from a new LU
/// factorization of B with partial pivoting at each pivot: 2/3 n^3 operations, and allocations from about 400 rows on.
/// Slot i holds the variable of B's column i. Variables 0 to n - 1 are w, n to 2 n - 1 are z, 2 n is z0.
class DenseBasis {
 public:
  /// Copies the problem, with all of M, and allocates for it. start() sets the basis.
  void load(const Input& input) {
    problem_.load(input);
    const Count n = problem_.n();
    const Count padded = Packed<double>::padded(n);
    B_.resize(n, n);
    rhs_.resize(n, 2);
    solution_.resize(n, 2);
    if (lu_.rows() != n) lu_ = Eigen::PartialPivLU<Dense>(n);
    M_.resize(n, n);
    for (Count j = 0; j < n; ++j) {
      for (Count i = 0; i < n; ++i) M_(i, j) = problem_.M.entry(i, j);
    }
    for (Buffer<double>* slots : {&x_, &d_, &ratio_}) slots->fill(padded, 0);
    id_.fill(padded, kInfinity<double>);
    slots_ = {padded, x_.data(), d_.data(), ratio_.data(), id_.data()};
  }

  const LoadedProblem& problem() const { return problem_; }
  const Slots& slots() const { return slots_; }
  Count slot_of(Count variable) const { return problem_.slot_of[variable]; }

  /// The basis of all w but that of `row`, which z0 replaces. @pre `row` is the last to be covered: then x >= 0
  void start(Count row) {
    const Count n = problem_.n();
    B_.setIdentity();
    for (Count i = 0; i < n; ++i) put(i, i);
    for (Count i = n; i < slots_.count; ++i) x_[i] = 0;  // the last path may have left NaN in the padding
    place(row, problem_.artificial());
  }

  /// Solves for d of the entering variable, and for x. Always true: a singular B leaves NaN or infinity, which the ratio
  /// test finds.
  bool solve(Count entering) {
    lu_.compute(B_);
    write_column(entering, rhs_.col(0));
    solution_.col(0) = lu_.solve(rhs_.col(0));
    store(d_, 0);
    solve_for_values();
    return true;
  }

  /// Solves for x of the present basis. Always true.
  bool resolve() {
    lu_.compute(B_);
    solve_for_values();
    return true;
  }

  void exchange(Count entering, Count leaving) { place(slot_of(leaving), entering); }

 private:
  using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic>;

  void solve_for_values() {
    for (Count i = 0; i < problem_.n(); ++i) rhs_(i, 1) = problem_.q[i];
    solution_.col(1) = lu_.solve(rhs_.col(1));
    store(x_, 1);
  }

  void store(Buffer<double>& slots, Count column) {
    for (Count i = 0; i < problem_.n(); ++i) slots[i] = solution_(i, column);
  }

  template <class Column>
  void write_column(Count variable, Column column) {
    const Count n = problem_.n();
    if (variable < n) {
      column.setZero();
      column(variable) = 1;
    } else if (variable < 2 * n) {
      column = -M_.col(variable - n);
    } else {
      for (Count i = 0; i < n; ++i) column(i) = -problem_.cover[i];
    }
  }

  void put(Count slot, Count variable) {
    id_[slot] = static_cast<double>(variable);
    problem_.slot_of[variable] = slot;
  }

  void place(Count slot, Count variable) {
    write_column(variable, B_.col(slot));
    put(slot, variable);
  }

  LoadedProblem problem_;
  Dense M_, B_, rhs_, solution_;
  Eigen::PartialPivLU<Dense> lu_;
  Buffer<double> x_, d_, ratio_, id_;
  Slots slots_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
