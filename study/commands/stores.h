#pragma once

#include <filesystem>

#include "study/store/store.h"
#include "study/output/terminal.h"

namespace lcpbench {

/// Says on stderr which rows a store has lost before it was opened, if any.
inline void print_notice(const Store& store) {
  if (!store.notice().empty()) say(stderr, "lcpbench: {}\n", store.notice());
}

/// Says on stderr what takes long.
inline Waiting told_on_stderr() {
  return {.tell = [](const std::string& line) { say(stderr, "lcpbench: {}\n", line); }};
}

/// Opens a store whose numbers are to be told: every row of it is checked first. @throws InputError
inline Store open_checked(const std::filesystem::path& file) {
  Store store = Store::open_for_reading(file);
  print_notice(store);
  store.check(told_on_stderr());
  return store;
}

}  // namespace lcpbench
