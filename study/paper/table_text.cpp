#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "study/paper/contestants.h"

namespace lcpbench::paper {

using Json = nlohmann::ordered_json;

std::string code(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '`' || c == '\n' || c == '\r'; }, '\'');
  return "`" + text + "`";
}

std::string points(double share) {
  if (std::isnan(share)) return kAbsent;
  const double value = 100 * share;
  if (value == 0 || value == 100) return fmt::format("{:.0f}", value);
  const std::string text = fmt::format("{:.2f}", value);
  if (text == "100.00") return ">99.99";
  if (text == "0.00") return "<0.01";
  return text;
}

std::string points(const Interval& interval) { return points(interval.low) + "–" + points(interval.high); }

std::string number(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : kAbsent; }

std::string spread_text(double mean, double sigma, double max) {
  return number(mean) + " (" + number(sigma) + ") " + number(max);
}

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json share_json(const Proportion& share) {
  return {{"share", number_json(share.value())},
          {"low", number_json(share.interval().low)},
          {"high", number_json(share.interval().high)},
          {"of", number_json(share.trials > 0 ? share.trials : Proportion{}.value())}};
}

}  // namespace lcpbench::paper
