#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/islands.h"

namespace lcpbench {

/// The rows of each island, ascending: RowIslands the other way round.
class IslandRows {
 public:
  explicit IslandRows(const RowIslands& islands);

  std::size_t count() const { return begin_.size() - 1; }
  std::span<const std::size_t> rows(std::size_t island) const {
    return std::span(rows_).subspan(begin_[island], begin_[island + 1] - begin_[island]);
  }

 private:
  std::vector<std::size_t> begin_;
  std::vector<std::size_t> rows_;
};

}  // namespace lcpbench
