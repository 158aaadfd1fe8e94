#include "study/commands/commands.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <limits>
#include <system_error>
#include <thread>

#include <unistd.h>

#include "core/io/scenes_file.h"
#include "core/io/text_tokens.h"
#include "core/registry.h"
#include "study/run/study.h"

namespace lcpbench {
namespace {

/// The files that are read for an input: of "F.scenes#120" F.scenes, of a Matrix Market pair both.
std::vector<std::string> files_of(const std::string& input) {
  const std::string before_step = input.substr(0, input.rfind('#'));
  if (is_scenes_file(before_step)) return {before_step};
  if (!input.ends_with(".M.mtx") && !input.ends_with(".q.mtx")) return {input};
  const std::string stem = input.substr(0, input.size() - std::string_view(".M.mtx").size());
  return {stem + ".M.mtx", stem + ".q.mtx"};
}

}  // namespace

void add_output_options(CLI::App& command, bool& json) {
  command.add_flag_callback("--wide", lift_text_width, "show every column, however wide the lines become");
  command
      .add_option_function<std::string>("--format", [&json](const std::string& format) { json = format == "json"; },
                                        "text for people, json for programs")
      ->check(CLI::IsMember({"text", "json"}))
      ->default_str("text");
}

CLI::Option* add_repeatable(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                            const std::string& help) {
  CLI::Option* option = command.add_option(name, values, help)->allow_extra_args(false);
  return values.empty() ? option : option->capture_default_str();
}

std::vector<Spec> solver_specs(const std::vector<std::string>& texts) {
  std::vector<Spec> specs;
  for (const std::string& text : texts) specs.push_back(canonical_solver_spec(parse_spec(text)));
  return specs;
}

int processors() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && access(folder.c_str(), W_OK) != 0) error = {errno, std::generic_category()};
  if (error) throw InputError(fmt::format("--out '{}': {}", folder.string(), error.message()));
}

void refuse_inputs(const std::filesystem::path& out, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs) {
    for (const std::string& file : files_of(input)) {
      std::error_code ignored;
      if (std::filesystem::equivalent(out, file, ignored)) {
        throw InputError(fmt::format("{}: is read by this command; write elsewhere", out.string()));
      }
    }
  }
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
            const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
            const bool whole = error == std::errc() && end == text.data() + text.size();
            return whole ? std::string() : fmt::format("'{}' is no integer {}", text, range);
          },
          range};
}

CLI::Option* add_solved_at(CLI::App& command, std::optional<double>& bound) {
  return add_number(command, "--solved-at", bound,
                    "the verdict's bound: largest error of a solved answer, 1 being as bad as no impulses (default: "
                    "1e-4 of contacts, 1e-6 of bare LCPs)",
                    number_check(1e-15, 1));
}

CLI::Validator number_check(double low, double high) {
  const std::string range = fmt::format("in [{:g}, {:g}]", low, high);
  return {[low, high, range](const std::string& text) {
            const std::optional<double> number = parse_decimal(text);
            const bool inside = number && *number >= low && *number <= high;
            return inside ? std::string() : fmt::format("'{}' is no number {}", text, range);
          },
          range};
}

}  // namespace lcpbench
