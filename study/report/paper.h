#pragma once

#include <map>
#include <string>
#include <vector>

#include "study/paper/claims.h"
#include "study/paper/readings.h"
#include "study/paper/tables.h"
#include "study/report/figures.h"

namespace lcpbench::report {

/// One map with its picture.
struct DrawnMap {
  paper::ToleranceMap map;
  std::string file;  ///< below the report's folder
  Figure figure;
};

/// Everything that a report says of the paper's study. Points into the summary it was made from.
struct PaperStudy {
  std::vector<paper::Grid> grids;
  std::vector<paper::Table> tables;
  std::vector<paper::Claim> claims;
  std::vector<paper::ReadingEffect> readings;
  std::vector<paper::Reproduction> reproductions;
  std::vector<DrawnMap> maps;

  /// The store holds no sweep on a set of the paper: the report then has no page of it.
  bool empty() const { return grids.empty(); }
};

/// Computes the study and draws its maps. @param summary outlives the result.
PaperStudy paper_study(const Summary& summary);

/// The sections #paper-tables, #paper-claims, #paper-readings and #tolerance-maps of report.html; "" for an empty study.
std::string paper_sections(const Summary& summary, const PaperStudy& study);

/// The study's own files by their names below the report's folder: paper.md, tables/*.csv, figures/*.svg. None for an
/// empty study. Byte for byte the same for equal rows in the store.
std::map<std::string, std::string> paper_files(const Summary& summary, const PaperStudy& study);

}  // namespace lcpbench::report
