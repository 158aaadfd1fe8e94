#include "study/output/terminal.h"

#include <algorithm>
#include <cstdlib>

#include <sys/ioctl.h>
#include <unistd.h>

namespace lcpbench {
namespace {

constexpr int kWidthWithoutTerminal = 100;
constexpr int kNarrowest = 40;
constexpr int kWidest = 10'000;
constexpr auto kSilence = std::chrono::milliseconds(500);

bool is_width_lifted = false;

/// 0 where COLUMNS says no number of columns.
int width_of_environment() {
  const char* text = std::getenv("COLUMNS");
  const long columns = text != nullptr ? std::strtol(text, nullptr, 10) : 0;
  return columns > 0 && columns <= kWidest ? static_cast<int>(columns) : 0;
}

/// 0 where the stream is no terminal, or one that does not know its size.
int width_of_terminal(std::FILE* stream) {
  struct winsize size {};
  return ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

}  // namespace

std::string shell_word(const std::string& word) {
  const bool plain =
      !word.empty() &&
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=+.,:/@%") ==
          std::string::npos;
  if (plain) return word;
  if (printable(word) == word) {
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
    return text + "'";
  }
  std::string text = "$'";
  for (const char c : word) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\'' || c == '\\') text += '\\';
    if (byte < 0x20 || byte >= 0x7f) {
      text += fmt::format("\\{:03o}", byte);
    } else {
      text += c;
    }
  }
  return text + "'";
}

std::string file_argument(const std::string& file) { return file.starts_with('-') ? "./" + file : file; }

int terminal_width(std::FILE* stream) {
  int width = width_of_environment();
  if (width == 0) width = width_of_terminal(stream);
  if (width == 0) width = kWidthWithoutTerminal;
  return std::max(width, kNarrowest);
}

int text_width() { return is_width_lifted ? kUnlimited : terminal_width(); }
void lift_text_width() { is_width_lifted = true; }

ProgressLine::ProgressLine()
    : is_on_terminal_(isatty(STDERR_FILENO) == 1), silent_until_(std::chrono::steady_clock::now() + kSilence) {}

void ProgressLine::show(const std::string& text) {
  if (is_on_terminal_) {
    const auto room = static_cast<std::size_t>(terminal_width(stderr)) - 1;  // a full line would wrap the cursor
    std::fputs(("\r\033[K" + first_characters(printable(text), room)).c_str(), stderr);
  } else {
    if (begun_ || std::chrono::steady_clock::now() < silent_until_) return;
    say(stderr, "{}\n", printable(text));
  }
  begun_ = true;
  std::fflush(stderr);
}

void ProgressLine::begin(const std::string& text) {
  silent_until_ = {};
  show(text);
}

void ProgressLine::clear() const {
  if (!is_on_terminal_ || !begun_) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
}

}  // namespace lcpbench
