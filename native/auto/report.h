#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "core/solver.h"

namespace lcpbench {

/// What `auto` chooses among for contacts.
enum class AutoMethod {
  kActiveSet, kContactLemke, kVelocityIpm, kFrictionIpm, kPsor, kProximalNewton, kOverRelaxedPsor };
inline constexpr std::size_t kAutoMethods = 7;

/// What was done for one answer, over all islands. Its text is written without allocating where the string has room.
class AutoReport {
 public:
  Index islands = 0;
  Index at_rest = 0;  ///< islands of which no contact approaches: not solved
  Index least_energy = 0;  ///< islands that the impulses of least energy solve
  Index sticking = 0;          ///< islands of which the contacts of the last step hold

  /// Counts a run of a method.
  void count(AutoMethod method) { ++runs_[static_cast<std::size_t>(method)]; }
  /// Counts its work and stage in.
  void add(const Counters& counters, std::string_view stage);

  const Counters& counters() const { return counters_; }

  /// "contact_lemke, double"; where there are more islands "7 islands, 3 at rest; active_set 3, contact_lemke 1;
  /// double".
  void write_text(std::string& text) const;

 private:
  Counters counters_{.iterations = 0, .pivots = 0, .factorizations = 0};
  std::array<Index, kAutoMethods> runs_{};
  int stage_ = 0;
};

}  // namespace lcpbench
