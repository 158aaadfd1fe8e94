#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tests/fuzz/harness.h"

namespace lcpbench::fuzz {

/// The input in memory of its own, aligned as shared memory is: a read past its end is seen.
inline std::vector<std::byte> bytes_of(const std::uint8_t* data, std::size_t size) {
  const std::byte* begin = reinterpret_cast<const std::byte*>(data);
  return {begin, begin + size};
}

/// The message that `write` writes: asked for its size first.
template <class Write>
std::vector<std::byte> written(const Write& write) {
  std::vector<std::byte> bytes(write(std::span<std::byte>()));
  require(write(std::span<std::byte>(bytes)) == bytes.size(), "a message has the size it asked for");
  return bytes;
}

}  // namespace lcpbench::fuzz
