#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "study/report/reliability.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

/// What stands for the error of an answer. One set has one measure.
enum class ErrorMeasure {
  kNone,      ///< the set mixes contact problems and bare LCPs
  kForward,   ///< ||v+ - v*||_G / ||v||_G against the certified post-impact velocity v*, where it is the only one
  kResidual,  ///< relative velocity residual rho
  kBackward,  ///< row-norm backward error, bare LCPs
};

/// The name in tables: "forward_velocity", "velocity_residual_relative", "backward_row_norm", "".
const char* to_string(ErrorMeasure measure);

/// In words, for headings: "error ρ, relative velocity residual".
std::string measure_words(ErrorMeasure measure);

/// The best measure that a set allows: the forward error where the only velocity of at least half of its problems is
/// certified, else what the verdict is taken on.
ErrorMeasure best_measure(const SetSummary& set);

/// One solver at one setting (a rung of a precision ladder is a setting) on one set.
struct SpeedErrorPoint {
  const Cell* cell = nullptr;
  std::int64_t answers = 0;  ///< said solved
  std::int64_t known = 0;    ///< of those the ones whose error is known; the two below describe them
  double median = 0;         ///< infinity: no number; NaN: none is known
  double p99 = 0;
  Estimate cost;  ///< see SpeedError::relative; NaN where there is none
  Reliability reliability;
  bool frontier = false;  ///< reliable, p99 a number, and no such other is as cheap and as accurate and better in one

  bool reliable() const { return reliability.reliable(); }
  /// Has a finite cost and a known error, which may be infinite.
  bool placed() const;
  /// Solved less than kReliableShare of the problems that it took and that are not proven unsolvable, or has answers
  /// without a number. Its error is that of the few that it solved: pictures draw it as a failure, at no error.
  bool failed() const;
};

/// Errors that an answer may have to meet.
inline constexpr std::array kErrorTargets{1e-4, 1e-6, 1e-9, 1e-12};

/// The cheapest reliable solvers whose error is at most a target.
struct Cheapest {
  double target = 0;
  std::optional<std::size_t> by_median;  ///< index into SpeedError::points
  std::optional<std::size_t> by_p99;
};

/// Speed against error of every solver on one set.
struct SpeedError {
  std::size_t set = 0;  ///< index into Summary::sets
  ErrorMeasure measure = ErrorMeasure::kNone;
  /// Costs are ratios: summed times over those of the reference on the problems that both solved. Without a reference
  /// on this set they are median times per problem [s].
  bool relative = false;
  std::vector<SpeedErrorPoint> points;  ///< in the order of the solvers
  std::vector<Cheapest> cheapest;       ///< one for each of kErrorTargets
  std::int64_t most_problems = 0;       ///< that any solver took, not proven unsolvable

  double plan_share = 1;  ///< of the cells planned for this set, those that are done

  /// No solver met enough problems to be called reliable.
  bool too_few() const { return report::too_few(most_problems, plan_share); }
};

/// The points of one set, by the measure given or the best that it allows. Refused sets and sweeps have none.
/// O(answers log answers + points^2).
/// @param ratios  costs are ratios where the set has any, else median times always
SpeedError speed_error(const Summary& summary, std::size_t set, std::optional<ErrorMeasure> measure = std::nullopt,
                       bool ratios = true);

/// Of all sets but the curated cases of `hard/` (one problem each).
std::vector<SpeedError> speed_errors(const Summary& summary);

/// speed_error.csv: one record for each set and solver, `frontier` among its columns; cheapest.csv: one for each set,
/// target and statistic, without a solver where none meets the target.
nlohmann::ordered_json speed_error_json(const Summary& summary, const std::vector<SpeedError>& sets);
nlohmann::ordered_json cheapest_json(const Summary& summary, const std::vector<SpeedError>& sets);

/// What speed_error.csv and conditioning.csv say of a point.
nlohmann::ordered_json point_json(const Summary& summary, const SpeedError& set, const SpeedErrorPoint& point);

/// A point's time over the reference's, as a set whose times are relative has it, else its time.
std::string cost_text(const SpeedError& set, const SpeedErrorPoint& point);

/// A solver's name with its rung in a word: "lemke quad" for lemke{precision=quad}.
std::string rung_label(const Summary& summary, std::size_t solver);

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
