#pragma once

#include <string>
#include <vector>

#include "study/report/canvas.h"
#include "study/report/summary.h"

namespace lcpbench::report {

// What all pictures share: sizes [px], headings, logarithmic axes.

inline constexpr double kWidth = 900;
inline constexpr double kMargin = 16;
inline constexpr double kLabelSize = 12;
inline constexpr double kLabelHeight = 15;
inline constexpr double kErrorFloor = 1e-17;  ///< smaller errors, exact answers among them, are drawn here

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
std::string label_of(const Summary& summary, const Cell& cell);

/// The same with the rung of a precision ladder as a word: "lemke quad (20 of 100)".
std::string rung_label(const Summary& summary, const Cell& cell);

/// The relative error up to which an answer of the set counts as solved.
double verdict_bound(const SetSummary& set);

}  // namespace lcpbench::report
