#pragma once

#include <string>

namespace lcpbench {

/// Less, where runs of digits compare as numbers: exp5-1e5 before exp5-1e10.
bool natural_less(const std::string& a, const std::string& b);

}  // namespace lcpbench
