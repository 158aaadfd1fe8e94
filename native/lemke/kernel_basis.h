#pragma once

#include <initializer_list>

#include "native/kernels/pack.h"
#include "native/lemke/column_sum.h"
#include "native/lemke/loaded_problem.h"
#include "native/lemke/ratio_test.h"
#include "native/lemke/small_system.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The basis as its kernel: rows whose w is nonbasic against columns of the basic z and the artificial variable, in the
/// signs of w = q + M z + cover z0. Everything else of the basis is a unit column and needs no factoring:
///
///     d_kernel = A^-1 M_kernel,e    (entering z_e)    or   -A^-1 e_r   (entering w of kernel row r)
///     d_w      = M_w,kernel d_kernel - M_w,e                M_w,kernel d_kernel
///     x_kernel = -A^-1 q_kernel,    x_w = q_w + M_w,kernel x_kernel
///
/// Slots: w of the dense rows, w of the cone rows, kernel columns, each padded. Slots of nonbasic w hold zeros.
class KernelBasis {
 public:
  void load(const Input& input) {
    problem_.load(input);
    const Count n = problem_.n();
    cone_slots_ = problem_.M.stride();
    column_slots_ = cone_slots_ + P::padded(problem_.M.cones());
    const Count most_slots = column_slots_ + P::padded(n);
    for (Buffer<double>* slots : {&x_, &d_, &ratio_}) slots->fill(most_slots, 0);
    id_.fill(most_slots, kInfinity<double>);
    order_ = 0;
    q_.fill(column_slots_, 0);
    cover_.fill(column_slots_, 0);
    for (Count i = 0; i < n; ++i) {
      q_[row_slot(i)] = problem_.q[i];
      cover_[row_slot(i)] = problem_.cover[i];
    }
    rows_.resize(n);
    columns_.resize(n);
    entering_column_.resize(n);
    terms_.resize(n + 1);
    A_.resize(n * P::padded(n));
    system_.reserve(n);
    slots_ = {column_slots_, x_.data(), d_.data(), ratio_.data(), id_.data()};
  }

  const LoadedProblem& problem() const { return problem_; }
  const Slots& slots() const { return slots_; }
  Count slot_of(Count variable) const { return problem_.slot_of[variable]; }

  /// Brings the artificial variable in for w of `row`.
  void start(Count row) {
    shrink(0);
    const Count n = problem_.n();
    for (Count i = 0; i < column_slots_; ++i) x_[i] = 0;  // an overflow leaves NaN in the padding
    for (Count i = 0; i < n; ++i) {
      const Count slot = row_slot(i);
      id_[slot] = static_cast<double>(i);
      problem_.slot_of[i] = slot;
    }
    stride_ = P::padded(kFirstStride < n ? kFirstStride : n);
    add_column(problem_.artificial());
    add_row(row);
  }

  /// d for the entering variable, and x anew. False when the kernel is singular.
  bool solve(Count entering) { return solve_sides<true>(entering); }

  /// x of the present basis.
  bool resolve() { return solve_sides<false>(problem_.artificial()); }

  /// @pre solve(entering) was called last
  void exchange(Count entering, Count leaving) {
    const Count n = problem_.n();
    if (entering < n) {
      const Count row = kernel_row(entering);
      if (leaving < n) {
        replace_row(row, leaving);
      } else {
        remove(row, slot_of(leaving) - column_slots_);
      }
    } else if (leaving < n) {
      add_column(entering);
      add_row(leaving);
    } else {
      replace_column(slot_of(leaving) - column_slots_, entering);
    }
  }

 private:
  using P = Packed<double>;
  static constexpr Count kFirstStride = 64;

  Count row_slot(Count row) const { return row < problem_.M.dense() ? row : cone_slots_ + row - problem_.M.dense(); }

  /// Position in the kernel of the row whose w is nonbasic.
  Count kernel_row(Count variable) const {
    Count row = 0;
    while (rows_[row] != variable) ++row;
    return row;
  }

  /// Entry of M, or of the covering vector, in the column of a basic variable that is no w.
  double entry(Count row, Count variable) {
    if (variable == problem_.artificial()) return problem_.cover[row];
    return problem_.M.entry(row, variable - problem_.n());
  }

  template <bool kDirection>
  bool solve_sides(Count entering) {
    write_system<kDirection>(entering);
    if (!system_.solve(d_.data() + column_slots_, x_.data() + column_slots_)) return false;
    extend(entering);
    return true;
  }

  template <bool kDirection>
  void write_system(Count entering) {
    if constexpr (kDirection) write_entering_column(entering);
    system_.begin(order_);
    for (Count r = 0; r < order_; ++r) {
      const double direction = kDirection ? entering_column_[r] : 0;
      system_.write_row(r, A_.data() + r * stride_, direction, -problem_.q[rows_[r]]);
    }
  }

  void write_entering_column(Count entering) {
    const bool is_row = entering < problem_.n();
    for (Count r = 0; r < order_; ++r) {
      entering_column_[r] = is_row ? (rows_[r] == entering ? -1 : 0) : entry(rows_[r], entering);
    }
  }

  /// From the kernel's d and x to those of the basic w.
  void extend(Count entering) {
    using Pack = P::Pack;
    for (Count i = 0; i < column_slots_; i += P::kWidth) {
      P::store(x_.data() + i, P::load(q_.data() + i));
      P::store(d_.data() + i, Pack{});
    }
    double* const sums[2] = {d_.data(), x_.data()};
    add_columns(entering, sums);
    clear_nonbasic(sums);
  }

