#include "study/output/text_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/utf8.h"

namespace lcpbench {
namespace {

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; }

/// Bytes of the first so many characters.
std::size_t bytes_of(std::string_view text, std::size_t characters) {
  std::size_t end = 0;
  for (; end < text.size(); ++end) {
    if (continues_character(text[end])) continue;
    if (characters == 0) break;
    --characters;
  }
  return end;
}

/// Characters that a line of `width` > 0 has after an indent, at least kLeast: broken() needs some.
std::size_t room_behind(int width, std::size_t indent) {
  constexpr std::size_t kLeast = 8;
  const auto limit = static_cast<std::size_t>(width);
  return limit > indent + kLeast ? limit - indent : kLeast;
}

bool is_letter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

/// The last place in the first `end` bytes behind which a word may be broken: punctuation of names, else an equals
/// sign, or a hyphen or a point between letters, which belong to no number.
std::size_t last_joint(std::string_view text, std::size_t end) {
  std::size_t at = text.find_last_of(",{}/:", end - 1);
  if (at != std::string_view::npos) return at;
  for (at = end; at-- > 0;) {
    const bool between_letters = at > 0 && is_letter(text[at - 1]) && at + 1 < text.size() && is_letter(text[at + 1]);
    if (((text[at] == '-' || text[at] == '.') && between_letters) || text[at] == '=') return at;
  }
  return std::string_view::npos;
}

/// The text in pieces of at most `first` characters, then of at most `rest`. @pre both are positive
std::vector<std::string> broken(std::string_view text, std::size_t first, std::size_t rest) {
  std::vector<std::string> pieces;
  for (std::size_t room = first; character_count(text) > room; room = rest) {
    const std::size_t end = bytes_of(text, room);
    const std::size_t blank = text.rfind(' ', end);
    const std::size_t joint = last_joint(text, end);
    std::size_t length = end;
    if (blank != std::string_view::npos && blank > text.find_first_not_of(' ')) {
      length = blank;
    } else if (joint != std::string_view::npos) {
      length = joint + 1;
    }
    pieces.emplace_back(text.substr(0, length));
    text.remove_prefix(std::min(text.find_first_not_of(' ', length), text.size()));
  }
  pieces.emplace_back(text);
  return pieces;
}

}  // namespace

std::string three_digits(double value) {
  if (value < 9.995) return fmt::format("{:.2f}", value);
  if (value < 99.95) return fmt::format("{:.1f}", value);
  return fmt::format("{:.0f}", value);
}

std::string format_seconds(double seconds) {
  if (!std::isfinite(seconds)) return "-";
  constexpr std::pair<const char*, double> kUnits[] = {{"s", 1}, {"ms", 1e-3}, {"µs", 1e-6}, {"ns", 1e-9}};
  const auto* unit = std::begin(kUnits);
  while (unit != std::end(kUnits) - 1 && !(seconds >= 0.9995 * unit->second)) ++unit;
  return three_digits(seconds / unit->second) + " " + unit->first;
}

std::string format_count(std::int64_t count) {
  std::string digits = std::to_string(count);
  const std::ptrdiff_t first = digits.front() == '-' ? 1 : 0;
  for (std::ptrdiff_t at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > first; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), 1, ',');
  }
  return digits;
}

std::string format_error(double value) { return std::isnan(value) ? "-" : fmt::format("{:.2e}", value); }

std::size_t character_count(std::string_view text) {
  return text.size() - static_cast<std::size_t>(std::count_if(text.begin(), text.end(), continues_character));
}

std::string first_characters(const std::string& text, std::size_t characters) {
  return text.substr(0, bytes_of(text, characters));
}

std::string folded(const std::string& text, int width, std::size_t hanging) {
  if (width == kUnlimited) return text;
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t room = room_behind(width, indent);
    const std::vector<std::string> pieces = broken(line.substr(indent), room, room_behind(width, indent + hanging));
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (i > 0) result += "\n";
      if (!pieces[i].empty()) result += std::string(indent + (i > 0 ? hanging : 0), ' ') + pieces[i];
    }
    if (end < text.size()) result += "\n";
    begin = end + 1;
  }
  return result;
}

