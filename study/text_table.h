#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lcpbench {

/// Seconds in the unit that suits: "1.23 us", "45.6 ms", "7.89 s"; "-" for NaN.
std::string format_seconds(double seconds);

/// 1234567 as "1,234,567".
std::string format_count(std::int64_t count);

/// Three significant digits, "1.23e-10"; "-" for NaN.
std::string format_error(double value);

/// A table for people: columns padded to their widest cell, two blanks between them.
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
