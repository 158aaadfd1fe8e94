#include "study/commands/options.h"

#include <charconv>
#include <cstdint>
#include <limits>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "study/output/terminal.h"
#include "study/output/text_table.h"
#include "study/run/study.h"

namespace lcpbench {
namespace {

template <class Number>
bool parse(const std::string& text, Number& number) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  return error == std::errc() && stop == end;
}

}  // namespace

void add_format_option(CLI::App& command, std::string& format) {
  command.add_option("--format", format, "text for people, json for programs")
      ->check(CLI::IsMember({"text", "json"}))
      ->capture_default_str();
}

int Extent::width() const { return wide ? kUnlimited : terminal_width(); }

void add_wide_option(CLI::App& command, Extent& extent) {
  command.add_flag("--wide", extent.wide, "show every column, however wide the lines become");
}

void add_long_option(CLI::App& command, Extent& extent, const std::string& help) {
  command.add_flag("--long", extent.all, help);
}

std::string left_out_text(const Study& study) {
  std::int64_t taken = 0;
  std::int64_t all = 0;
  std::vector<std::string> names;
  for (const StudySet& set : study.sets) {
    const std::int64_t count = set.set->count().value_or(set.trials);
    if (count == set.trials) continue;
    names.push_back(set.set->name());
    taken += set.trials;
    all += count;
  }
  if (names.empty()) return "";
  if (names.size() == 1) {
    return fmt::format("{}: the first {} of its {} problems are taken; --trials {} takes all\n", names.front(),
                       format_count(taken), format_count(all), all);
  }
  return fmt::format("of {} sets with {} problems in all, the first ones of each are taken, {} in all; --trials takes "
                     "more\n",
                     names.size(), format_count(all), format_count(taken));
}

CLI::Validator seed_check() {
  const std::string range = fmt::format("in [0, {}]", std::numeric_limits<std::uint64_t>::max());
  return {[range](const std::string& text) {
            std::uint64_t seed = 0;
            return parse(text, seed) ? std::string() : fmt::format("'{}' is no integer {}", text, range);
          },
          range};
}

CLI::Validator seconds_check(double low, double high) {
  const std::string range = fmt::format("in [{:g}, {:g}]", low, high);
  return {[low, high, range](const std::string& text) {
            double seconds = 0;
            const bool inside = parse(text, seconds) && seconds >= low && seconds <= high;
            return inside ? std::string() : fmt::format("'{}' is no number {}", text, range);
          },
          range};
}

}  // namespace lcpbench
