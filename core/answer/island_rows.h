#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/islands.h"

namespace lcpbench {

/// The rows of each island, ascending: RowIslands the other way round.
class IslandRows {
 public:
  explicit IslandRows(const RowIslands& islands)
      : begin_(static_cast<std::size_t>(islands.count) + 1, 0), rows_(islands.of_row.size()) {
    for (const Index island : islands.of_row) ++begin_[static_cast<std::size_t>(island) + 1];
    for (std::size_t island = 0; island < count(); ++island) begin_[island + 1] += begin_[island];
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      rows_[next[static_cast<std::size_t>(islands.of_row[row])]++] = row;
    }
  }

  std::size_t count() const { return begin_.size() - 1; }
  std::span<const std::size_t> rows(std::size_t island) const {
    return std::span(rows_).subspan(begin_[island], begin_[island + 1] - begin_[island]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::size_t> rows_;
};

}  // namespace lcpbench
