#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lcpbench {

/// Three significant digits of a number from 1 to 999: "1.23", "45.6", "789". Smaller numbers get two decimals, larger
/// ones none.
std::string three_digits(double value);

/// Seconds in the unit with one to three digits before the point: "123 ns", "1.23 µs", "45.6 ms", "7.89 s". Longer
/// times are in s, shorter ones in ns; "-" for NaN and infinity.
std::string format_seconds(double seconds);

/// 1234567 as "1,234,567".
std::string format_count(std::int64_t count);

/// Three significant digits, "1.23e-10"; "-" for NaN.
std::string format_error(double value);

/// A `width` that does not limit lines.
inline constexpr int kUnlimited = 0;

/// Code points of UTF-8 text. Each is taken to fill one column of a terminal.
std::size_t character_count(std::string_view text);

/// The first so many code points of UTF-8 text, or all.
std::string first_characters(const std::string& text, std::size_t characters);

/// The text with every line that is longer than `width` characters broken at a blank, else behind a comma, brace, colon
/// or slash, else behind '=', or a hyphen or point between letters, else anywhere. What continues a line is indented by
/// `hanging` characters more than the line is. Behind an indent there is room for 8 characters at least, even beyond
/// `width`.
std::string folded(const std::string& text, int width, std::size_t hanging = 2);

/// make(r) for the largest r <= `rows` and <= `lines` whose text has at most `lines` lines; make(0) where none has.
/// O(rows) calls of `make`. @pre make(r) has at least r lines
template <class Make>
std::string fitting_text(std::size_t rows, std::size_t lines, Make make) {
  rows = std::min(rows, lines);
  std::string text = make(rows);
  while (rows > 0 && static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) > lines) text = make(--rows);
  return text;
}

/// "5 lines", "1 line": a count with its noun.
std::string counted_noun(std::size_t count, const char* noun);

/// Whether a is before b by strverscmp(), which compares runs of digits as numbers: exp5-1e5 is before exp5-1e10. Runs
/// with leading zeros compare as decimal fractions.
bool natural_less(const std::string& a, const std::string& b);

/// A table for people: columns padded to their widest cell, two blanks between them; control characters become '?'.
/// One that is wider than `width` has its left-aligned columns broken into several lines; where that is not enough it
/// loses columns, and says how many. Those of rank 0 stay, however wide.
class TextTable {
 public:
  enum class Align { kLeft, kRight };
  struct Column {
    std::string title;
    Align align = Align::kRight;
    int rank = 0;                ///< the column of the largest rank is left out first; 0: never
    std::size_t narrowest = 16;  ///< a left-aligned column does not become narrower than this
  };

  /// @pre one of them has rank 0
  explicit TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// A row with fewer cells than columns is filled up with empty ones; cells beyond the columns are dropped.
  void add_row(std::vector<std::string> cells);
  /// A line over the whole width, between rows: a heading of a group, words in place of numbers, or an empty line.
  void add_line(std::string text);
  bool empty() const { return rows_.empty(); }
  /// @param width  characters of a line; kUnlimited: no end
  std::string text(int width = kUnlimited) const;

 private:
  struct Row {
    std::vector<std::string> cells;  ///< none: a line
    std::string line;
  };
  /// A column that is shown, and how wide.
  struct Shown {
    std::size_t column = 0;
    std::size_t width = 0;
  };

  /// Characters of the column's widest cell, its title counted.
  std::size_t natural_width(std::size_t column) const;
  std::vector<Shown> layout(int width) const;
  std::string row_text(const std::vector<Shown>& shown, const std::vector<std::string>& cells) const;

  std::vector<Column> columns_;
  std::vector<Row> rows_;
};

}  // namespace lcpbench
