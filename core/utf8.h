#pragma once

#include <cstddef>
#include <string_view>

namespace lcpbench {

/// Length of the well-formed UTF-8 sequence that starts at `at`, 0 for none: overlong forms, surrogates and what lies
/// beyond U+10FFFF are not well formed. [RFC 3629] @pre at < text.size()
std::size_t utf8_length(std::string_view text, std::size_t at);

}  // namespace lcpbench
