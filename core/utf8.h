#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lcpbench {

/// Length in bytes of the well-formed UTF-8 sequence that starts at `at`, 0 for none: overlong forms, surrogates and
/// what lies beyond U+10FFFF are not well formed. [RFC 3629] @pre at < text.size()
std::size_t utf8_length(std::string_view text, std::size_t at);

/// Whether the whole text is well-formed UTF-8.
bool is_utf8(std::string_view text);

/// The text with an escape for every character that cannot be seen: the default ignorable ones of Unicode, among them
/// those for text direction (U+202E), the line breaks U+2028 and U+2029, and the controls U+007F to U+009F. The escape
/// is JSON's, "\u202e", with `backslash` for its backslash. Bytes outside of well-formed UTF-8 stay.
std::string visible(std::string_view text, std::string_view backslash = "\\");

/// The text with '?' for every control character (U+0000 to U+001F, U+007F to U+009F) that is not in `kept`, and for
/// every byte outside of well-formed UTF-8, and the others visible(): so a text cannot command a terminal, nor pass for
/// another one.
std::string printable(std::string_view text, std::string_view kept = {});

}  // namespace lcpbench
