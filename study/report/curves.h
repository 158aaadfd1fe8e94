#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/report/canvas.h"
#include "study/report/summary.h"

namespace lcpbench::report {

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
  std::vector<double> x_values;       ///< that the logarithmic axis spans besides the steps; positive and finite
  std::optional<double> bound;        ///< where the verdict turns
};

/// Curves over a logarithmic axis, each named at its end. @pre there is a step or an x value.
/// @returns the SVG.
std::string draw_shares(const SetSummary& set, const ShareAxes& axes, const std::vector<Curve>& curves);

}  // namespace lcpbench::report
