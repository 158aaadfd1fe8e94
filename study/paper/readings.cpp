#include "study/paper/readings.h"

#include <array>
#include <cmath>
#include <utility>

#include "study/paper/tables.h"

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

const Grid* default_of(const std::vector<Grid>& grids, const Grid& reading) {
  for (const Grid& grid : grids) {
    if (grid.problems.options.empty() && grid.problems.kind == reading.problems.kind &&
        grid.problems.experiment == reading.problems.experiment && grid.label == reading.label) {
      return &grid;
    }
  }
  return nullptr;
}

/// What is known of rates that no reading reproduces (docs/explanation/paper-study.md).
std::string known_explanation(Kind kind, const Experiment& experiment, Family family, const std::string& solver) {
  if (follows_rules_2012(solver)) return "named in docs/explanation/paper-study.md: which rule explains which row";
  if (family == Family::kPath) return "today's PATH is another version than that of 2012, on another machine";
  if (family == Family::kInteriorPoint)
    return "rules=2012 gives the IP rows of Experiments 1 and 3, and with combination those of 2, 4 and 5 at 1e5: "
           "docs/explanation/paper-study.md";
  const bool reduced = experiment.name == "exp3" || experiment.name == "exp4";
  if (kind == Kind::kCopositive && reduced)
    return "no reading of the text that was tried gives these rows: docs/explanation/paper-study.md";
  return "what was tried: docs/explanation/paper-study.md";
}

Agreement agreement_of(const Grid& grid, const Interval& gap) {
  if (grid.refused() > 0) return Agreement::kRefused;
  if (!(gap.high - gap.low <= 2 * kReproductionWidth)) return Agreement::kTooFewTrials;
  const bool near = gap.low <= kReproductionMargin && gap.high >= -kReproductionMargin;
  return near ? Agreement::kReproduced : Agreement::kDiffers;
}

Reproduction reproduction(const Grid& grid, Family family, const char* statistic, double published,
                          const Proportion& ours) {
  const LinearCombination gap = difference(ours, {published * kPublishedTrials, kPublishedTrials});
  Reproduction row{
      &grid,         family, statistic, published, ours.value(), gap.interval(), agreement_of(grid, gap.interval()),
      grid.refusal()};
  if (row.agreement == Agreement::kDiffers) {
    row.explanation = known_explanation(grid.problems.kind, *grid.problems.experiment, family, grid.solver);
  }
  return row;
}

Json difference_json(const Proportion& with, const Proportion& without) {
  const LinearCombination change = difference(with, without);
  return {{"default", without.value()},
          {"reading", with.value()},
          {"difference", change.value()},
          {"low", change.interval().low},
          {"high", change.interval().high}};
}

Json effect_record(const std::string& set, const std::string& solver, const ReadingEffect& effect) {
  return {{"set", set},
          {"solver", solver},
          {"solved_by", name_of(effect.measure)},
          {"worst", difference_json(effect.with.worst, effect.without.worst)},
          {"average", difference_json(effect.with.average, effect.without.average)},
          {"best", difference_json(effect.with.best, effect.without.best)},
          {"held_out", difference_json(effect.with.held_out, effect.without.held_out)}};
}

Json reproduction_record(const std::string& set, const std::string& solver, const Reproduction& row) {
  return {{"set", set},
          {"paper_solver", name_of(row.family)},
          {"solver", solver},
          {"statistic", row.statistic},
          {"published", row.published},
          {"ours", row.ours},
          {"low", row.difference.low},
          {"high", row.difference.high},
          {"result", name_of(row.agreement)},
          {"explanation", row.explanation}};
}

}  // namespace

const char* name_of(Agreement agreement) {
  switch (agreement) {
    case Agreement::kReproduced: return "reproduced";
    case Agreement::kDiffers: return "differs";
    case Agreement::kTooFewTrials: return "too few trials";
    case Agreement::kRefused: return "refused";
  }
  return "";
}

std::vector<ReadingEffect> reading_effects(const std::vector<Grid>& grids) {
  std::vector<ReadingEffect> effects;
  for (const Grid& grid : grids) {
    if (grid.problems.options.empty()) continue;
    const Grid* at_default = default_of(grids, grid);
    if (at_default == nullptr || grid.refused() > 0 || at_default->refused() > 0) continue;
    for (const Measure measure : kCounts) {
      effects.push_back({&grid, at_default, measure, range_of(grid, measure), range_of(*at_default, measure)});
    }
  }
  return effects;
}

std::vector<Reproduction> reproductions(const std::vector<Grid>& grids) {
  std::vector<Reproduction> rows;
  for (const Grid& grid : grids) {
    const std::optional<Family> family = family_of(grid.solver);
    if (!family || !grid.problems.other_readings().empty()) continue;
    const auto published = published_rate(grid.problems.kind, grid.problems.experiment->name, *family);
    if (!published) continue;
    // By its rules of 2012 a solver is counted as its authors counted it.
    const Measure counted = follows_rules_2012(grid.solver) ? Measure::kCriterionAny : Measure::kCriterion;
    const GridRange ours = range_of(grid, counted);
    if (ours.best_cell == nullptr) continue;
    const std::array<std::tuple<const char*, double, const Proportion*>, 3> statistics{
        {{"worst", published->worst, &ours.worst},
         {"average", published->average, &ours.average},
         {"best", published->best, &ours.best}}};
    for (const auto& [name, value, share] : statistics) {
      if (!std::isnan(value)) rows.push_back(reproduction(grid, *family, name, value, *share));
    }
  }
  return rows;
}

Json readings_json(const Summary& summary, const std::vector<ReadingEffect>& effects) {
  Json records = Json::array();
  for (const ReadingEffect& effect : effects) {
    records.push_back(effect_record(summary.sets[effect.reading->set].name, effect.reading->label, effect));
  }
  return records;
}

Json readings_example() { return effect_record("", "", {}); }

Json reproductions_json(const Summary& summary, const std::vector<Reproduction>& rows) {
  Json records = Json::array();
  for (const Reproduction& row : rows) {
    records.push_back(reproduction_record(summary.sets[row.grid->set].name, row.grid->label, row));
  }
  return records;
}

Json reproductions_example() { return reproduction_record("", "", {}); }

}  // namespace lcpbench::paper
