#include "study/report/replay_page.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/canvas.h"
#include "study/report/figures.h"
#include "study/report/scenes.h"
#include "study/report/style.h"
#include "study/report/text.h"

namespace lcpbench {
namespace {

using report::Box;
using report::Canvas;

constexpr double kFloor = 1e-6;  // m: smaller ways are drawn here
constexpr double kCurveHeight = 150;
constexpr double kLegendHeight = 26;

std::string length_of_decade(int exponent) {
  if (exponent >= 0) return fmt::format("{:g} m", std::pow(10, exponent));
  if (exponent >= -3) return fmt::format("{:g} mm", std::pow(10, exponent + 3));
  return fmt::format("{:g} µm", std::pow(10, exponent + 6));
}

/// Pixels of a linear axis, and tics at round numbers.
class LinearAxis {
 public:
  LinearAxis(double low, double high, double begin, double end)
      : low_(low), high_(high > low ? high : low + 1), begin_(begin), end_(end) {}
  double pixel(double value) const { return begin_ + (value - low_) / (high_ - low_) * (end_ - begin_); }
  std::vector<report::Tic> tics(int count, const char* unit) const {
    const double rough = (high_ - low_) / count;
    const double power = std::pow(10, std::floor(std::log10(rough)));
    double step = 10 * power;
    for (const double digit : {5.0, 2.0, 1.0}) {
      if (digit * power >= rough) step = digit * power;
    }
    std::vector<report::Tic> tics;
    for (double at = std::ceil(low_ / step); at * step <= high_; ++at) {
      tics.push_back({pixel(at * step), fmt::format("{:g} {}", at * step, unit)});
    }
    return tics;
  }