  void add_columns(Count entering, double* const (&sums)[2]) {
    const Count n = problem_.n();
    Count terms = 0;
    for (Count c = 0; c < order_; ++c) {
      terms = add_column_to(sums, columns_[c], d_[column_slots_ + c], x_[column_slots_ + c], terms);
    }
    if (entering >= n && entering != problem_.artificial()) {
      terms = add_column_to(sums, entering, -1, 0, terms);
    }
    add_terms(terms_.data(), terms, cone_slots_, sums);
  }

  /// Adds the sparse part of one column at once and appends its dense part to the terms.
  Count add_column_to(double* const (&sums)[2], Count variable, double d, double x, Count terms) {
    const double factor[2] = {d, x};
    if (variable == problem_.artificial()) {
      // The covering vector is zero on cone rows, whose q is zero.
      terms_[terms] = {cover_.data(), {d, x}};
      return terms + 1;
    }
    const MatrixColumns& M = problem_.M;
    const Count j = variable - problem_.n();
    if (j >= M.dense()) {
      for (std::size_t s = 0; s < 2; ++s) {
        for (Count t = M.friction_first(j - M.dense()); t < M.friction_last(j - M.dense()); ++t) {
          sums[s][t] += factor[s];
        }
      }
      return terms;
    }
    if (const Count cone = M.cone(j); cone >= 0) {
      for (std::size_t s = 0; s < 2; ++s) sums[s][cone_slots_ + cone] += M.cone_coefficient(j) * factor[s];
    }
    terms_[terms] = {problem_.M.column(j), {d, x}};
    return terms + 1;
  }

  void clear_nonbasic(double* const (&sums)[2]) {
    for (Count r = 0; r < order_; ++r) {
      for (std::size_t s = 0; s < 2; ++s) sums[s][row_slot(rows_[r])] = 0;
    }
  }

  void add_column(Count variable) {
    if (order_ + 1 > stride_) widen();
    for (Count r = 0; r < order_; ++r) A_[r * stride_ + order_] = entering_column_[r];
    put_column_variable(order_, variable);
  }

  /// Completes add_column: the order grows here.
  void add_row(Count row) {
    rows_[order_] = row;
    ++order_;
    write_row(order_ - 1);
    clear_slot(row_slot(row));
    set_column_slots();
  }

  void replace_row(Count position, Count row) {
    rows_[position] = row;
    write_row(position);
    clear_slot(row_slot(row));
  }

  void replace_column(Count position, Count variable) {
    for (Count r = 0; r < order_; ++r) A_[r * stride_ + position] = entering_column_[r];
    put_column_variable(position, variable);
  }

  /// Removes a row and a column; the last ones take their places.
  void remove(Count row, Count column) {
    const Count last = order_ - 1;
    rows_[row] = rows_[last];
    for (Count c = 0; c < order_; ++c) A_[row * stride_ + c] = A_[last * stride_ + c];
    for (Count r = 0; r < last; ++r) A_[r * stride_ + column] = A_[r * stride_ + last];
    if (column != last) put_column_variable(column, columns_[last]);
    shrink(last);
    set_column_slots();
  }

  void write_row(Count position) {
    for (Count c = 0; c < order_; ++c) A_[position * stride_ + c] = entry(rows_[position], columns_[c]);
  }

  void put_column_variable(Count position, Count variable) {
    columns_[position] = variable;
    const Count slot = column_slots_ + position;
    problem_.slot_of[variable] = slot;
    id_[slot] = static_cast<double>(variable);
    x_[slot] = 0;  // an overflow leaves NaN
  }

  /// Leaves at most `order` columns. Clears the padding of the last pack too: an overflow leaves NaN in it, which a
  /// later path would find there once its basis grows again.
  void shrink(Count order) {
    for (Count end = P::padded(order_); end > order;) vacate_column_slot(--end);
    order_ = order < order_ ? order : order_;
  }

  void vacate_column_slot(Count position) {
    clear_slot(column_slots_ + position);
    id_[column_slots_ + position] = kInfinity<double>;
  }

  void clear_slot(Count slot) { x_[slot] = d_[slot] = 0; }

  void set_column_slots() { slots_.count = column_slots_ + P::padded(order_); }

  /// Doubles the room of A's rows, from the last row to the first since they move up in place.
  void widen() {
    const Count n = problem_.n();
    const Count wider = 2 * stride_ < P::padded(n) ? 2 * stride_ : P::padded(n);
    for (Count r = order_ - 1; r > 0; --r) {
      for (Count c = order_ - 1; c >= 0; --c) A_[r * wider + c] = A_[r * stride_ + c];
    }
    stride_ = wider;
  }

  LoadedProblem problem_;
  Count cone_slots_ = 0, column_slots_ = 0;
  Count order_ = 0, stride_ = 0;
  Buffer<Count> rows_, columns_;  ///< the kernel's rows (of M) and columns (variables)
  Buffer<double> A_;              ///< the kernel by rows, stride_ apart
  Buffer<double> entering_column_;
  Buffer<double> q_, cover_;  ///< by slots
  Buffer<double> x_, d_, ratio_, id_;
  Buffer<Term> terms_;
  SmallSystem system_;
  Slots slots_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
