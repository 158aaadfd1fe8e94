#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "core/solver.h"

namespace lcpbench {

/// The methods by which `auto` solves contacts.
enum class AutoMethod { kActiveSet, kContactLemke, kVelocityIpm, kFrictionIpm, kPsor, kContactIpm };
inline constexpr std::size_t kAutoMethods = 6;

/// What `auto` did for one answer to a contact problem, over all islands.
class AutoReport {
 public:
  Index islands = 0;
  Index at_rest = 0;       ///< islands solved without impulses: nothing approaches but by rounding
  Index least_energy = 0;  ///< islands answered by LeastEnergy
  Index sticking = 0;      ///< islands answered by StickingContacts

  /// Counts an island on which the method ran.
  void count(AutoMethod method) { ++runs_[static_cast<std::size_t>(method)]; }
  /// Adds work and keeps the highest stage. A counter of -1 adds 0; after Counters{} the work is not known for good.
  /// @param stage  `detail` of an answer of contact_lemke or active_set; "" for other methods
  void add(const Counters& counters, std::string_view stage);

  Counters counters() const { return is_known_ ? counters_ : Counters{}; }

  /// Of one island that is not at rest, the methods that ran and the highest stage: "active_set, contact_lemke, quad";
  /// sticking_contacts and least_energy only if they answered. Otherwise with the number of islands of each one, as in
  /// "7 islands, 3 at rest; active_set 3, contact_lemke 1; double". Allocates only where `text` has too little room.
  void write_text(std::string& text) const;

 private:
  Counters counters_{.iterations = 0, .pivots = 0, .factorizations = 0};
  bool is_known_ = true;  ///< counters_ have all work
  std::array<Index, kAutoMethods> runs_{};
  int stage_ = 0;
};

}  // namespace lcpbench
