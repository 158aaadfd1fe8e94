#pragma once

#include <type_traits>
#include <utility>

#include "core/types.h"

namespace lcpbench {

/// Calls work(at) where at(pointer) is the vector of `size` entries there, of fixed length where that is 6: a body.
template <class Work>
void with_body_size(int size, Work&& work) {
  using Six = Eigen::Matrix<double, 6, 1>;
  if (size == Six::RowsAtCompileTime) {
    work([](auto* entries) {
      using Entries = std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(entries)>>, const Six, Six>;
      return Eigen::Map<Entries>(entries);
    });
  } else {
    work([size](auto* entries) {
      using Entries =
          std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(entries)>>, const Vector, Vector>;
      return Eigen::Map<Entries>(entries, size);
    });
  }
}

}  // namespace lcpbench
