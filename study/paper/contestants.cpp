#include "study/paper/contestants.h"

#include <algorithm>

namespace lcpbench::paper {

const char* words_for(Measure measure) { return measure == Measure::kCriterion ? "paper’s criterion" : "our verdict"; }

bool compared_with_paper(const Grid& grid, Kind kind) {
  return grid.problems.kind == kind && grid.problems.other_readings().empty();
}

std::string reading_words(const Experiment& experiment, const std::string& reading) {
  return experiment.redundant ? reading : kAbsent;
}

std::vector<Contestant> contestants(const std::vector<Grid>& grids, Kind kind, const Picks& picks,
                                    const std::vector<Family>& published) {
  std::vector<Contestant> ours;
  for (const Grid& grid : grids) {
    if (!compared_with_paper(grid, kind) || !picks(*grid.problems.experiment)) continue;
    const bool known =
        std::any_of(ours.begin(), ours.end(), [&](const Contestant& c) { return c.label == grid.label; });
    if (!known) ours.push_back({family_of(grid.solver), grid.label});
  }
  std::stable_sort(ours.begin(), ours.end(),
                   [](const Contestant& a, const Contestant& b) { return natural_less(a.label, b.label); });
  std::vector<Contestant> ordered;
  for (const Family family : published) {
    const std::size_t before = ordered.size();
    for (const Contestant& contestant : ours) {
      if (contestant.family == family) ordered.push_back(contestant);
    }
    if (ordered.size() == before) ordered.push_back({family, ""});
  }
  for (const Contestant& contestant : ours) {
    const bool placed =
        contestant.family && std::find(published.begin(), published.end(), *contestant.family) != published.end();
    if (!placed) ordered.push_back(contestant);
  }
  return ordered;
}

std::vector<Family> published_families(Kind kind) {
  std::vector<Family> families;
  for (const Family family : kFamilies) {
    if (published_rate(kind, "exp1", family)) families.push_back(family);
  }
  return families;
}

Entry refused_entry(const Grid& grid) {
  const std::string text = grid.refusal();
  const std::size_t colon = text.find(": ");
  return {text.substr(0, colon), colon == std::string::npos ? "" : text.substr(colon + 2)};
}

std::string why_no_numbers(const Summary& summary, const Contestant& contestant, const Grid* grid) {
  if (grid != nullptr) return grid->refusal();
  return contestant.label.empty() ? why_not_run(summary, *contestant.family) : "not run";
}

bool is_experiment_six(const Experiment& experiment) { return experiment.regularized; }

}  // namespace lcpbench::paper
