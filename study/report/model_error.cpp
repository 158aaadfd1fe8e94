#include "study/report/model_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "study/report/axes.h"
#include "study/report/scenes.h"
#include "study/report/text.h"
#include "study/statistics/statistics.h"

namespace lcpbench::report {

namespace {

constexpr double kModelPlotHeight = 320;
constexpr double kModelBarWidth = 8;
/// Below the picture, without markup.
constexpr const char* kNoRanking =
    " The heights rank no solvers: each is over the steps that its own solver solved, and no impulses at all may leave "
    "a smaller residual than a right answer does.";
constexpr double kModelBarStep = 17;  ///< bars and their numbers stand no nearer to each other

struct ErrorSamples {
  std::vector<double> times, totals, solvers;
};

double sorted_quantile(std::vector<double>& values, double share) {
  std::sort(values.begin(), values.end());
  return quantile(values, share);
}

double on_axis(double error) { return std::clamp(error, kErrorFloor, kErrorCeiling); }

std::string point_name(const Summary& summary, const ModelErrors& errors, const ModelErrorPoint& point) {
  return sized_label(solver_label(summary, point.solver), point.steps, errors.steps);
}

/// The numbers of all bars in columns. @returns the height that they took.
double draw_numbers(Canvas& canvas, const Summary& summary, const ModelErrors& errors, double top) {
  constexpr double kNumber = kMargin + 22;
  constexpr double kName = kNumber + 6;
  const std::array<double, 3> right{kWidth - 290, kWidth - 150, kWidth - kMargin};
  const std::array<const char*, 3> headings{"median time", "total error [m/s]", "the solver’s part"};
  for (std::size_t i = 0; i < right.size(); ++i) {
    canvas.text(right[i], top + kLabelHeight / 2, headings[i], {.size = 11, .color = kSoft, .align = Align::kRight});
  }
  double y = top + 1.6 * kLabelHeight;
  for (std::size_t i = 0; i < errors.points.size(); ++i, y += kLabelHeight) {
    const ModelErrorPoint& point = errors.points[i];
    canvas.text(kNumber, y, std::to_string(i + 1), {.size = kLabelSize, .align = Align::kRight});
    canvas.text(kName, y, point_name(summary, errors, point), {.size = kLabelSize, .monospace = true});
    const std::array<std::string, 3> numbers{duration(point.time_s), scientific(point.total_m_per_s),
                                             scientific(point.solver_m_per_s)};
    for (std::size_t k = 0; k < right.size(); ++k) {
      canvas.text(right[k], y, numbers[k], {.size = kLabelSize, .align = Align::kRight});
    }
  }
  return y - top;
}

void draw_two_errors(Canvas& canvas, const ModelErrors& errors, const Box& area, const LogAxis& x, const LogAxis& y) {
  std::vector<double> wishes;
  for (const ModelErrorPoint& point : errors.points) wishes.push_back(x.pixel(point.time_s));
  const std::vector<double> places = stack_labels(wishes, area.left + 2, area.right + kModelBarStep, kModelBarStep);
  for (std::size_t i = 0; i < errors.points.size(); ++i) {
    const ModelErrorPoint& point = errors.points[i];
    const double left = places[i] - kModelBarWidth / 2;
    const double top = y.pixel(on_axis(point.total_m_per_s));
    const double shaded = y.pixel(on_axis(std::min(point.solver_m_per_s, point.total_m_per_s)));
    canvas.rectangle({left, top, left + kModelBarWidth, area.bottom}, kFaint);
    canvas.rectangle({left, shaded, left + kModelBarWidth, area.bottom}, kPlain);
    canvas.text(places[i], top - 8, std::to_string(i + 1), {.size = 11, .align = Align::kCenter});
    if (std::abs(places[i] - wishes[i]) > 1) {
      canvas.line(wishes[i], area.bottom, places[i], area.bottom - 6, kAxis, 0.8);
    }
  }
}

void draw_two_parts(Canvas& canvas, double y) {
  canvas.rectangle({kMargin, y - 5, kMargin + 10, y + 5}, kPlain);
  canvas.text(kMargin + 16, y, "the solver’s part: the residual of the conditions that it solves", {.size = 11.5});
  canvas.rectangle({kMargin + 400, y - 5, kMargin + 410, y + 5}, kFaint);
  canvas.text(kMargin + 416, y, "the rest of the total: the model’s, against the round cone", {.size = 11.5});
}

}  // namespace

ModelErrors model_errors(const Summary& summary) {
  std::map<std::size_t, ErrorSamples> samples;
  std::set<std::int64_t> steps;
  for (const Cell& cell : summary.cells) {
    if (!summary.solvers[cell.solver].sweep.empty() || !scene_name(summary.sets[cell.set].name)) continue;
    for (const Outcome& outcome : cell.outcomes) {
      if (!outcome.solved || std::isnan(outcome.model_error_m_per_s + outcome.solver_error_m_per_s)) continue;
      steps.insert(outcome.problem);
      if (!(outcome.time_s > 0)) continue;
      ErrorSamples& of = samples[cell.solver];
      of.times.push_back(outcome.time_s);
      of.totals.push_back(outcome.model_error_m_per_s);
      of.solvers.push_back(outcome.solver_error_m_per_s);
    }
  }
  ModelErrors errors{{}, static_cast<std::int64_t>(steps.size())};
  for (auto& [solver, of] : samples) {
    errors.points.push_back({solver, static_cast<std::int64_t>(of.times.size()), sorted_quantile(of.times, 0.5),
                             sorted_quantile(of.totals, 0.9), sorted_quantile(of.solvers, 0.9)});
  }
  std::stable_sort(errors.points.begin(), errors.points.end(),
                   [](const ModelErrorPoint& a, const ModelErrorPoint& b) { return a.time_s < b.time_s; });
  return errors;
}

std::optional<Figure> model_error_figure(const Summary& summary, const ModelErrors& errors) {
  if (errors.points.empty()) return std::nullopt;
  const Box area{84, 96, kWidth - 2 * kMargin, 96 + kModelPlotHeight};
  std::vector<double> times, heights;
  for (const ModelErrorPoint& point : errors.points) {
    times.push_back(point.time_s);
    heights.push_back(on_axis(point.total_m_per_s));
    heights.push_back(on_axis(std::min(point.solver_m_per_s, point.total_m_per_s)) / 10);  // a bar is to be seen
  }
  const LogAxis x(times, area.left, area.right);
  const LogAxis y(heights, area.bottom, area.top);
  Canvas canvas(kWidth);
  canvas.text(kMargin, 22, "Captured steps with friction: time against total error", {.size = 17, .bold = true});
  canvas.text(
      kMargin, 44,
      fmt::format("{}; of those that a solver solved, 90 % have at most these errors", counted(errors.steps, "step")),
      {.color = kSoft});
  draw_two_parts(canvas, 68);
  draw_frame(canvas, area, x.tics(9, time_of_decade), y.tics(9, power_of_ten));
  canvas.text(area.left - 6, area.top - 12, "m/s", {.color = kSoft, .align = Align::kRight});
  draw_two_errors(canvas, errors, area, x, y);
  canvas.text((area.left + area.right) / 2, area.bottom + 38,
              "← faster · median time per step, set-up and solve (CPU) · slower →",
              {.color = kSoft, .align = Align::kCenter});
  const double below = area.bottom + 60;
  canvas.set_height(below + draw_numbers(canvas, summary, errors, below) + 4);
  const std::string words =
      "Time against the total error of every solver on captured steps with friction, the part "
      "that is the solver’s shaded." +
      std::string(kNoRanking);
  return Figure{canvas.draw("Captured steps with friction: time against total error", words), words, ""};
}

std::string model_error_words() {
  return "<p>Each bar is a solver. Its place is the median time. Its height is the residual of the round Coulomb "
         "cone’s "
         "conditions, which holds the errors of model and solver: the residual that 90 % of the solved steps stay "
         "within. The shaded part is the same of the conditions that the solver solves. The axis is logarithmic: what "
         "is not shaded estimates the error of the model." +
         std::string(kNoRanking) + "</p>\n";
}

}  // namespace lcpbench::report
