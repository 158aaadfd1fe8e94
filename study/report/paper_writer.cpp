#include "study/report/paper_writer.h"

#include <algorithm>

#include <fmt/format.h>

#include "study/report/text.h"

namespace lcpbench::report {

namespace {

/// Applies `plain` to the text outside backticks and `code` to that between them.
template <class Plain, class Code>
std::string inline_text(const std::string& text, Plain plain, Code code) {
  std::string out;
  std::size_t at = 0;
  bool in_code = false;
  while (at <= text.size()) {
    const std::size_t end = std::min(text.find('`', at), text.size());
    const std::string part = text.substr(at, end - at);
    out += in_code ? code(part) : plain(part);
    in_code = !in_code;
    at = end + 1;
  }
  return out;
}

std::string html(const std::string& text) {
  return inline_text(
      text, [](const std::string& part) { return escape(part); },
      [](const std::string& part) { return report::code(part); });
}

std::string with_backslashes(const std::string& text, std::string_view characters) {
  std::string out;
  for (const char c : mended(text)) {
    if (characters.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string markdown(const std::string& text) {
  return inline_text(
      text, [](const std::string& part) { return with_backslashes(part, "\\*_<>|[]#"); },
      [](const std::string& part) { return "`" + with_backslashes(part, "|") + "`"; });
}

/// Numbers stand to the right and are not broken; words, such as the reason of a missing run, are neither.
bool is_number(const std::string& text) {
  constexpr std::string_view kOfNumbers = "0123456789.+-/<>() e–";
  return text == "–" || (text.find_first_of("0123456789") != std::string::npos &&
                         text.find_first_not_of(kOfNumbers) == std::string::npos);
}

bool is_number_column(const paper::Layout& layout, std::size_t column) {
  return column >= layout.labels && std::any_of(layout.rows.begin(), layout.rows.end(),
                                                [column](const auto& row) { return is_number(row[column].text); });
}

std::string html_entry(const paper::Entry& entry, bool label) {
  constexpr std::size_t kSentence = 24;  // columns of numbers must not squeeze a sentence into a word per line
  const std::string detail = entry.detail.empty() ? "" : "<small>" + html(entry.detail) + "</small>";
  const bool number = !label && is_number(entry.text);
  const std::string attributes = number                                          ? " class=\"number\""
                                 : entry.text.size() + detail.size() > kSentence ? " class=\"words\""
                                                                                 : "";
  const char* tag = label ? "th" : "td";
  return fmt::format("<{}{}{}>{}{}</{}>", tag, label ? " scope=\"row\"" : "", attributes, html(entry.text), detail,
                     tag);
}

std::string markdown_entry(const paper::Entry& entry) {
  return markdown(entry.text) + (entry.detail.empty() ? "" : "<br><sub>" + markdown(entry.detail) + "</sub>");
}

std::string html_table(const paper::Layout& layout) {
  std::vector<Column> columns;
  for (std::size_t i = 0; i < layout.columns.size(); ++i) {
    columns.push_back({html(layout.columns[i]), is_number_column(layout, i)});
  }
  std::string table = table_head("paper", columns, html(layout.caption));
  for (const auto& row : layout.rows) {
    table += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) table += html_entry(row[i], i < layout.labels);
    table += "</tr>\n";
  }
  return table + kTableEnd;
}

std::string markdown_table(const paper::Layout& layout) {
  std::string table = "**" + markdown(layout.caption) + "**\n\n|";
  for (const std::string& column : layout.columns) table += " " + markdown(column) + " |";
  table += "\n|";
  for (std::size_t i = 0; i < layout.columns.size(); ++i) table += is_number_column(layout, i) ? " ---: |" : " --- |";
  table += "\n";
  for (const auto& row : layout.rows) {
    table += "|";
    for (const paper::Entry& entry : row) table += " " + markdown_entry(entry) + " |";
    table += "\n";
  }
  return table + "\n";
}

}  // namespace

void PaperWriter::heading(int level, const std::string& anchor, const std::string& text) {
  if (!html_) {
    text_ += std::string(static_cast<std::size_t>(level) + 1, '#') + " " + markdown(text) + "\n\n";
    return;
  }
  const int rank = level + 1;
  const bool part = level == 1;
  if (part && !text_.empty()) text_ += "</details>\n";
  text_ += fmt::format("<h{}{}>{}</h{}>\n", rank, anchor.empty() ? "" : " id=\"" + anchor + "\"", html(text), rank);
  if (part) text_ += "<details><summary>Show this part</summary>\n";
}

void PaperWriter::paragraph(const std::string& text) {
  text_ += html_ ? "<p>" + html(text) + "</p>\n" : markdown(text) + "\n\n";
}

void PaperWriter::table(const paper::Layout& layout) { text_ += html_ ? html_table(layout) : markdown_table(layout); }

void PaperWriter::query(const std::string& sql) {
  const std::string block = html_ ? "<div class=\"scroll\" tabindex=\"0\"><pre>" + report::code(sql) + "</pre></div>"
                                  : "\n\n```sql\n" + sql + "\n```\n\n";
  text_ += "<details><summary>SQL that repeats the counts on the store</summary>" + block + "</details>" + gap();
}

void PaperWriter::figure(const std::string& file, const Figure& figure) {
  text_ += html_ ? "<p><a href=\"" + escape(file) + "\">" + escape(figure.alternative) + "</a></p>\n"
                 : "![" + markdown(figure.alternative) + "](" + file + ")\n\n";
}

void PaperWriter::open(const std::string& summary) {
  text_ += "<details><summary>" + html(summary) + "</summary>" + gap();
}

void PaperWriter::close() { text_ += std::string("</details>") + gap(); }

}  // namespace lcpbench::report
