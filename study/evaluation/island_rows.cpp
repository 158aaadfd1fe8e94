#include "study/evaluation/island_rows.h"

namespace lcpbench {

IslandRows::IslandRows(const RowIslands& islands)
    : begin_(static_cast<std::size_t>(islands.count) + 1, 0), rows_(islands.of_row.size()) {
  for (const Index island : islands.of_row) ++begin_[static_cast<std::size_t>(island) + 1];
  for (std::size_t island = 0; island < count(); ++island) begin_[island + 1] += begin_[island];
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    rows_[next[static_cast<std::size_t>(islands.of_row[row])]++] = row;
  }
}

}  // namespace lcpbench
