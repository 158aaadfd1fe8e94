#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/summary/summary.h"

// Which model of friction a captured step needs, by the answers that a store has: as `lcpbench solve
// --max-velocity-error` climbs, but on whole steps instead of island by island, and with the cone solved in full where
// the store lacks `cone_ipm{cone=true,error=0.001}`.

namespace lcpbench::report {

/// The error against the round cone that the models are chosen for [m/s].
inline constexpr double kStatedModelError = 1e-3;

/// One captured step with friction.
struct ModelChoice {
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::size_t set = 0;  ///< index into Summary::sets
  std::int64_t trial = 0;
  std::size_t solver = kNone;  ///< index into Summary::solvers: the first that meets the error, else the most accurate
  double error_m_per_s = kNoNumber;  ///< of its answer: the measured residual of the round cone's conditions
  bool met = false;                  ///< that is at most kStatedModelError
  double time_s = kNoNumber;         ///< of that solver
  double spent_s = 0;                ///< of it and those tried before it
  double coarsest_s = kNoNumber;     ///< of the first model
};

struct ModelChoices {
  std::vector<std::size_t> solvers;  ///< from the coarsest model on: what the store has of the models that are climbed
  std::vector<ModelChoice> steps;
  std::int64_t unknown = 0;  ///< steps of sets with friction of which no answer's error is known

  std::int64_t met() const;
  std::int64_t chosen(std::size_t solver) const;  ///< steps that meet the error by it
};

/// Of the captured steps. Without steps where the store lacks the first model, or all finer ones. O(answers log
/// answers)
ModelChoices model_choices(const Summary& summary);

/// One record for each step.
nlohmann::ordered_json model_choice_json(const Summary& summary, const std::vector<ModelChoice>& steps);

/// Shares and misses, for summary.json.
nlohmann::ordered_json model_choices_json(const Summary& summary, const ModelChoices& choices);

/// The part of the scenes' section: HTML, "" without steps.
std::string model_choice_part(const Summary& summary, const ModelChoices& choices);

}  // namespace lcpbench::report
