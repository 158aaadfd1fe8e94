#pragma once

#include <span>
#include <string>
#include <string_view>

namespace lcpbench {

/// " (did you mean 'lemke'?)" for the known name that a misspelt one is closest to; "" where none is close. Allowed is
/// one slip for each three letters, at least one and at most three. A slip is a letter that is wrong, missing or too
/// many, or two neighbours that changed places. Of equally close names the first counts.
std::string did_you_mean(std::string_view word, std::span<const std::string> known);

}  // namespace lcpbench
