#include "study/report/failure_strip.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "study/report/axes.h"
#include "study/report/speed_error.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

constexpr double kRowHeight = 19;
constexpr double kHeadingHeight = 30;
constexpr double kLineHeight = 16;
constexpr std::size_t kLineLimit = 128;

void draw_bar(Canvas& canvas, double left, double y, double full_width, double share, const char* color) {
  const double width = std::max(share > 0 ? 1.5 : 0.0, share * full_width);
  canvas.line(left, y - 7, left, y + 7, kAxis, 1);
  if (width > 0) canvas.rectangle({left, y - 6, left + width, y + 6}, color);
  canvas.text(left + width + 5, y, percent(share),
              {.size = kLabelSize, .color = share > 0 ? kInk : kSoft, .bold = share > 0});
}

}  // namespace

FailureStrip::FailureStrip(const Summary& summary, const std::vector<const Cell*>& cells) {
  std::string faultless;
  for (const Cell* cell : cells) {
    const auto of_trials = [cell](std::int64_t count) {
      return static_cast<double>(count) / static_cast<double>(cell->trials);
    };
    Row row{rung_label(summary, *cell), of_trials(cell->false_claims()), of_trials(cell->gave_up())};
    if (row.wrong + row.gave_up > 0) {
      rows_.push_back(std::move(row));
    } else {
      faultless += (faultless.empty() ? "" : ", ") + row.label;
    }
  }
  std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) {
    return std::pair(a.wrong, a.gave_up) < std::pair(b.wrong, b.gave_up);
  });
  if (!faultless.empty()) lines_ = lines_of("No failure seen: " + faultless, kLineLimit);
}

double FailureStrip::height() const {
  const double rows = rows_.empty() ? 0 : kHeadingHeight + kRowHeight * static_cast<double>(rows_.size());
  return rows + kLineHeight * static_cast<double>(lines_.size());
}

void FailureStrip::draw(Canvas& canvas, double top) const {
  double y = top + kLineHeight / 2;
  for (const std::string& line : lines_) {
    canvas.text(kMargin, y, line, {.size = 11.5, .color = kSoft});
    y += kLineHeight;
  }
  if (rows_.empty()) return;
  struct Column {
    const char* heading;
    const char* color;
    double Row::*share;
  };
  constexpr std::array<Column, 2> columns{
      {{"said solved, was wrong", kWrong, &Row::wrong}, {"gave up", kGrey, &Row::gave_up}}};

  std::size_t longest = 0;
  for (const Row& row : rows_) longest = std::max(longest, character_count(row.label));
  const double names_end = kMargin + static_cast<double>(longest) * kLabelSize * kMonospaceWidth + 4;
  const double column_width = (kWidth - names_end - kMargin) / static_cast<double>(columns.size());
  const double first_row = y + kHeadingHeight - kLineHeight / 2;
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const double left = names_end + 10 + static_cast<double>(column) * column_width;
    canvas.text(left, y + 4, columns[column].heading, {.color = columns[column].color, .bold = true});
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      draw_bar(canvas, left, first_row + kRowHeight * static_cast<double>(i), column_width - 75,
               rows_[i].*columns[column].share, columns[column].color);
    }
  }
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    canvas.text(names_end, first_row + kRowHeight * static_cast<double>(i), rows_[i].label,
                {.align = Align::kRight, .monospace = true});
  }
}

std::vector<std::string> lines_of(const std::string& text, std::size_t limit) {
  std::vector<std::string> lines{""};
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t comma = text.find(", ", begin);
    const std::size_t end = comma == std::string::npos ? text.size() : comma + 2;
    const std::string word = text.substr(begin, end - begin);
    const bool full = character_count(lines.back()) + character_count(word) > limit;
    if (full && !lines.back().empty()) lines.emplace_back();
    lines.back() += word;
    begin = end;
  }
  return lines;
}

}  // namespace lcpbench::report
