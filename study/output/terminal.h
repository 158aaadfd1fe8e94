#pragma once

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/utf8.h"
#include "study/output/text_table.h"

namespace lcpbench {

/// Prints text that may repeat foreign words: names of files, sets and solvers, messages of libraries, what a store
/// holds. Every control character but the line end, and every byte that is not UTF-8, becomes '?', so that no name
/// commands the terminal.
template <class... Values>
void say(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = printable(fmt::format(format, std::forward<Values>(values)...), "\n");
  if (stream == stderr) {
    std::fputs(text.c_str(), stderr);  // where that fails, nobody is left to be told
  } else {
    fmt::print(stream, "{}", text);
  }
}

/// A word as a shell takes it: in single quotes where that is needed, in bash's $'...' where it holds control
/// characters or bytes that are not UTF-8. It stands in one line and commands no terminal.
std::string shell_word(const std::string& word);

/// A file's name as a command takes it: "-o.json" would be an option, "./-o.json" is the file.
std::string file_argument(const std::string& file);

/// How many characters a line for people may have: what COLUMNS says, else the width of the terminal that the stream
/// is, else 100. At least 40, so that a table keeps a shape.
int terminal_width(std::FILE* stream = stdout);

/// How wide a text for people on stdout may be: terminal_width(), or kUnlimited once lift_text_width() was called.
int text_width();
/// For the rest of the process.
void lift_text_width();

/// Prints a text for people to stdout, as `say` does, with the lines folded that are wider than text_width().
template <class... Values>
void say_folded(fmt::format_string<Values...> format, Values&&... values) {
  say(stdout, "{}", folded(fmt::format(format, std::forward<Values>(values)...), text_width()));
}

/// The last lines of a command's text answer the user's question. This is their largest number.
inline constexpr std::size_t kAnswerLines = 25;

/// One line on stderr that says how far a command is. On a terminal it is written over again and again, cut to the
/// terminal's width. Elsewhere one line is printed in all, so that a log says that something goes on, and nothing
/// twice; not before half a second, so that an error found at once stands alone.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine() { clear(); }  // before the words of an exception
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  bool is_on_terminal() const { return is_on_terminal_; }
  void show(const std::string& text);
  /// Shows it without the half second: for a command that does not look at the clock for long.
  void begin(const std::string& text);
  /// Empties the line on a terminal, for what is printed next.
  void clear() const;

 private:
  bool is_on_terminal_;
  bool begun_ = false;
  std::chrono::steady_clock::time_point silent_until_;
};

}  // namespace lcpbench
