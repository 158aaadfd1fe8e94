#pragma once

#include <map>
#include <string>
#include <vector>

#include "study/report/replay_page.h"
#include "study/report/decision.h"
#include "study/report/figures.h"
#include "study/report/model_choice.h"
#include "study/report/model_error.h"
#include "study/report/paper.h"
#include "study/report/regret.h"
#include "study/report/solver_comparison.h"
#include "study/summary/summary.h"
#include "study/report/velocity_spread.h"

namespace lcpbench::report {

/// Pictures of a report by index of their set, unless told.
struct Figures {
  std::map<std::size_t, Figure> speed_error;
  std::map<std::size_t, Figure> conditioning;  ///< by index of their family
  std::map<std::size_t, Figure> distribution;
  std::map<std::size_t, Figure> time_ecdf;
  std::map<std::size_t, Figure> error_ecdf;
  std::map<std::size_t, Figure> scene;        ///< by the first set of a scene's family that has a picture
  std::map<std::size_t, Figure> model_error;  ///< 0: of all scenes
};

/// All that a report says of a store. Its parts point into its summary.
struct Report {
  Summary summary;
  std::vector<Situation> situations;
  std::vector<SetComparison> comparisons;
  SpeedErrorStudy speed_error;
  std::vector<VelocitySpread> velocity_spreads;
  ModelErrors model_errors;
  ModelChoices model_choices;
  RegretStudy regret;
  std::vector<ReplayPictures> replays;
  Figures figures;
  PaperStudy paper;
};

/// The whole of report.html: self-contained, readable without scripts, every text of the store escaped.
std::string html_page(const Report& report);

/// A picture in a box that scrolls; "" where there is none.
std::string figure_html(const std::map<std::size_t, Figure>& figures, std::size_t index);

// The sections behind the first screen, in their order on the page: each an HTML element with its anchor, its details
// folded; "" where the store has nothing for it. To add a section, declare its function here, define it in a source
// file, and add its row to kSections in page.cpp.

std::string scenes_section(const Report& report);
std::string speed_error_section(const Report& report);
std::string comparison_section(const Report& report);
std::string regret_section(const Report& report);
std::string hard_section(const Report& report);
std::string claims_section(const Report& report);
std::string times_section(const Report& report);
std::string provenance_section(const Report& report);
std::string definitions_section(const Report& report);
std::string limits_section(const Report& report);

/// What a run recorded under a name, as text; "not recorded" where it did not.
std::string recorded_value(const RunSummary& run, const char* name);
/// The distinct ones of all runs, in the order of their first use.
std::vector<std::string> recorded_values(const Summary& summary, const char* name);

/// Where the page's script finds the factor of a solver on a set, when the reader chooses another reference: the value
/// of data-factor.
std::string factor_key(std::size_t set, std::size_t solver);

}  // namespace lcpbench::report
