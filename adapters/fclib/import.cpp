// lcpbench-import-fclib OUT [--symmetrize] FILE...: what `lcpbench import fclib` starts. A program of its own, so that
// HDF5 is loaded by nothing else.

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "adapters/fclib/fclib_problem.h"
#include "core/error.h"
#include "core/io/scenes_file.h"

namespace {

using namespace lcpbench;

void import_files(const std::string& out, const std::vector<std::string>& files, bool symmetrize) {
  const ScenesHeader header{.scene = files.size() == 1 ? files.front() : std::to_string(files.size()) + " FCLIB files",
                            .engine = "FCLIB"};
  ScenesWriter writer(out, header);
  for (std::size_t i = 0; i < files.size(); ++i) {
    SceneStep step;
    step.step = static_cast<std::int64_t>(i);
    step.problem = read_fclib(files[i], symmetrize);
    writer.add(step);
    std::printf("%s#%zu: %s, %td contacts\n", out.c_str(), i, files[i].c_str(), step.problem.contact()->nc());
  }
  writer.close();
}

/// What was written of a file that is not complete. Never a device, which --out may name too.
void discard(const std::string& out) {
  std::error_code error;
  if (std::filesystem::is_regular_file(out, error)) std::filesystem::remove(out, error);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const bool symmetrize = std::erase(arguments, "--symmetrize") > 0;
  if (arguments.size() < 2) return 2;
  const std::string out = arguments.front();
  arguments.erase(arguments.begin());
  try {
    import_files(out, arguments, symmetrize);
    return 0;
  } catch (const InputError& error) {
    std::fprintf(stderr, "lcpbench: %s\n", error.what());
    discard(out);
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lcpbench: %s: %s\n", out.c_str(), error.what());
    discard(out);
    return 2;
  }
}
