#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "core/error.h"

/// The one function of a harness: feeds `size` bytes to a parser, aborts when an oracle fails, returns 0.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace lcpbench::fuzz {

/// Aborts, so that fuzzer and replay both stop at this input.
inline void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz oracle failed: %s\n", what);
  std::abort();
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// The parser's result, or nothing when it refuses the input as it should: by InputError with one line of sane length.
/// Any other exception passes, and ends the program.
template <class Parse>
auto parsed_or_refused(const Parse& parse) -> std::optional<decltype(parse())> {
  try {
    return parse();
  } catch (const InputError& error) {
    const std::string_view message = error.what();
    require(!message.empty(), "an error has a message");
    require(message.find('\n') == std::string_view::npos, "an error is one line");
    return std::nullopt;
  }
}

}  // namespace lcpbench::fuzz
