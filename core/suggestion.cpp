#include "core/suggestion.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace lcpbench {
namespace {

constexpr std::size_t kLongestWord = 200;
constexpr std::size_t kMostSlips = 3;

/// The optimal string alignment distance: the fewest slips between two words. O(a b).
std::size_t slips(std::string_view a, std::string_view b) {
  std::array<std::vector<std::size_t>, 3> rows;  // of the two letters of `a` before, and of the present one
  for (auto& row : rows) row.resize(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) rows[2][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::rotate(rows.begin(), rows.begin() + 1, rows.end());
    rows[2][0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = rows[1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      rows[2][j] = std::min({replaced, rows[1][j] + 1, rows[2][j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) rows[2][j] = std::min(rows[2][j], rows[0][j - 2] + 1);
    }
  }
  return rows[2][b.size()];
}

}  // namespace

std::string did_you_mean(std::string_view word, std::span<const std::string> known) {
  if (word.size() > kLongestWord) return "";
  std::size_t allowed = std::clamp<std::size_t>(word.size() / 3, 1, kMostSlips);
  const std::string* closest = nullptr;
  for (const std::string& name : known) {
    const std::size_t distance = slips(word, name);
    if (distance > allowed || (closest != nullptr && distance == allowed)) continue;
    closest = &name;
    allowed = distance;
  }
  return closest == nullptr ? "" : " (did you mean '" + *closest + "'?)";
}

}  // namespace lcpbench
