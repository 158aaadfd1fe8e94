#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "study/output/text_table.h"

namespace lcpbench::report {

/// A rectangle in pixels; y grows downward.
struct Box {
  double left = 0;
  double top = 0;
  double right = 0;
  double bottom = 0;

  bool contains(const Box& other) const;
  /// Shared area; 0 when they only touch.
  double overlap(const Box& other) const;
};

/// A point that wants a label of a given width beside it.
struct LabelledPoint {
  double x = 0;
  double y = 0;
  double width = 0;  ///< of the text
};

struct PlacedLabel {
  Box box;
  bool leader = false;  ///< too far from its point to be read as its label without a line
};

/// Places one label per point inside `area`, near its point and free of other labels, points and obstacles as far as
/// there is room: each label in turn takes its cheapest candidate position, until none moves. Deterministic;
/// O(points^2).
/// @param height of one line of text
std::vector<PlacedLabel> place_labels(std::span<const LabelledPoint> points, std::span<const Box> obstacles,
                                      const Box& area, double height);

/// The labels that overlap another one, or whose leader crosses a label or another leader: where there is no room for
/// all, these are too long. Ascending. O(points^2)
std::vector<std::size_t> crowded_labels(std::span<const LabelledPoint> points, std::span<const PlacedLabel> placed);

/// Heights for labels of one line each in a column, every one as near to what it wishes as order and room allow: where
/// they crowd they are pushed down, then up again from the bottom, until no two overlap. @returns in the order given.
std::vector<double> stack_labels(std::span<const double> wishes, double top, double bottom, double height);

/// Widths of monospaced and proportional text as browsers set it, per character and pixel of font size. The latter is
/// an upper estimate for Latin text in Helvetica, Arial and DejaVu Sans.
inline constexpr double kMonospaceWidth = 0.605;
inline constexpr double kProportionalWidth = 0.58;

// Colours are names of classes in kFigureStyle, which has a light and a dark value for each. A colour that begins with
// '#' is drawn as it is in both.
inline constexpr const char* kInk = "c-ink";
inline constexpr const char* kSoft = "c-soft";
inline constexpr const char* kGrid = "c-grid";
inline constexpr const char* kAxis = "c-axis";
inline constexpr const char* kGround = "c-ground";
inline constexpr const char* kWrong = "c-wrong";
inline constexpr const char* kGood = "c-good";
inline constexpr const char* kPlain = "c-plain";
inline constexpr const char* kGrey = "c-grey";
inline constexpr const char* kFaint = "c-faint";

/// The style sheet of every picture. A page that holds pictures has it once; a picture in a file has its own.
inline constexpr const char* kFigureStyle =
    R"css(svg text { font-family: Helvetica, Arial, sans-serif; white-space: pre; }
svg .m { font-family: ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace; }
svg .l { fill: none; stroke: currentColor; }
svg .h { fill: #ffffff; stroke: currentColor; stroke-width: 1.6; }
svg .c-ground { color: #ffffff; } svg .c-ink { color: #222222; } svg .c-soft { color: #666666; }
svg .c-grid { color: #e4e4e4; } svg .c-axis { color: #999999; } svg .c-wrong { color: #b3261e; }
svg .c-good { color: #00703c; } svg .c-plain { color: #1f5a99; } svg .c-grey { color: #777777; }
svg .c-faint { color: #b9c4d0; }
svg .c0 { color: #0072b2; } svg .c1 { color: #d55e00; } svg .c2 { color: #007a5a; } svg .c3 { color: #a8518a; }
svg .c4 { color: #333333; } svg .c5 { color: #9a6a00; } svg .c6 { color: #4aa3df; } svg .c7 { color: #7a4fd0; }
svg .c8 { color: #5f8a1f; } svg .c9 { color: #8a8a8a; }
@media (prefers-color-scheme: dark) {
svg .h { fill: #17191b; }
svg .c-ground { color: #17191b; } svg .c-ink { color: #e6e7e8; } svg .c-soft { color: #a8adb3; }
svg .c-grid { color: #33373b; } svg .c-axis { color: #7b8087; } svg .c-wrong { color: #ff8a80; }
svg .c-good { color: #7fd1a0; } svg .c-plain { color: #86b7ea; } svg .c-grey { color: #a0a5ab; }
svg .c-faint { color: #4b5661; }
svg .c0 { color: #56b4e9; } svg .c1 { color: #ff9a4d; } svg .c2 { color: #4fd0a5; } svg .c3 { color: #e39ac9; }
svg .c4 { color: #e6e7e8; } svg .c5 { color: #e0b040; } svg .c6 { color: #2f86c8; } svg .c7 { color: #b79cff; }
svg .c8 { color: #a5d65a; } svg .c9 { color: #8f949a; } }
)css";

/// At most `limit` characters, the last an ellipsis when something is left out.
std::string shorten(const std::string& text, std::size_t limit);

/// Before or behind everything else.
enum class Layer { kFront, kBack };

enum class Align { kLeft, kCenter, kRight };

enum class Shape { kDisc, kSquare, kTriangle, kDiamond, kCross, kPlus };
inline constexpr std::size_t kShapes = 6;

struct TextStyle {
  double size = 12;
  const char* color = kInk;
  Align align = Align::kLeft;
  bool monospace = false;
  bool bold = false;
};

/// A line through points; `dash` is a list of SVG's stroke-dasharray, "" for a whole line.
struct Stroke {
  const char* color = kInk;
  double width = 1;
  std::string dash;
};

/// Builds an SVG in pixels, y downward from the top left corner. Later drawings cover earlier ones of their layer.
class Canvas {
 public:
  explicit Canvas(double width, double height = 0) : width_(width), height_(height) {}

  /// For pictures whose height follows from what is drawn.
  void set_height(double height) { height_ = height; }

  /// One line of text, centred on `y`.
  void text(double x, double y, std::string_view text, const TextStyle& style);
  void rectangle(const Box& box, const std::string& color);
  void line(double x0, double y0, double x1, double y1, const char* color, double line_width, bool dashed = false,
            Layer layer = Layer::kFront);
  /// A curve that goes right, then up or down, from one point to the next.
  void steps(const std::vector<std::pair<double, double>>& points, const Stroke& stroke);
  /// A point of about 2 x `radius` pixels; a hollow one shows the ground.
  void marker(double x, double y, double radius, Shape shape, const char* color, bool hollow = false);

  /// Discs as one path; what is drawn twice at a place is drawn once.
  void dots(const std::vector<std::pair<double, double>>& points, double radius, const char* color);

  /// Translucent bodies with their outlines. @param paths  SVG path data, one for each body
  void bodies(const std::vector<std::string>& paths, const char* color);

  /// The picture as an SVG file. @param title        its name
  /// @param alternative  the words for readers who do not see it
  std::string draw(const std::string& title, const std::string& alternative) const;

 private:
  std::string& layer(Layer layer) { return layer == Layer::kFront ? front_ : back_; }

  double width_;
  double height_;
  std::string back_;
  std::string front_;
};

/// A picture of Canvas::draw for a page that has kFigureStyle: without a style sheet and a name space of its own.
std::string inline_svg(const std::string& svg);

}  // namespace lcpbench::report
