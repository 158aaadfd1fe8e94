#include "study/report/figures.h"

namespace lcpbench::report {

std::vector<const Cell*> drawn_cells(const Summary& summary, std::size_t set) {
  std::vector<const Cell*> cells;
  for (const Cell& cell : summary.cells) {
    if (cell.set == set && summary.solvers[cell.solver].sweep.empty() && !cell.refused()) cells.push_back(&cell);
  }
  return cells;
}

}  // namespace lcpbench::report
