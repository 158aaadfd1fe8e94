#pragma once

#include <vector>

#include "study/report/canvas.h"
#include "study/report/summary.h"

namespace lcpbench::report {

/// What stands beside the points of speed against error: for each solver that failed on some problem the shares that it
/// answered wrongly while saying solved, or gave up on; the others in one sentence.
class FailureStrip {
 public:
  FailureStrip(const Summary& summary, const std::vector<const Cell*>& cells);

  double height() const;
  /// @param top  [px]
  void draw(Canvas& canvas, double top) const;

 private:
  struct Row {
    std::string label;
    double wrong = 0;
    double gave_up = 0;
  };
  std::vector<Row> rows_;           ///< the least failures first, wrong answers before all
  std::vector<std::string> lines_;  ///< who never failed
};

/// Breaks a list of words at commas into lines of at most `limit` characters each.
std::vector<std::string> lines_of(const std::string& text, std::size_t limit);

}  // namespace lcpbench::report
