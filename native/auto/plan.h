#pragma once

#include <array>
#include <cstddef>

#include "core/problem.h"
#include "native/auto/methods.h"
#include "native/auto/settings.h"

namespace lcpbench {

/// The tries at an island, in their order.
class AutoPlan {
 public:
  /// When the impulses of least energy are tried: before all, or after an answer of contact_lemke that slips.
  enum class Rest { kNotSought, kAfter, kFirst };
  Rest rest = Rest::kNotSought;

  void add(AutoMethod method, bool brief = false) { tries_[size_++] = {.method = method, .brief = brief}; }
  const AutoTry* begin() const { return tries_.data(); }
  const AutoTry* end() const { return tries_.data() + size_; }
  const AutoTry& front() const { return tries_.front(); }

 private:
  std::array<AutoTry, 6> tries_{};
  std::size_t size_ = 0;
};

/// The rules of docs/reference/solvers/auto.md. @param v the velocity now
AutoPlan plan_for(const AutoSettings& settings, const Problem& problem, const Vector& v);

/// Whether a dense method can be loaded in a solve: it takes the problem, and memory for it can be taken in advance.
bool fits_in_advance(AutoMethod method, const Problem& problem);

}  // namespace lcpbench
