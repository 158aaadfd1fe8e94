#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/paper/grids.h"

namespace lcpbench::paper {

/// What an option of a set off its default does to a solver's rates, against the same set at its defaults.
struct ReadingEffect {
  const Grid* reading = nullptr;
  const Grid* at_default = nullptr;
  Measure measure = Measure::kCriterion;
  GridRange with;
  GridRange without;
};

/// Every sweep on a set with options off their defaults, where the store has the same sweep at the defaults. Grids with
/// refusals are left out.
std::vector<ReadingEffect> reading_effects(const std::vector<Grid>& grids);

/// Margin beyond the interval of the difference within which a published rate counts as reproduced.
inline constexpr double kReproductionMargin = 0.01;

/// Half-width of an interval of the difference beyond which there were too few trials to tell.
inline constexpr double kReproductionWidth = 0.02;

/// What a comparison with a published number says.
enum class Agreement {
  kReproduced,    ///< the interval of the difference comes within kReproductionMargin of 0
  kDiffers,       ///< it does not
  kTooFewTrials,  ///< its half-width exceeds kReproductionWidth, wherever it lies
  kRefused        ///< the solver refused some of the problems
};
/// "reproduced", "differs", "too few trials", "refused".
const char* name_of(Agreement agreement);

/// One published number against ours by the paper's criterion: of claimed answers, with rules=2012 of any answer.
struct Reproduction {
  const Grid* grid = nullptr;
  Family family = Family::kLemke;
  const char* statistic = "";  ///< "worst", "average", "best"
  double published = 0;
  double ours = 0;
  Interval difference{};  ///< ours less the published, 95 %: both are samples
  Agreement agreement = Agreement::kTooFewTrials;
  std::string explanation;  ///< what is known of it, "" for nothing

  bool decided() const { return agreement == Agreement::kReproduced || agreement == Agreement::kDiffers; }
};

/// Every published worst, average and best that the store has a counterpart of.
std::vector<Reproduction> reproductions(const std::vector<Grid>& grids);

nlohmann::ordered_json readings_json(const Summary& summary, const std::vector<ReadingEffect>& effects);
nlohmann::ordered_json readings_example();
nlohmann::ordered_json reproductions_json(const Summary& summary, const std::vector<Reproduction>& rows);
nlohmann::ordered_json reproductions_example();

}  // namespace lcpbench::paper
