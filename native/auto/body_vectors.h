#pragma once

#include <type_traits>
#include <utility>

#include "core/types.h"

namespace lcpbench {

/// Calls work(at) where at(pointer) is the vector of `size` entries there, of fixed length where that is 6 or 3: a
/// body, or its velocities of one kind.
template <class Work>
void with_body_size(int size, Work&& work) {
  const auto with_fixed = [&work](auto fixed) {
    using Fixed = decltype(fixed);
    work([](auto* entries) {
      using Entries = std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(entries)>>, const Fixed, Fixed>;
      return Eigen::Map<Entries>(entries);
    });
  };
  if (size == 6) {
    with_fixed(Eigen::Matrix<double, 6, 1>());
  } else if (size == 3) {
    with_fixed(Eigen::Matrix<double, 3, 1>());
  } else {
    work([size](auto* entries) {
      using Entries =
          std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(entries)>>, const Vector, Vector>;
      return Eigen::Map<Entries>(entries, size);
    });
  }
}

}  // namespace lcpbench
