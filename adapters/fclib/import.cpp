// lcpbench-import-fclib FILE NAME [--symmetrize] INPUT...: what `lcpbench import fclib` starts. It writes FILE, which
// it calls NAME when it prints. A program of its own, so that HDF5 is loaded by nothing else.

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "adapters/fclib/fclib_problem.h"
#include "core/error.h"
#include "core/io/scenes_file.h"
#include "core/utf8.h"

namespace {

using namespace lcpbench;

void import_files(const std::string& out, const std::string& name, const std::vector<std::string>& files,
                  bool symmetrize) {
  const ScenesHeader header{.scene = files.size() == 1 ? files.front() : std::to_string(files.size()) + " FCLIB files",
                            .engine = "FCLIB"};
  ScenesWriter writer(out, header);
  for (std::size_t i = 0; i < files.size(); ++i) {
    SceneStep step;
    step.step = static_cast<std::int64_t>(i);
    step.problem = read_fclib(files[i], symmetrize);
    writer.add(step);
    std::printf("%s#%zu: %s, %td contacts\n", printable(name).c_str(), i, printable(files[i]).c_str(),
                step.problem.contact()->nc());
  }
  writer.close();
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const bool symmetrize = std::erase(arguments, "--symmetrize") > 0;
  if (arguments.size() < 3) return 2;
  const std::string out = arguments[0];
  const std::string name = arguments[1];
  arguments.erase(arguments.begin(), arguments.begin() + 2);
  try {
    import_files(out, name, arguments, symmetrize);
    return 0;
  } catch (const InputError& error) {
    std::fprintf(stderr, "lcpbench: %s\n", error.what());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "lcpbench: %s: %s\n", printable(name).c_str(), error.what());
  }
  return 2;
}