std::string counted_noun(std::size_t count, const char* noun) {
  return fmt::format("{} {}{}", format_count(static_cast<std::int64_t>(count)), noun, count == 1 ? "" : "s");
}

void TextTable::add_row(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = printable(cell);
  cells.resize(columns_.size());
  rows_.push_back({std::move(cells), ""});
}

void TextTable::add_line(std::string text) { rows_.push_back({{}, printable(text)}); }

std::size_t TextTable::natural_width(std::size_t column) const {
  std::size_t widest = character_count(columns_[column].title);
  for (const Row& row : rows_) {
    if (!row.cells.empty()) widest = std::max(widest, character_count(row.cells[column]));
  }
  return widest;
}

std::vector<TextTable::Shown> TextTable::layout(int width) const {
  std::vector<Shown> shown;
  for (std::size_t i = 0; i < columns_.size(); ++i) shown.push_back({i, natural_width(i)});
  if (width == kUnlimited) return shown;
  const auto limit = static_cast<std::size_t>(width);
  const auto total = [&shown] {
    std::size_t sum = 2 * (shown.size() - 1);
    for (const Shown& each : shown) sum += each.width;
    return sum;
  };
  /// How far a column can be narrowed still.
  const auto slack = [this](const Shown& each) {
    const Column& column = columns_[each.column];
    return column.align == Align::kLeft && each.width > column.narrowest ? each.width - column.narrowest : 0;
  };
  while (true) {
    std::size_t slack_of_all = 0;
    for (const Shown& each : shown) slack_of_all += slack(each);
    if (total() <= limit + slack_of_all) break;
    const auto least = std::max_element(shown.begin(), shown.end(), [this](const Shown& a, const Shown& b) {
      return columns_[a.column].rank < columns_[b.column].rank;
    });
    if (columns_[least->column].rank == 0) break;
    shown.erase(least);
  }
  for (std::size_t sum = total(); sum > limit; --sum) {  // the widest gives first
    const auto widest = std::max_element(shown.begin(), shown.end(), [&slack](const Shown& a, const Shown& b) {
      return (slack(a) > 0 ? a.width : 0) < (slack(b) > 0 ? b.width : 0);
    });
    if (slack(*widest) == 0) break;
    --widest->width;
  }
  return shown;
}

std::string TextTable::row_text(const std::vector<Shown>& shown, const std::vector<std::string>& cells) const {
  std::vector<std::vector<std::string>> pieces;
  std::size_t height = 1;
  for (const Shown& each : shown) {
    pieces.push_back(broken(cells[each.column], each.width, each.width));
    height = std::max(height, pieces.back().size());
  }
  std::string text;
  for (std::size_t row = 0; row < height; ++row) {
    std::string line;
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const std::string piece = row < pieces[i].size() ? pieces[i][row] : "";
      const std::string padding(shown[i].width - character_count(piece), ' ');
      if (i > 0) line += "  ";
      line += columns_[shown[i].column].align == Align::kLeft ? piece + padding : padding + piece;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string TextTable::text(int width) const {
  const std::vector<Shown> shown = layout(width);
  std::vector<std::string> titles;
  std::vector<std::string> rule;
  for (const Column& column : columns_) titles.push_back(column.title);
  rule.resize(columns_.size());
  for (const Shown& each : shown) rule[each.column] = std::string(each.width, '-');
  std::string text = row_text(shown, titles) + row_text(shown, rule);
  for (const Row& row : rows_) {
    text += row.cells.empty() ? folded(row.line, width) + "\n" : row_text(shown, row.cells);
  }
  const std::size_t left_out = columns_.size() - shown.size();
  if (left_out > 0)
    text += counted_noun(left_out, "column") + " left out: --wide shows " + (left_out == 1 ? "it\n" : "them\n");
  return text;
}

bool natural_less(const std::string& a, const std::string& b) { return strverscmp(a.c_str(), b.c_str()) < 0; }

}  // namespace lcpbench