 private:
  double low_;
  double high_;
  double begin_;
  double end_;
};

/// A measure over time, of every replay.
struct Panel {
  std::string heading;
  double ReplayStep::*measure;
  bool length = true;  ///< on a logarithmic axis; else relative to the first step, on a linear one
};

double value_of(const Panel& panel, const Replay& replay, const ReplayStep& step) {
  const double value = step.*panel.measure;
  return panel.length ? std::max(value, kFloor) : value - replay.steps.front().*panel.measure;
}

void draw_panel(Canvas& canvas, const ReplayedScene& scene, const Panel& panel, const Box& area) {
  std::vector<double> values;
  for (const Replay& replay : scene.replays) {
    for (const ReplayStep& step : replay.steps) values.push_back(value_of(panel, replay, step));
  }
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  canvas.text(area.left, area.top - 12, panel.heading, {.color = report::kSoft});
  if (values.empty()) return;
  const LinearAxis time(0, scene.step_length_s * static_cast<double>(scene.steps), area.left, area.right);
  const auto draw = [&](const auto& axis, const std::vector<report::Tic>& tics) {
    report::draw_frame(canvas, area, time.tics(6, "s"), tics);
    for (std::size_t i = 0; i < scene.replays.size(); ++i) {
      std::vector<std::pair<double, double>> points;
      for (const ReplayStep& step : scene.replays[i].steps) {
        const double value = value_of(panel, scene.replays[i], step);
        if (std::isfinite(value)) points.emplace_back(time.pixel(step.time_s), axis.pixel(value));
      }
      if (!points.empty()) canvas.steps(points, report::curve_stroke(i, 1.8));
    }
  };
  if (panel.length) {
    const report::LogAxis axis(values, area.bottom, area.top);
    draw(axis, axis.tics(5, length_of_decade));
  } else {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const LinearAxis axis(*low, *high, area.bottom, area.top);
    draw(axis, axis.tics(4, "J"));
  }
}

std::string curves(const ReplayedScene& scene) {
  std::vector<Panel> panels;
  if (scene.measure() == &ReplayStep::drift_m) {
    panels.push_back({"Drift of what should stand (all below 1 µm at the bottom)", &ReplayStep::drift_m});
  }
  if (scene.measure() == &ReplayStep::slip_m) {
    panels.push_back({"Slip of what is gripped (all below 1 µm at the bottom)", &ReplayStep::slip_m});
  }
  panels.push_back({"Deepest penetration (all below 1 µm at the bottom)", &ReplayStep::deepest_m});
  const bool energies = std::any_of(scene.replays.begin(), scene.replays.end(),
                                    [](const Replay& replay) { return !std::isnan(replay.energy_rise()); });
  if (energies) panels.push_back({"Energy, less that of the first step", &ReplayStep::energy_j, false});
  Canvas canvas(report::kWidth);
  double y = kLegendHeight;
  double x = report::kMargin;
  for (std::size_t i = 0; i < scene.replays.size(); ++i) {
    const std::string name = report::shorten(replayed_by(scene, scene.replays[i]), 40);
    const double width = 26 + report::kMonospaceWidth * report::kLabelSize * static_cast<double>(name.size() + 3);
    if (x > report::kMargin && x + width > report::kWidth) {
      x = report::kMargin;
      y += kLegendHeight / 1.5;
    }
    canvas.steps({{x, y - 8}, {x + 20, y - 8}}, report::curve_stroke(i, 3));
    canvas.text(x + 26, y - 8, name, {.monospace = true});
    x += width;
  }
  for (const Panel& panel : panels) {
    const Box area{80, y + 30, report::kWidth - 2 * report::kMargin, y + 30 + kCurveHeight};
    draw_panel(canvas, scene, panel, area);
    y = area.bottom + 26;
  }
  canvas.set_height(y + 4);
  return report::inline_svg(canvas.draw(scene.scene + ": measures over time", conclusion(scene)));
}

std::string measures_table(const ReplayedScene& scene) {
  std::string rows;
  const auto length = [](double metres) { return report::number_cell(metres, length_text(metres)); };
  for (const Replay& replay : scene.replays) {
    const bool engine = replay.solver == "engine";
    const double rise = scene.pushed ? std::numeric_limits<double>::quiet_NaN() : replay.energy_rise();
    const std::int64_t survived = replay.survived();
    rows += "<tr><th scope=\"row\">" + report::code(replayed_by(scene, replay)) + "</th>" +
            report::number_cell(static_cast<double>(survived), std::to_string(survived), report::escape(replay.end)) +
            report::number_cell(static_cast<double>(replay.claimed()),
                                engine ? "–" : fmt::format("{} of {}", replay.claimed(), replay.with_contacts())) +
            length(replay.largest(&ReplayStep::drift_m)) + length(replay.largest(&ReplayStep::slip_m)) +
            length(replay.largest(&ReplayStep::deepest_m)) +
            report::number_cell(rise, std::isnan(rise) ? "–" : fmt::format("{:.2g} J", rise)) + "</tr>\n";
  }
  return report::table_head("", {{"Answers of"},
                                 {"Steps survived", true},
                                 {"Claimed solved", true},
                                 {"Drift", true},
                                 {"Slip", true},
                                 {"Deepest penetration", true},
                                 {"Energy gained", true}}) +
         rows + report::kTableEnd;
}

std::string film(const ReplayPictures& pictures) {
  std::string html;
  for (std::size_t i = 0; i < pictures.frames.size(); ++i) {
    const ScenesFile& file = *pictures.frames[i];
    const std::vector<report::Figure> figures = report::filmstrip(file, *pictures.frames.front());
    if (figures.empty()) continue;
    html += "<p class=\"note\">" + report::code(replayed_by(pictures.scene, pictures.scene.replays[i])) +
            "</p>\n<div class=\"film\">";
    for (std::size_t k = 0; k < figures.size(); ++k) {
      html += fmt::format("<figure>{}<small>step {}</small></figure>\n", report::inline_svg(figures[k].svg),
                          file.step_number(k));
    }
    html += "</div>\n";
  }
  return html;
}

std::string what_replays_are() {
  return fmt::format(
      "<p>Each scene is stepped on with the answers of each solver, each solve from a cold start: the same integrator, "
      "the same collision detection, and positions that are projected out of penetration with the same solver. A scene "
      "counts as lost when a body that should stand or be held moved, or a contact sank, by more than {}.</p>\n",
      length_text(kLost));
}

std::string conclusions_list(const std::vector<ReplayPictures>& scenes) {
  std::string items;
  for (const ReplayPictures& pictures : scenes) {
    items += "<li>" + report::escape(conclusion(pictures.scene)) + "</li>\n";
  }
  return "<ul>\n" + items + "</ul>\n";
}

std::string measures_and_pictures(const ReplayPictures& pictures) {
  return measures_table(pictures.scene) + film(pictures) + "<figure><div class=\"scroll\" tabindex=\"0\">" +
         curves(pictures.scene) + "</div></figure>\n";
}

}  // namespace

std::string replay_section(const std::vector<ReplayPictures>& scenes) {
  if (scenes.empty()) return "";
  std::string parts;
  for (const ReplayPictures& pictures : scenes) {
    parts += fmt::format("<details><summary><span id=\"replay-{0}\">{1}</span></summary>\n",
                         report::file_stem(pictures.scene.scene), report::code(pictures.scene.scene)) +
             measures_and_pictures(pictures) + "</details>\n";
  }
  return "<section id=\"replay\"><h2>Replays: what an error in the contacts does to a scene</h2>\n" +
         what_replays_are() + conclusions_list(scenes) + parts + "</section>\n";
}

std::string replay_page(const std::vector<ReplayPictures>& scenes, const std::string& command_line) {
  std::string page =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>lcpbench replay</title>\n<style>";
  page += report::kStyle;
  page += report::kFigureStyle;
  page += "</style></head>\n<body>\n<h1>What an error in the contacts does to a scene</h1>\n";
  page += what_replays_are() + "<p class=\"note\"><code>" + report::escape(command_line) + "</code></p>\n" +
          conclusions_list(scenes);
  for (const ReplayPictures& pictures : scenes) {
    const ReplayedScene& scene = pictures.scene;
    page += fmt::format("<h2 id=\"{0}\">{0}</h2>\n<p class=\"answer\">{1}</p>\n", report::escape(scene.scene),
                        report::escape(conclusion(scene)));
    page += measures_and_pictures(pictures);
  }
  return page + "</body></html>\n";
}

}  // namespace lcpbench
