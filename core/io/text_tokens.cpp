#include "core/io/text_tokens.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"

namespace lcpbench {
namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Whether a decimal that does not fit a double is too small for it rather than too large: its leading digit stands
/// right of the decimal point by more than the exponent moves it left.
bool underflows(std::string_view unsigned_decimal) {
  const auto exponent_at = unsigned_decimal.find_first_of("eE");
  const std::string_view mantissa = unsigned_decimal.substr(0, exponent_at);
  const auto lead = static_cast<std::int64_t>(mantissa.find_first_not_of("0."));
  const auto point = static_cast<std::int64_t>(std::min(mantissa.find('.'), mantissa.size()));
  if (exponent_at == std::string_view::npos) return lead > point;
  std::string_view exponent_text = unsigned_decimal.substr(exponent_at + 1);
  const bool negative = exponent_text.starts_with('-');
  if (negative || exponent_text.starts_with('+')) exponent_text.remove_prefix(1);
  std::int64_t exponent = 0;
  const auto [end, error] =
      std::from_chars(exponent_text.data(), exponent_text.data() + exponent_text.size(), exponent);
  if (error != std::errc()) return negative;
  return (negative ? -exponent : exponent) < lead - point;  // a difference of places overflows in no text
}

}  // namespace

std::optional<double> parse_decimal(std::string_view text) {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  // from_chars would take a second sign, and words: "inf", "nan(...)".
  if (text.empty() || !(text.front() == '.' || (text.front() >= '0' && text.front() <= '9'))) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    if (!underflows(text)) return std::nullopt;
    value = 0;
  } else if (error != std::errc() || !std::isfinite(value)) {
    return std::nullopt;
  }
  return negative ? -value : value;
}

std::string_view TextTokens::next() {
  while (position_ < text_.size() && is_space(text_[position_])) ++position_;
  token_begin_ = position_;
  while (position_ < text_.size() && !is_space(text_[position_])) ++position_;
  return text_.substr(token_begin_, position_ - token_begin_);
}

std::string_view TextTokens::line() {
  token_begin_ = position_;
  const std::size_t end = std::min(text_.find('\n', position_), text_.size());
  position_ = std::min(end + 1, text_.size());
  return text_.substr(token_begin_, end - token_begin_);
}

void TextTokens::skip_comments(char mark) {
  while (position_ < text_.size()) {
    const std::size_t begin = position_;
    const std::string_view text = line();
    if (text.starts_with(mark) || std::all_of(text.begin(), text.end(), is_space)) continue;
    position_ = begin;
    return;
  }
}

std::string_view TextTokens::required(std::string_view field) {
  const std::string_view token = next();
  if (token.empty()) fail(field, "truncated: the file ends here");
  return token;
}

double TextTokens::real(std::string_view field) {
  const std::string_view token = required(field);
  const std::optional<double> value = parse_decimal(token);
  if (!value) fail(field, "expected a finite number, found " + in_quotes(token));
  return *value;
}

std::int64_t TextTokens::count(std::string_view field, std::int64_t max) {
  const std::string_view token = required(field);
  std::int64_t value = -1;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
  if (error != std::errc() || end != token.data() + token.size() || value < 0 || value > max) {
    fail(field, "expected an integer from 0 to " + std::to_string(max) + ", found " + in_quotes(token));
  }
  return value;
}

void TextTokens::fail(std::string_view field, const std::string& message) const {
  throw input_error(origin_, std::string(field) + ": " + message + " (" + line_and_column(text_, token_begin_) + ")");
}

}  // namespace lcpbench
