#pragma once

#include <string_view>

namespace lcpbench {

/// Whether all of `text` matches a glob: '*' stands for any run of characters, '/' and braces included, '?' for any
/// one, everything else for itself. O(length of pattern times length of text).
bool glob_matches(std::string_view pattern, std::string_view text);

}  // namespace lcpbench
