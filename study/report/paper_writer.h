#pragma once

#include <string>

#include "study/paper/tables.h"
#include "study/report/figures.h"

namespace lcpbench::report {

/// Writes the paper's pages in one format. Texts are plain, with `backticks` around code; a writer escapes them.
class PaperWriter {
 public:
  virtual ~PaperWriter() = default;

  /// @param level 1 for a page's parts @param anchor of the heading, "" for none
  virtual void heading(int level, const std::string& anchor, const std::string& text) = 0;
  virtual void paragraph(const std::string& text) = 0;
  virtual void table(const paper::Layout& layout) = 0;
  virtual void query(const std::string& sql) = 0;
  /// @param file name below the report's folder
  virtual void figure(const std::string& file, const Figure& figure) = 0;
  /// What follows, up to close(), is hidden until it is asked for.
  virtual void open(const std::string& summary) = 0;
  virtual void close() = 0;

  const std::string& text() const { return text_; }

 protected:
  PaperWriter() = default;
  PaperWriter(const PaperWriter&) = default;
  PaperWriter& operator=(const PaperWriter&) = default;
  std::string text_;
};

/// For report.html. Each part is folded below its heading; the last one is left open for the caller to close.
class HtmlPaperWriter final : public PaperWriter {
 public:
  void heading(int level, const std::string& anchor, const std::string& text) override;
  void paragraph(const std::string& text) override;
  void table(const paper::Layout& layout) override;
  void query(const std::string& sql) override;
  void figure(const std::string& file, const Figure& figure) override;
  void open(const std::string& summary) override;
  void close() override;
};

/// For paper.md, in the Markdown that GitHub renders.
class MarkdownPaperWriter final : public PaperWriter {
 public:
  void heading(int level, const std::string& anchor, const std::string& text) override;
  void paragraph(const std::string& text) override;
  void table(const paper::Layout& layout) override;
  void query(const std::string& sql) override;
  void figure(const std::string& file, const Figure& figure) override;
  void open(const std::string& summary) override;
  void close() override;
};

}  // namespace lcpbench::report
