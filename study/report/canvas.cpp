#include "study/report/canvas.h"

#include <algorithm>

#include <fmt/format.h>

#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kDefaultSize = 12;
constexpr double kBaseline = 0.36;  // of the size: half the height of capitals

bool starts_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

/// A length to a hundredth of a pixel, without zeros at its end.
std::string px(double value) {
  std::string text = fmt::format("{:.2f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string paint(const std::string& color) {
  return color.starts_with('#') ? "fill=\"" + color + "\"" : "class=\"" + color + "\"";
}

std::string stroke_attributes(const Stroke& stroke) {
  std::string attributes = fmt::format("class=\"l {}\"", stroke.color);
  if (stroke.width != 1) attributes += fmt::format(" stroke-width=\"{:g}\"", stroke.width);
  if (!stroke.dash.empty()) attributes += fmt::format(" stroke-dasharray=\"{}\"", stroke.dash);
  return attributes;
}

std::string outline(double x, double y, double r, Shape shape) {
  const auto at = [&](double dx, double dy) { return px(x + dx * r) + " " + px(y + dy * r); };
  switch (shape) {
    case Shape::kDisc: break;
    case Shape::kSquare: return "M" + at(-0.9, -0.9) + "L" + at(0.9, -0.9) + "L" + at(0.9, 0.9) + "L" + at(-0.9, 0.9);
    case Shape::kTriangle: return "M" + at(0, -1.1) + "L" + at(1.1, 0.9) + "L" + at(-1.1, 0.9);
    case Shape::kDiamond: return "M" + at(0, -1.25) + "L" + at(1.25, 0) + "L" + at(0, 1.25) + "L" + at(-1.25, 0);
    case Shape::kCross:
      return "M" + at(-1.1, -0.6) + "L" + at(-0.6, -1.1) + "L" + at(1.1, 0.6) + "L" + at(0.6, 1.1) + "zM" +
             at(1.1, -0.6) + "L" + at(0.6, -1.1) + "L" + at(-1.1, 0.6) + "L" + at(-0.6, 1.1);
    case Shape::kPlus:
      return "M" + at(-1.3, -0.4) + "L" + at(1.3, -0.4) + "L" + at(1.3, 0.4) + "L" + at(-1.3, 0.4) + "zM" +
             at(-0.4, -1.3) + "L" + at(0.4, -1.3) + "L" + at(0.4, 1.3) + "L" + at(-0.4, 1.3);
  }
  return "";
}

}  // namespace

std::size_t character_count(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), starts_character));
}

std::string shorten(std::string_view text, std::size_t limit) {
  if (character_count(text) <= limit) return std::string(text);
  std::string kept;
  std::size_t characters = 0;
  for (const char c : text) {
    if (starts_character(c) && ++characters == limit) break;
    kept += c;
  }
  return kept + "…";
}

void Canvas::text(double x, double y, std::string_view text, const TextStyle& style) {
  const std::string color = style.color;
  const bool classed = !color.starts_with('#');
  std::string classes = style.monospace ? "m" : "";
  if (classed) classes += (classes.empty() ? "" : " ") + color;
  front_ += fmt::format("<text x=\"{}\" y=\"{}\"", px(x), px(y + kBaseline * style.size));
  if (!classes.empty()) front_ += " class=\"" + classes + "\"";
  if (!classed) front_ += " fill=\"" + color + "\"";
  if (style.align != Align::kLeft) {
    front_ += fmt::format(" text-anchor=\"{}\"", style.align == Align::kCenter ? "middle" : "end");
  }
  if (style.size != kDefaultSize) front_ += fmt::format(" font-size=\"{:g}\"", style.size);
  if (style.bold) front_ += " font-weight=\"bold\"";
  front_ += ">" + escape(text) + "</text>\n";
}

void Canvas::rectangle(const Box& box, const std::string& color) {
  front_ += fmt::format("<path {} d=\"M{} {}h{}v{}h{}z\"/>\n", paint(color), px(box.left), px(box.top),
                        px(box.right - box.left), px(box.bottom - box.top), px(box.left - box.right));
}

void Canvas::line(double x0, double y0, double x1, double y1, const char* color, double line_width, bool dashed,
                  Layer where) {
  layer(where) += fmt::format("<path {} d=\"M{} {}L{} {}\"/>\n",
                              stroke_attributes({color, line_width, dashed ? "6 4" : ""}), px(x0), px(y0), px(x1),
                              px(y1));
}

void Canvas::steps(const std::vector<std::pair<double, double>>& points, const Stroke& stroke) {
  std::string path;
  std::string x;
  std::string y;
  for (const auto& [at_x, at_y] : points) {
    const std::string next_x = fmt::format("{:.1f}", at_x);
    const std::string next_y = fmt::format("{:.1f}", at_y);
    if (path.empty()) path = "M" + next_x + " " + next_y;
    if (!x.empty() && next_x != x) path += "H" + next_x;
    if (!y.empty() && next_y != y) path += "V" + next_y;
    x = next_x;
    y = next_y;
  }
  front_ += "<path " + stroke_attributes(stroke) + " d=\"" + path + "\"/>\n";
}

void Canvas::marker(double x, double y, double radius, Shape shape, const char* color, bool hollow) {
  const std::string classes = fmt::format("class=\"{}{}\"", hollow ? "h " : "", color);
  front_ += shape == Shape::kDisc
                ? fmt::format("<circle {} cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", classes, px(x), px(y), px(radius))
                : fmt::format("<path {} d=\"{}z\"/>\n", classes, outline(x, y, radius, shape));
}

std::string Canvas::draw(const std::string& title, const std::string& alternative) const {
  const std::string width = px(width_);
  const std::string height = px(height_);
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
             "role=\"img\" aria-label=\"{2}\" font-size=\"{3:g}\" fill=\"currentColor\">\n<title>{4}</title>\n"
             "<style>{5}</style>\n<path class=\"c-ground\" d=\"M0 0h{0}v{1}H0z\"/>\n",
             width, height, escape(alternative), kDefaultSize, escape(title), kFigureStyle) +
         back_ + front_ + "</svg>\n";
}

std::string inline_svg(const std::string& svg) {
  std::string text = svg;
  const auto cut = [&text](std::string_view first, std::string_view last) {
    const std::size_t begin = text.find(first);
    const std::size_t end = text.find(last, begin);
    if (end != std::string::npos) text.erase(begin, end + last.size() - begin);
  };
  cut("<style>", "</style>\n");
  cut(" xmlns=\"", "svg\"");
  return text;
}

}  // namespace lcpbench::report
