#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/report/canvas.h"
#include "study/summary/summary.h"

namespace lcpbench::report {

// What all pictures share: sizes [px], headings, logarithmic axes.

inline constexpr double kWidth = 900;
inline constexpr double kMargin = 16;
inline constexpr double kLabelSize = 12;
inline constexpr double kLabelHeight = 15;
inline constexpr double kErrorFloor = 1e-17;  ///< smaller errors, exact answers among them, are drawn here
inline constexpr double kErrorCeiling = 100;  ///< larger errors are drawn here

/// "10⁻⁴"
std::string power_of_ten(int exponent);
/// "100 µs" for -4.
std::string time_of_decade(int exponent);

/// "1/100", "same", "10×": a ratio's power of ten.
std::string ratio_of_decade(int exponent);

/// A label of an axis and where it stands.
struct Tic {
  double pixel = 0;
  std::string label;
};

/// A logarithmic axis over whole decades, drawn at pixels `begin` .. `end`.
class LogAxis {
 public:
  /// @pre the values are positive and finite, and there is at least one.
  LogAxis(const std::vector<double>& values, double begin, double end);
  double pixel(double value) const;

  /// At most about `count` tics at powers of ten; `name` turns an exponent into a label.
  std::vector<Tic> tics(int count, std::string (*name)(int)) const;

 private:
  double begin_;
  double end_;
  int low_ = 0;
  int high_ = 0;
};

/// The axes at the left and below, with a grid.
void draw_frame(Canvas& canvas, const Box& area, const std::vector<Tic>& x_tics, const std::vector<Tic>& y_tics);

/// Two lines at the top: what the set is, and its name and size.
void draw_heading(Canvas& canvas, const SetSummary& set);

/// A solver's name as pictures write it, with its trials where it has fewer than the set has problems.
std::string sized_label(const std::string& label, std::int64_t trials, std::int64_t problems);

/// The same with the rung of a precision ladder as a word: "lemke quad (20 of 100)".
std::string rung_label(const Summary& summary, const Cell& cell);

/// The relative error up to which an answer of the set counts as solved.
double verdict_bound(const SetSummary& set);

/// A share of problems that rises in steps over an axis.
struct Curve {
  std::string label;
  std::size_t color = 0;  ///< position among the set's solvers: one solver has one style in all pictures of a set
  std::vector<std::pair<double, double>> steps;  ///< (x, share from there on), ascending; x positive and finite

  double end() const { return steps.empty() ? 0 : steps.back().second; }
};

/// The colour of a curve by its number, of a cycle of ten.
const char* curve_color(std::size_t number);

/// The line of a curve by its number: colour and dashes together are different for all numbers.
Stroke curve_stroke(std::size_t number, double width);

/// " NAME: 98 % in the end." of each curve, for those who do not see the picture.
std::string ends_in_words(const std::vector<Curve>& curves);

/// What a picture of shares says around its curves.
struct ShareAxes {
  std::string title;        ///< the picture's name
  std::string alternative;  ///< for those who do not see the picture
  std::string heading;      ///< what the shares are
  std::string x_label;
  std::string (*tic)(int) = nullptr;  ///< name of a power of ten
  std::optional<double> bound;        ///< where the verdict turns
};

/// Curves over a logarithmic axis, each named at its end. @pre there is a step.
/// @returns the SVG.
std::string draw_shares(const SetSummary& set, const ShareAxes& axes, const std::vector<Curve>& curves);

}  // namespace lcpbench::report
