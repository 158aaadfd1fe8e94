#pragma once

#include <cstdint>
#include <vector>

#include "native/answer_test/exact_rows.h"

namespace lcpbench::enumeration {

/// A system of linear equations that takes its rows one by one, exactly, by fraction-free elimination: every entry is a
/// determinant of the data, every division exact. O(rank columns) operations per row. Nothing but reserve() and load()
/// allocate. [Bareiss 1968]
///
/// The unknowns are some z_j, the equations M_i z = -q_i. All numbers have the length that Hadamard's inequality grants
/// to a determinant of the rows so far.
class System {
 public:
  /// Room for any problem of that order. Allocates.
  void reserve(Index n);

  /// @param rows must stay as they are until the next load. Allocates room for n (n + 1) determinants of all rows,
  /// where there is none.
  void load(const Rows& rows);

  /// Begins anew, without equations. @param columns the unknowns; must stay as they are while the system is used
  void start(const std::vector<Index>& columns);

  enum class Row { kIndependent, kDependent, kInconsistent };

  /// Takes in an equation; only independent ones stay. @pre not full_rank(), and `row` is not in the system
  Row add(Index row);

  /// Forgets the last independent equation.
  void remove_last() { --rank_; }

  bool full_rank() const { return rank_ == columns_->size(); }

  /// Computes what follows. @pre full_rank()
  void solve();

  /// Unknown `column`, as numerator over the common denominator, which is positive. Of the last solve().
  ConstInteger numerator(std::size_t column) const { return {&numerators_[column * stride_], width_}; }
  ConstInteger denominator() const { return {denominator_.data(), width_}; }

  /// Whether M_row z + q_row < 0 in the last solve().
  bool is_violated(Index row);

  /// Unknown `column` of the last solve(), rounded once to the nearest double.
  double nearest(std::size_t column);

 private:
  struct Step {
    std::size_t pivot_column = 0;
    std::uint32_t eliminated = 0;  // bit j: column j is the pivot column of this row or of one before
    std::size_t bits = 0;          // of determinants of the rows up to this one
    ExactDivisor pivot;
  };

  std::size_t bits_before(std::size_t r) const { return r == 0 ? 0 : steps_[r - 1].bits; }
  const ExactDivisor& pivot_before(std::size_t r) const { return r == 0 ? one_ : steps_[r - 1].pivot; }
  bool is_eliminated(std::size_t column, std::size_t rank) const {
    return rank > 0 && (steps_[rank - 1].eliminated >> column & 1U) != 0;
  }
  void eliminate(std::size_t r, std::size_t bits);

  /// Entry of the rows that are kept, and, r = rank_, of the one that is being added. `column` may be the right-hand
  /// side's.
  Integer entry(std::size_t r, std::size_t column, std::size_t width) {
    return {&entries_[(r * (columns_->size() + 1) + column) * stride_], width};
  }
  Integer entry(std::size_t r, std::size_t column) { return entry(r, column, limbs_for(steps_[r].bits)); }

  /// Zero, of so many limbs.
  Integer cleared_sum(std::size_t limbs);

  const Rows* rows_ = nullptr;
  const std::vector<Index>* columns_ = nullptr;
  std::size_t rank_ = 0;
  std::size_t stride_ = 0;  // limbs of the longest determinant
  std::vector<Limb> entries_;
  std::vector<Step> steps_;  // rank_ in use; row r's entries in the pivot columns of the rows before count as zero
  ExactDivisor one_;

  std::size_t width_ = 0;  // of numerators and denominator
  std::vector<Limb> numerators_, denominator_, factor_, sum_;
};

}  // namespace lcpbench::enumeration
