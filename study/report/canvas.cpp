#include "study/report/canvas.h"

#include <algorithm>

#include <fmt/format.h>

#include "study/report/gnuplot.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

bool starts_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

/// gnuplot escapes what SVG needs but for the end of a CDATA section, which XML allows in no text.
std::string svg_text(std::string_view text) {
  std::string out = mended(text);
  for (std::size_t at = out.find("]]>"); at != std::string::npos; at = out.find("]]>", at)) out.insert(at + 2, " ");
  return out;
}

const char* alignment(Align align) {
  switch (align) {
    case Align::kLeft: return "left";
    case Align::kCenter: return "center";
    case Align::kRight: return "right";
  }
  return "left";
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

std::string Canvas::position(double x, double y) const {
  return fmt::format("screen {:.6f},{:.6f}", x / width_, 1 - y / height_);
}

void Canvas::text(double x, double y, std::string_view text, const TextStyle& style) {
  command(fmt::format("set label {} at {} {} font '{}{},{:g}' textcolor rgb '{}' front", gnuplot_quote(svg_text(text)),
                      position(x, y), alignment(style.align), style.monospace ? "monospace" : "sans-serif",
                      style.bold ? ":Bold" : "", style.size, style.color));
}

void Canvas::rectangle(const Box& box, const char* color) {
  command(fmt::format("set object rectangle from {} to {} fillcolor rgb '{}' fillstyle solid noborder front",
                      position(box.left, box.bottom), position(box.right, box.top), color));
}

void Canvas::line(double x0, double y0, double x1, double y1, const char* color, double line_width, bool dashed,
                  Layer layer) {
  command(fmt::format("set arrow from {} to {} nohead linecolor rgb '{}' linewidth {:g}{} {}", position(x0, y0),
                      position(x1, y1), color, line_width, dashed ? " dashtype (6,4)" : "",
                      layer == Layer::kFront ? "front" : "back"));
}

void Canvas::plot_area(const Box& area) {
  command(fmt::format("set lmargin at screen {:.6f}\nset rmargin at screen {:.6f}", area.left / width_,
                      area.right / width_));
  command(fmt::format("set tmargin at screen {:.6f}\nset bmargin at screen {:.6f}", 1 - area.top / height_,
                      1 - area.bottom / height_));
}

std::string Canvas::draw(const std::string& title, const std::string& plot) const {
  std::string script = fmt::format(
      "set encoding utf8\n"
      "set terminal svg size {:.0f},{:.0f} fixed noenhanced background '#ffffff' font 'sans-serif,12'\n"
      "set key off\n",
      width_, height_);
  std::string svg = run_gnuplot(script + commands_ + plot + "\n");
  // gnuplot writes its own name as the picture's title, which browsers show and screen readers read.
  const std::size_t begin = svg.find("<title>");
  const std::size_t end = svg.find("</desc>");
  if (begin != std::string::npos && end != std::string::npos) {
    svg.replace(begin, end + std::string("</desc>").size() - begin, "<title>" + title + "</title>");
  }
  // Without enhanced text mode gnuplot passes its mark of bold type on as a part of the family's name.
  constexpr std::string_view kMarkedBold = "font-family=\"sans-serif:Bold\"";
  for (std::size_t at = svg.find(kMarkedBold); at != std::string::npos; at = svg.find(kMarkedBold, at)) {
    svg.replace(at, kMarkedBold.size(), "font-family=\"sans-serif\" font-weight=\"bold\"");
  }
  return svg;
}

}  // namespace lcpbench::report
