#include "core/utf8.h"

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
  return shown;
}

}  // namespace lcpbench
