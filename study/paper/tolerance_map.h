#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/paper/grids.h"

namespace lcpbench::paper {

/// The shares solved over the two tolerances of Lemke's algorithm on one set.
struct ToleranceMap {
  const Grid* grid = nullptr;
  std::vector<double> pivot_tolerances;  ///< ascending: columns
  std::vector<double> zero_tolerances;   ///< ascending: rows
  std::vector<const Cell*> cells;        ///< [zero * columns + pivot]; nullptr where the grid has none

  const Cell* at(std::size_t pivot, std::size_t zero) const { return cells[zero * pivot_tolerances.size() + pivot]; }
};

/// One map per grid whose parameterisations have both tolerances, their own or those of a solver they wrap, and differ
/// in both. Where other settings vary too, the first cell at a pair of tolerances stands for it.
std::vector<ToleranceMap> tolerance_maps(const Summary& summary, const std::vector<Grid>& grids);

/// One record per map and cell, for tolerance-map.csv.
nlohmann::ordered_json tolerance_maps_json(const Summary& summary, const std::vector<ToleranceMap>& maps);
nlohmann::ordered_json tolerance_maps_example();

}  // namespace lcpbench::paper
