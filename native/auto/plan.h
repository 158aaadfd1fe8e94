#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

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
  /// friction_ipm, briefly.
  void add_rounds(std::int64_t rounds) {
    tries_[size_++] = {.method = AutoMethod::kFrictionIpm, .brief = true, .rounds = rounds};
  }
  /// psor, briefly. @param exact see AutoTry
  void add_sweeps(std::int64_t sweeps, bool exact) {
    tries_[size_++] = {.method = AutoMethod::kPsor, .brief = true, .sweeps = sweeps, .exact = exact};
  }
  /// psor in full. @param exact see AutoTry
  void add_psor(bool exact) { tries_[size_++] = {.method = AutoMethod::kPsor, .exact = exact}; }
  const AutoTry* begin() const { return tries_.data(); }
  const AutoTry* end() const { return tries_.data() + size_; }
  const AutoTry& front() const { return tries_.front(); }

 private:
  std::array<AutoTry, 7> tries_{};
  std::size_t size_ = 0;
};

/// Sweeps of psor that take a third of the estimated time of the sparse method, by the size of the island's separators.
/// 0 where they are too few, or where no sparse method comes first.
std::int64_t worthwhile_sweeps(const AutoSettings& settings, const Problem& problem);

/// The rules of docs/reference/solvers/auto.md. @param v the velocity now @param sweeps worthwhile_sweeps of the
/// problem @param idle coordinates that no contact moves, which do not count
AutoPlan plan_for(const AutoSettings& settings, const Problem& problem, const Vector& v, std::int64_t sweeps,
                  Index idle);

/// Whether a solve from a start tries HeldContacts before the plan: frictional islands from a size on. Where the guess
/// is wrong, which a slipping contact in the start tells at once, that costs a small part of what follows.
/// @param is_loaded the first method of the plan is
bool friction_may_hold(const ContactProblem& contact, bool is_loaded);

/// Whether a dense method can be loaded in a solve: it takes the problem, and memory for it can be taken in advance.
bool fits_in_advance(AutoMethod method, const Problem& problem);

}  // namespace lcpbench
