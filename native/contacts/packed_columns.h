#pragma once

#include <cstddef>
#include <vector>

#include "core/types.h"

namespace lcpbench {

/// The columns of a matrix, each stored as a few runs of consecutive entries: a dense column is one run, the column of
/// a contact between two bodies a few short ones. Indices are not checked.
class PackedColumns {
 public:
  Index cols() const { return static_cast<Index>(begin_.size()) - 1; }
  std::size_t nonzeros() const { return values_.size(); }

  /// Takes memory for runs of three entries on average; shorter ones may make add_run allocate.
  void reserve(Index columns, std::size_t entries) {
    begin_.reserve(static_cast<std::size_t>(columns) + 1);
    runs_.reserve(static_cast<std::size_t>(columns) + entries / 3);
    values_.reserve(entries);
  }

  /// Removes all columns and keeps the memory.
  void clear() {
    begin_.assign(1, 0);
    runs_.clear();
    values_.clear();
  }

  /// Appends a column without entries; add_run fills it.
  void add_column() { begin_.push_back(runs_.size()); }

  /// Appends a run to the last column: its entries from `first_row` on. @pre add_column() was called
  void add_run(Index first_row, const Eigen::Ref<const Vector>& entries) {
    runs_.push_back({first_row, entries.size(), values_.size()});
    values_.insert(values_.end(), entries.data(), entries.data() + entries.size());
    begin_.back() = runs_.size();
  }

  using Entries = Eigen::Map<const Vector>;

  /// visit(first row, entries) for each run of the column.
  template <class Visit>
  void for_each_run(Index column, Visit&& visit) const {
    const auto c = static_cast<std::size_t>(column);
    for (std::size_t r = begin_[c]; r < begin_[c + 1]; ++r) {
      visit(runs_[r].first_row, Entries(values_.data() + runs_[r].first_value, runs_[r].size));
    }
  }

  /// The scalar product of the column and x.
  double dot(Index column, const Vector& x) const {
    double sum = 0;
    for_each_run(column, [&](Index row, const Entries& run) { sum += run.dot(x.segment(row, run.size())); });
    return sum;
  }

  /// The same of their absolute values.
  double dot_magnitudes(Index column, const Vector& x) const {
    double sum = 0;
    for_each_run(column, [&](Index row, const Entries& run) {
      sum += run.cwiseAbs().dot(x.segment(row, run.size()).cwiseAbs());
    });
    return sum;
  }

  Index entries(Index column) const {
    Index count = 0;
    for_each_run(column, [&](Index, const Entries& run) { count += run.size(); });
    return count;
  }

  /// x += factor * column. O(entries of the column)
  void add_to(Vector& x, Index column, double factor) const {
    for_each_run(column, [&](Index row, const Entries& run) { x.segment(row, run.size()) += factor * run; });
  }

 private:
  struct Run {
    Index first_row;
    Index size;
    std::size_t first_value;
  };

  std::vector<std::size_t> begin_{0};  // cols + 1 offsets into runs_
  std::vector<Run> runs_;
  std::vector<double> values_;
};

}  // namespace lcpbench
