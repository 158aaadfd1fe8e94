#include "native/auto/report.h"

#include <algorithm>
#include <array>

namespace lcpbench {
namespace {

constexpr std::array<const char*, 3> kStages{"double", "refined", "quad"};

/// In the order of AutoMethod.
constexpr std::array<std::string_view, kAutoMethods> kMethods{
    "active_set", "contact_lemke", "velocity_ipm", "friction_ipm", "psor", "contact_ipm"};

/// Index into kStages. Any other text of a solved answer names a later stage in double, such as "reinverted".
int stage_of(std::string_view detail) {
  if (detail.starts_with("quad")) return 2;
  return detail.empty() || detail == "warm" ? 0 : 1;
}

}  // namespace

void AutoReport::add(const Counters& counters, std::string_view stage) {
  is_known_ = is_known_ && counters != Counters{};
  counters_.iterations += std::max<std::int64_t>(counters.iterations, 0);
  counters_.pivots += std::max<std::int64_t>(counters.pivots, 0);
  counters_.factorizations += std::max<std::int64_t>(counters.factorizations, 0);
  stage_ = std::max(stage_, stage_of(stage));
}

void AutoReport::write_text(std::string& text) const {
  text.clear();
  const bool plain = islands == 1 && at_rest == 0;
  if (!plain) {
    text += std::to_string(islands);
    text += islands == 1 ? " island" : " islands";
    if (at_rest > 0) {
      (text += ", ") += std::to_string(at_rest);
      text += " at rest";
    }
  }
  const char* separator = plain ? "" : "; ";
  bool has_methods = false;
  const auto add_method = [&](std::string_view method, Index runs) {
    if (runs == 0) return;
    (text += separator) += method;
    if (!plain) (text += ' ') += std::to_string(runs);
    separator = ", ";
    has_methods = true;
  };
  add_method("sticking_contacts", sticking);
  add_method("least_energy", least_energy);
  for (std::size_t k = 0; k < kAutoMethods; ++k) add_method(kMethods[k], runs_[k]);
  if (has_methods) (text += plain ? ", " : "; ") += kStages[static_cast<std::size_t>(stage_)];
}

}  // namespace lcpbench
