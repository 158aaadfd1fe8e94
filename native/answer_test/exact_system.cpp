#include "native/answer_test/exact_system.h"

#include <algorithm>

namespace lcpbench::enumeration {

void System::reserve(Index order) {
  const auto n = static_cast<std::size_t>(order);
  const std::size_t stride = n * Rows::kMostLimbs + 1;
  entries_.reserve(n * (n + 1) * stride);
  numerators_.reserve(n * stride);
  denominator_.reserve(stride);
  factor_.reserve(stride + 2);
  sum_.reserve(2 * stride + 1);
  steps_.resize(n);
  for (Step& step : steps_) step.pivot.reserve(stride);
  one_.reserve(1);
}

void System::load(const Rows& rows) {
  rows_ = &rows;
  const auto n = static_cast<std::size_t>(rows.size());
  stride_ = limbs_for(rows.bits_of_all());
  entries_.resize(n * (n + 1) * stride_);
  numerators_.resize(n * stride_);
  denominator_.resize(stride_);
  factor_.resize(stride_ + 2);
  sum_.resize(2 * stride_ + 1);  // a dividend, of which a whole pivot may be trailing zeros
  steps_.resize(n);
  for (Step& step : steps_) step.pivot.reserve(stride_);
  constexpr Limb kOne = 1;
  one_.reserve(1);
  one_.set({&kOne, 1});
}

void System::start(const std::vector<Index>& columns) {
  columns_ = &columns;
  rank_ = 0;
}

Integer System::cleared_sum(std::size_t limbs) {
  std::fill_n(sum_.begin(), limbs, 0);
  return {sum_.data(), limbs};
}

/// Subtracts row r from the one that is being added. @param bits of that one's data
void System::eliminate(std::size_t r, std::size_t bits) {
  const std::size_t before = limbs_for(bits_before(r) + bits);
  const std::size_t after = limbs_for(steps_[r].bits + bits);
  const std::size_t pivot_column = steps_[r].pivot_column;
  const Integer factor(factor_.data(), before);
  assign(factor, entry(rank_, pivot_column, before));
  const ExactDivisor& divisor = pivot_before(r);
  for (std::size_t j = 0; j <= columns_->size(); ++j) {
    if (is_eliminated(j, r + 1)) continue;
    const Integer sum = cleared_sum(divisor.dividend_limbs(after));
    add_product(sum, entry(r, pivot_column), entry(rank_, j, before));
    subtract_product(sum, entry(r, j), factor);
    divisor.divide(sum, entry(rank_, j, after));
  }
}

System::Row System::add(Index row) {
  const std::size_t columns = columns_->size();
  const std::size_t bits = rows_->bits(row);
  for (std::size_t j = 0; j <= columns; ++j) {
    const Index column = j < columns ? (*columns_)[j] : rows_->size();
    assign(entry(rank_, j, limbs_for(bits)), rows_->entry(row, column));
  }
  for (std::size_t r = 0; r < rank_; ++r) eliminate(r, bits);
  const std::size_t all_bits = bits_before(rank_) + bits;
  for (std::size_t j = 0; j < columns; ++j) {
    if (is_eliminated(j, rank_) || is_zero(entry(rank_, j, limbs_for(all_bits)))) continue;
    Step& step = steps_[rank_];
    step.pivot_column = j;
    step.eliminated = (rank_ > 0 ? steps_[rank_ - 1].eliminated : 0U) | 1U << j;
    step.bits = all_bits;
    step.pivot.set(entry(rank_, j));
    ++rank_;
    return Row::kIndependent;
  }
  return is_zero(entry(rank_, columns, limbs_for(all_bits))) ? Row::kDependent : Row::kInconsistent;
}

void System::solve() {
  const std::size_t columns = columns_->size();
  width_ = limbs_for(bits_before(rank_));
  const Integer denominator(denominator_.data(), width_);
  constexpr Limb kOne = 1;
  assign(denominator, rank_ == 0 ? ConstInteger(&kOne, 1) : entry(rank_ - 1, steps_[rank_ - 1].pivot_column));
  for (std::size_t r = rank_; r-- > 0;) {
    const ExactDivisor& pivot = steps_[r].pivot;
    const Integer sum = cleared_sum(pivot.dividend_limbs(width_));
    add_product(sum, denominator, entry(r, columns));
    for (std::size_t later = r + 1; later < rank_; ++later) {
      const std::size_t column = steps_[later].pivot_column;
      subtract_product(sum, numerator(column), entry(r, column));
    }
    pivot.divide(sum, {&numerators_[steps_[r].pivot_column * stride_], width_});
  }
  if (!is_negative(denominator)) return;
  negate(denominator);
  for (std::size_t j = 0; j < columns; ++j) negate({&numerators_[j * stride_], width_});
}

bool System::is_violated(Index row) {
  const Integer w = cleared_sum(limbs_for(bits_before(rank_) + rows_->bits(row)));  // w times the denominator
  subtract_product(w, denominator(), rows_->entry(row, rows_->size()));
  for (std::size_t j = 0; j < columns_->size(); ++j) {
    add_product(w, numerator(j), rows_->entry(row, (*columns_)[j]));
  }
  return is_negative(w);
}

double System::nearest(std::size_t column) {
  const Integer above(factor_.data(), width_ + 2);
  const Integer below(sum_.data(), width_ + 2);
  assign(above, numerator(column));
  assign(below, denominator());
  return nearest_double(above, below);
}

}  // namespace lcpbench::enumeration
