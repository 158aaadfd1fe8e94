#pragma once

#include <cstdint>

#include "native/contact_lemke/friction_state.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Fingerprints of the last bases of a path. A path meets the same basis and entering variable twice only if it breaks
/// a tie differently the second time. It then cycles.
class VisitedBases {
 public:
  static constexpr Count kMost = 64;  ///< longer rounds end at the limit on pivots

  void clear() { count_ = 0; }

  /// Notes a basis. @returns whether it is among the last ones
  bool note(std::uint64_t fingerprint) {
    const Count kept = count_ < kMost ? count_ : kMost;
    bool found = false;
    for (Count k = 0; k < kept; ++k) found = found || fingerprints_[k] == fingerprint;
    fingerprints_[count_++ % kMost] = fingerprint;
    return found;
  }

  /// The columns of the kernel and the bases of active friction determine a basis, whatever their order.
  template <class Scalar>
  static std::uint64_t fingerprint(const Kernel<Scalar>& kernel, const FrictionState& friction, Label entering,
                                   bool is_velocity) {
    std::uint64_t sum = mixed(entering, is_velocity ? 3 : 2);
    for (Count j = 0; j < kernel.order(); ++j) sum += mixed(kernel.column_label(j), 0);
    for (Count k = 0; k < friction.count(); ++k) {
      const Count contact = friction.contact(k);
      sum += mixed(Label{contact, friction.base(contact)}, 1);
    }
    return sum;
  }

 private:
  static std::uint64_t mixed(Label label, std::uint64_t role) {
    std::uint64_t bits = static_cast<std::uint64_t>(label.contact + 1) << 34;
    bits += static_cast<std::uint64_t>(label.direction + 1) << 2;
    bits = (bits + role + 1) * 0x9e3779b97f4a7c15U;
    bits = (bits ^ (bits >> 31)) * 0xbf58476d1ce4e5b9U;
    return bits ^ (bits >> 29);
  }

  Count count_ = 0;
  std::uint64_t fingerprints_[static_cast<std::size_t>(kMost)] = {};
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
