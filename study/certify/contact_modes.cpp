#include "study/certify/contact_modes.h"

#include <utility>

namespace lcpbench::exact {
namespace {

using Basis = std::vector<Index>;

// What contact i may do.
std::vector<Basis> modes(const ContactLayout& layout, Index i) {
  const auto at = static_cast<std::size_t>(i);
  const Index begin = layout.friction_offset() + layout.friction_begin[at];
  const Index edges = layout.friction_begin[at + 1] - layout.friction_begin[at];
  std::vector<Basis> result{{}};
  if (edges == 0) result.push_back({i});
  const Index lambda = layout.lambda_offset() + layout.lambda[at];
  for (Index t = 0; t < edges; ++t) {
    result.push_back({begin + t, lambda});
    result.push_back({i, begin + t, lambda});
    Basis stick{i, begin + t};
    if (edges > 2) stick.push_back(begin + (t + 1) % edges);
    result.push_back(stick);
  }
  return result;
}

}  // namespace

std::vector<Basis> contact_modes(const ContactProblem& problem, std::size_t limit) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Basis> all{{}};
  for (Index i = 0; i < layout.nc; ++i) {
    const std::vector<Basis> own = modes(layout, i);
    if (all.size() * own.size() > limit) return {};
    std::vector<Basis> longer;
    for (const Basis& basis : all) {
      for (const Basis& mode : own) {
        longer.push_back(basis);
        longer.back().insert(longer.back().end(), mode.begin(), mode.end());
      }
    }
    all = std::move(longer);
  }
  return all;
}

}  // namespace lcpbench::exact
