#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace lcpbench {

/// Splits a text of white-space separated words and reads numbers from them, for formats whose numbers may stand on
/// lines in any way. line() and skip_comments() are for a header that has lines. Views the text; it must outlive the
/// reader. Every error names the file, the field asked for, and the line.
class TextTokens {
 public:
  TextTokens(std::string_view text, std::string origin) : text_(text), origin_(std::move(origin)) {}

  /// The next word, "" at the end of the text.
  std::string_view next();

  /// The next word as a finite double, correctly rounded. @throws InputError
  double real(std::string_view field);

  /// The next word as an integer in [0, max]. @throws InputError
  std::int64_t count(std::string_view field, std::int64_t max);

  /// An upper bound on the numbers still to come: each takes a digit and a separator.
  std::size_t numbers_left() const { return (text_.size() - position_ + 1) / 2; }

  /// The rest of the present line, without its end; goes to the next one.
  std::string_view line();

  /// Goes past blank lines and lines that begin with `mark`. @pre at the beginning of a line
  void skip_comments(char mark);

  /// @throws InputError, which names the line of the word or line that was read last
  [[noreturn]] void fail(std::string_view field, const std::string& message) const;

 private:
  std::string_view required(std::string_view field);

  std::string_view text_;
  std::string origin_;
  std::size_t position_ = 0;
  std::size_t token_begin_ = 0;
};

/// A decimal number, correctly rounded: underflow gives a signed zero. nullopt when `text` is no number, or one beyond
/// the range of double. An optional sign may lead.
std::optional<double> parse_decimal(std::string_view text);

}  // namespace lcpbench
