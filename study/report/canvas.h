#pragma once

#include <string>
#include <string_view>

#include "study/report/labels.h"

namespace lcpbench::report {

/// Widths of monospaced and proportional text as browsers set it, per character and pixel of font size. The latter is
/// an upper estimate for Latin text in Helvetica, Arial and DejaVu Sans.
inline constexpr double kMonospaceWidth = 0.605;
inline constexpr double kProportionalWidth = 0.58;

/// Characters of UTF-8 text.
std::size_t character_count(std::string_view text);
/// At most `limit` characters, the last an ellipsis when something is left out.
std::string shorten(std::string_view text, std::size_t limit);

/// Before or behind what the plot command draws.
enum class Layer { kFront, kBack };

enum class Align { kLeft, kCenter, kRight };

struct TextStyle {
  double size = 12;
  const char* color = "#333333";
  Align align = Align::kLeft;
  bool monospace = false;
  bool bold = false;
};

/// Builds a gnuplot script in pixels, y downward from the top left corner.
class Canvas {
 public:
  Canvas(double width, double height) : width_(width), height_(height) {}

  double width() const { return width_; }
  double height() const { return height_; }

  /// One line of text, centred on `y`.
  void text(double x, double y, std::string_view text, const TextStyle& style);
  void rectangle(const Box& box, const char* color);
  void line(double x0, double y0, double x1, double y1, const char* color, double line_width, bool dashed = false,
            Layer layer = Layer::kFront);
  /// Any other command.
  void command(const std::string& line) { commands_ += line + "\n"; }
  /// The frame that a plot command fills.
  void plot_area(const Box& area);

  /// The picture, with `plot` as the plot command (and its inline data). @throws FigureError
  std::string draw(const std::string& title, const std::string& plot) const;

 private:
  std::string position(double x, double y) const;
  double width_;
  double height_;
  std::string commands_;
};

}  // namespace lcpbench::report
