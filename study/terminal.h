#pragma once

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "core/utf8.h"

namespace lcpbench {

/// Prints text that may repeat foreign words: names of files, sets and solvers, messages of libraries, what a store
/// holds. Every control character but the line end becomes '?', so that no name commands the terminal.
template <class... Values>
void say(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
  fmt::print(stream, "{}", printable(fmt::format(format, std::forward<Values>(values)...), "\n"));
}

}  // namespace lcpbench
