#pragma once

#include <string>

#include "study/paper/tables.h"
#include "study/report/figures.h"

namespace lcpbench::report {

/// Writes the paper's pages in one of two formats. Texts are plain, with `backticks` around code; the writer escapes
/// them.
class PaperWriter {
 public:
  enum class Format {
    kHtml,     ///< for report.html: each part is folded below its heading, the last one left open for the caller
    kMarkdown  ///< for paper.md, as GitHub renders it
  };
  explicit PaperWriter(Format format) : html_(format == Format::kHtml) {}

  /// @param level 1 for a page's parts @param anchor of the heading, "" for none
  void heading(int level, const std::string& anchor, const std::string& text);
  void paragraph(const std::string& text);
  void table(const paper::Layout& layout);
  void query(const std::string& sql);
  /// @param file name below the report's folder
  void figure(const std::string& file, const Figure& figure);
  /// What follows, up to close(), is hidden until it is asked for.
  void open(const std::string& summary);
  void close();

  const std::string& text() const { return text_; }

 private:
  const char* gap() const { return html_ ? "\n" : "\n\n"; }

  bool html_;
  std::string text_;
};

}  // namespace lcpbench::report
