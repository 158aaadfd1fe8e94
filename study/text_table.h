#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lcpbench {

struct TimeUnit {
  const char* name;
  double seconds;
};

/// The unit in which a time has one to three digits before the point: s, ms, µs or ns.
TimeUnit time_unit(double seconds);

/// Three significant digits of a number from 1 to 1000: "1.23", "45.6", "789".
std::string three_digits(double value);

/// Seconds in the unit that suits: "123 ns", "1.23 µs", "45.6 ms", "7.89 s"; "-" for NaN and infinity.
std::string format_seconds(double seconds);

/// 1234567 as "1,234,567".
std::string format_count(std::int64_t count);

/// Three significant digits, "1.23e-10"; "-" for NaN.
std::string format_error(double value);

/// A table for people: columns padded to their widest cell, two blanks between them; control characters become '?'.
class TextTable {
 public:
  enum class Align { kLeft, kRight };
  struct Column {
    std::string title;
    Align align = Align::kRight;
  };

  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// A row with fewer cells than columns is filled up with empty ones.
  void add_row(std::vector<std::string> cells);
  /// An empty line between groups of rows.
  void add_gap();
  std::string text() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace lcpbench
