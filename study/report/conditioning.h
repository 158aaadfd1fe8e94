#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study/report/speed_error.h"
#include "study/report/summary.h"

namespace lcpbench::report {

/// What a set's name says of the inertia's condition number.
struct ConditionDial {
  std::string family;      ///< the name with "*" for the number: "paper/monotone/exp5-*", "paper/.../exp2{condition=*}"
  double condition = 0;    ///< 1 or more
  bool by_option = false;  ///< an option of the set, not one of the paper's experiments
};

/// nullopt where the name asks for no condition number, or the number has another meaning (`hard/`, `planted/`).
std::optional<ConditionDial> condition_dial(const std::string& set);

/// "1e6"
std::string condition_text(double condition);

/// Sets that differ in the inertia's condition number alone, and one error measure for all of them.
struct Conditioning {
  std::string family;
  ErrorMeasure measure = ErrorMeasure::kNone;
  std::vector<double> conditions;    ///< ascending
  std::vector<SpeedError> steps;     ///< by condition, all with `measure`
  std::vector<std::size_t> solvers;  ///< those with a point at two conditions or more; indices into Summary::solvers
};

/// The families of two conditions or more, in the order of their first sets.
std::vector<Conditioning> conditioning(const Summary& summary);

/// Speed against error, set by set and along the dials of conditioning. Points into the summary.
struct SpeedErrorStudy {
  std::vector<SpeedError> sets;
  std::vector<Conditioning> families;

  /// The set is a step along an option `condition`, whose family shows it.
  bool is_step(const Summary& summary, std::size_t set) const;
};

SpeedErrorStudy speed_error_study(const Summary& summary);

/// conditioning.csv: one record for each family, condition and solver.
nlohmann::ordered_json conditioning_json(const Summary& summary, const std::vector<Conditioning>& families);

}  // namespace lcpbench::report
