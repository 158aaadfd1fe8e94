#pragma once

#include <string>
#include <vector>

namespace lcpbench::capture {

/// How the program of an engine ended.
struct EngineRun {
  std::string ending;   ///< "exited with code 0", "killed by signal 11 (SIGSEGV)"
  std::string message;  ///< the last line that it wrote to its standard error
};

/// Runs lcpbench-capture-<engine>, which stands where the workers stand, and waits for its end. It stays in the process
/// group of this program, so that Ctrl-C ends both. @throws InputError when the program is missing
EngineRun run_engine(const std::string& engine, const std::vector<std::string>& arguments);

}  // namespace lcpbench::capture
