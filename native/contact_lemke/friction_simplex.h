#pragma once

#include "native/contact_lemke/contacts.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// A contact with active friction as the ratio test reads it at each pivot, in one place: its directions, and its base
/// t, the basic friction impulse that is eliminated (see Path).
template <class Scalar>
struct FrictionSimplex {
  const Scalar* directions = nullptr;  ///< Contacts::block()
  const Scalar* allowed = nullptr;     ///< RatioTest::allowed_of()
  Count width = 0;                     ///< Contacts::padded_half()
  Count twin = 0;                      ///< the number of t in the first half; 0 where t is the zero direction
  Scalar sign = 0;                     ///< 1 where t is in the first half, -1 in the second, 0 for the zero direction
  Scalar is_zero = 0;                  ///< 1 for the zero direction, else 0
  Scalar cover = 0;                    ///< CoveringVector::of_directions()
  Scalar value = 0, rate = 0;          ///< of f_t
  Scalar weights[2] = {0, 0};          ///< of the contact's other friction impulses in f_t, and of its normal: mu
  Scalar norms[2] = {0, 0};            ///< of the column of any of those, and of the normal's

  void set_base(Count base, Count half) {
    is_zero = static_cast<Scalar>(base == 2 * half ? 1 : 0);
    twin = base == 2 * half ? 0 : (base < half ? base : base - half);
    sign = static_cast<Scalar>(base == 2 * half ? 0 : (base < half ? 1 : -1));
  }
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
