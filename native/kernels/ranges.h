#pragma once

#include "native/contacts/contact_arrays.h"
#include "native/kernels/pack.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// Parts of the coordinates that the inertia does not couple: consecutive blocks, together kLeastRange coordinates or
/// more.
template <class Scalar>
class Ranges {
 public:
  /// Coordinates first to end - 1. The packs that hold them are entries first_of_packs to end_of_packs - 1; the first
  /// and the last pack may hold coordinates of the neighbouring ranges, too.
  struct Range {
    Count first = 0, end = 0;
    Count first_of_packs = 0, end_of_packs = 0;
    Count size() const { return end - first; }
    Count length() const { return end_of_packs - first_of_packs; }
  };

  /// Takes the memory for so many coordinates.
  void reserve(Count ngc) { at_.resize(ngc / contact_lemke::kLeastRange + 2); }

  /// One range of all. @pre reserve(ngc)
  void take_all(Count ngc) {
    at_[0] = 0;
    end_at(1, ngc);
  }

  /// Blocks at the end that have fewer coordinates than a range join the last one. @pre reserve(ngc)
  void find(const contact_lemke::InertiaInput& inertia, Count ngc) {
    Count count = at_[0] = 0;
    for (Count b = 0; b < inertia.blocks; ++b) {
      const Count end = inertia.offsets[b + 1];
      if (end - at_[count] >= contact_lemke::kLeastRange) at_[++count] = end;
    }
    end_at(count > 0 ? count : 1, ngc);
  }

  Count count() const { return count_; }
  /// The sum of the cubes of their sizes.
  Count cubes() const { return cubes_; }

  Range operator[](Count r) const { return between(at_[r], at_[r + 1]); }
  static Range between(Count first, Count end) {
    return {first, end, first & -Packed<Scalar>::kWidth, Packed<Scalar>::padded(end)};
  }

 private:
  void end_at(Count count, Count ngc) {
    count_ = count;
    at_[count] = ngc;
    cubes_ = 0;
    for (Count r = 0; r < count; ++r) cubes_ += (at_[r + 1] - at_[r]) * (at_[r + 1] - at_[r]) * (at_[r + 1] - at_[r]);
  }

  Count count_ = 1, cubes_ = 0;
  Buffer<Count> at_;  ///< the first coordinate of each range, and ngc
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
