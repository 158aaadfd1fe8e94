#include "core/utf8.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <iterator>

namespace lcpbench {
namespace {

/// 0: no well-formed sequence starts with this byte. 80 to BF continue one, C0 and C1 would start overlong forms, F5 to
/// FF values beyond U+10FFFF or nothing.
std::size_t length_by_first_byte(unsigned char first) {
  if (first < 0x80) return 1;
  if (first < 0xC2) return 0;
  if (first < 0xE0) return 2;
  if (first < 0xF0) return 3;
  return first < 0xF5 ? 4 : 0;
}

/// The first byte of the control characters U+0080 to U+009F, which have two bytes.
constexpr char kFirstOfLongControls = '\xC2';

/// @pre one well-formed character
bool is_control(std::string_view character) {
  const auto last = static_cast<unsigned char>(character.back());
  if (character.size() == 1) return last < 0x20 || last == 0x7F;
  return character.size() == 2 && character.front() == kFirstOfLongControls && last < 0xA0;
}

struct CodeRange {
  std::uint32_t first, last;
};

/// Default_Ignorable_Code_Point of Unicode 15 [DerivedCoreProperties.txt], the controls from U+007F on, line and
/// paragraph separator, and the marks of annotations.
constexpr CodeRange kInvisible[]{
    {0x7F, 0x9F},     {0xAD, 0xAD},     {0x34F, 0x34F},   {0x61C, 0x61C},     {0x115F, 0x1160},   {0x17B4, 0x17B5},
    {0x180B, 0x180F}, {0x200B, 0x200F}, {0x2028, 0x202E}, {0x2060, 0x206F},   {0x3164, 0x3164},   {0xFE00, 0xFE0F},
    {0xFEFF, 0xFEFF}, {0xFFA0, 0xFFA0}, {0xFFF0, 0xFFFB}, {0x1BCA0, 0x1BCA3}, {0x1D173, 0x1D17A}, {0xE0000, 0xE0FFF}};

/// @pre one well-formed character
std::uint32_t code_point(std::string_view character) {
  const auto first = static_cast<unsigned char>(character.front());
  std::uint32_t code = character.size() == 1 ? first : first & (0x7FU >> character.size());
  for (const char c : character.substr(1)) code = code << 6 | (static_cast<unsigned char>(c) & 0x3FU);
  return code;
}

/// @pre one well-formed character
bool is_invisible(std::string_view character) {
  const std::uint32_t code = code_point(character);
  return std::any_of(std::begin(kInvisible), std::end(kInvisible),
                     [code](const CodeRange& range) { return range.first <= code && code <= range.last; });
}

}  // namespace

std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  const std::size_t length = length_by_first_byte(first);
  if (length == 1) return 1;
  if (length == 0 || length > text.size() - at) return 0;
  for (std::size_t i = at + 1; i < at + length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  const unsigned char second = byte(at + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate_or_beyond = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  return overlong || surrogate_or_beyond ? 0 : length;
}

bool is_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

std::string visible(std::string_view text, std::string_view backslash) {
  std::string shown;
  shown.reserve(text.size());
  const auto add_unit = [&](std::uint32_t unit) {
    char digits[6];
    std::snprintf(digits, sizeof digits, "u%04x", unit & 0xFFFFU);
    shown.append(backslash).append(digits);
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    const std::string_view character = text.substr(at, length > 0 ? length : 1);
    at += character.size();
    if (length == 0 || (length == 1 && character.front() != '\x7F') || !is_invisible(character)) {
      shown += character;
      continue;
    }
    const std::uint32_t code = code_point(character);
    if (code > 0xFFFF) add_unit(0xD800 + ((code - 0x10000) >> 10));  // a pair, as in UTF-16
    add_unit(code > 0xFFFF ? 0xDC00 + (code & 0x3FF) : code);
  }
  return shown;
}

std::string printable(std::string_view text, std::string_view kept) {
  std::string shown;
  shown.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    const std::string_view character = text.substr(at, length);
    const bool stays = length > 0 && (!is_control(character) || kept.find(character) != std::string_view::npos);
    shown += stays ? character : "?";
    at += length > 0 ? length : 1;
  }
  return visible(shown);
}

}  // namespace lcpbench
