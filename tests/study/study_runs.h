#pragma once

#include <filesystem>

#include "study/run/runner.h"
#include "tests/support/study_support.h"

namespace lcpbench {

/// Runs a study into a store, of which it is one run more.
inline RunOutcome run_into(const Study& study, const std::filesystem::path& file, const RunOptions& options = {}) {
  Store store = Store::open_for_writing(file);
  store.add_run("2026-01-01T00:00:00Z", "{}");
  return run_study(study, store, options);
}

}  // namespace lcpbench
