#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include <CLI/CLI.hpp>

namespace lcpbench {

struct Study;

/// `--format text|json`, into `json`, and `--wide`, after which texts are as wide as they come out.
void add_output_options(CLI::App& command, bool& json);

/// An option that may be given several times, each time with one value.
CLI::Option* add_repeatable(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                            const std::string& help);

/// An option that takes a number. The help shows its default, unless it is a std::optional.
template <class Number>
CLI::Option* add_number(CLI::App& command, const std::string& name, Number& value, const std::string& help,
                        const CLI::Validator& check) {
  CLI::Option* option = command.add_option(name, value, help)->check(check);
  if constexpr (std::is_arithmetic_v<Number>) option->capture_default_str();
  return option;
}

/// Refuses what is no decimal integer in [0, 2^64). CLI11's own conversion turns larger ones into 2^64 - 1.
CLI::Validator seed_check();

/// Refuses what is no number in [low, high], NaN included, which CLI::Range lets pass. The defaults suit time limits [s].
CLI::Validator number_check(double low = 1e-6, double high = 1e7);

/// Which problems of finite sets a study leaves out, for stderr; "" where none is.
std::string left_out_text(const Study& study);

}  // namespace lcpbench
