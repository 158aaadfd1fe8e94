#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "study/output/json_output.h"
#include "study/output/terminal.h"
#include "study/store/store.h"

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

/// What the last run of a store says of itself; null where it has none, or one that is no object.
inline Json last_run(Store& store) {
  const std::vector<std::string> runs = store.runs();
  Json run = runs.empty() ? Json() : Json::parse(runs.back(), nullptr, false);
  return run.is_object() ? run : Json();
}

/// Adds what a run says of itself. @param started  "" at its end
inline void record_run(Store& store, const std::string& started, const Json& run) {
  store.begin();
  store.add_run(started, run.dump());
  store.commit();
}

}  // namespace lcpbench
