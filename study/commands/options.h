#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace lcpbench {

struct Study;

/// `--format text|json`, into `format`.
void add_format_option(CLI::App& command, std::string& format);

/// How much of a text for people is shown.
struct Extent {
  bool wide = false;  ///< every column, as wide as it comes out
  bool all = false;   ///< every row, and not the answer alone

  /// For TextTable::text and folded.
  int width() const;
};

/// `--wide`, into `extent`.
void add_wide_option(CLI::App& command, Extent& extent);
/// `--long`, into `extent`.
void add_long_option(CLI::App& command, Extent& extent, const std::string& help);

/// Which problems of finite sets a study leaves out, for stderr; "" where none is.
std::string left_out_text(const Study& study);

/// Refuses what is no decimal integer in [0, 2^64). CLI11's own conversion turns larger ones into 2^64 - 1.
CLI::Validator seed_check();

/// Refuses what is no number in [low, high], NaN included, which CLI::Range lets pass.
CLI::Validator seconds_check(double low, double high);

}  // namespace lcpbench
