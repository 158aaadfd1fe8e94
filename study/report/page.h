#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "study/report/solver_comparison.h"
#include "study/report/decision.h"
#include "study/report/figures.h"
#include "study/report/paper.h"
#include "study/report/summary.h"

namespace lcpbench::report {

/// Pictures of a report by index of their set, unless told.
struct Figures {
  std::map<std::size_t, Figure> speed_error;
  std::map<std::size_t, Figure> conditioning;  ///< by index of their family
  std::map<std::size_t, Figure> distribution;
  std::map<std::size_t, Figure> time_ecdf;
  std::map<std::size_t, Figure> error_ecdf;
};

/// A picture in a box that scrolls; "" where there is none.
std::string figure_html(const std::map<std::size_t, Figure>& figures, std::size_t index);

/// The whole of report.html: self-contained, readable without scripts, every text of the store escaped.
std::string html_page(const Summary& summary, const std::vector<Situation>& situations,
                      const std::vector<SetComparison>& comparisons, const SpeedErrorStudy& speed_error,
                      const Figures& figures, const PaperStudy& paper);

}  // namespace lcpbench::report
