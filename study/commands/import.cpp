#include <unistd.h>

#include "adapters/worker/start_program.h"
#include "core/io/scenes_file.h"
#include "core/io/whole_file.h"
#include "study/commands/commands.h"

namespace lcpbench {
namespace {

struct ImportArguments {
  std::string format;
  std::vector<std::string> files;
  std::string out;
  bool symmetrize = false;
};

int import_files(const ImportArguments& arguments) {
  if (!is_scenes_file(arguments.out)) {
    throw InputError("--out '" + arguments.out + "': a scenes file's name ends in .scenes");
  }
  refuse_inputs(arguments.out, arguments.files);
  const std::filesystem::path program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "lcpbench-import-fclib";
  if (!std::filesystem::exists(program)) {
    throw InputError("import fclib: not in this build: install libhdf5-dev and build again");
  }
  const volatile std::sig_atomic_t* stop = catch_interrupts(kExitInterrupted);
  WholeFile out(arguments.out);
  std::vector<std::string> words{program.string(), out.draft().string(), arguments.out};
  if (arguments.symmetrize) words.emplace_back("--symmetrize");
  words.insert(words.end(), arguments.files.begin(), arguments.files.end());
  const std::string ending = worker::run_program(words, STDOUT_FILENO, STDERR_FILENO, stop);
  if (*stop != 0) return kExitInterrupted;
  if (ending == "exited with code 2") return kExitBadInput;
  if (ending != "exited with code 0") throw InputError(fmt::format("{}: {}", program.string(), ending));
  out.commit();
  return kExitDone;
}

}  // namespace

Action add_import_command(CLI::App& command) {
  const auto arguments = std::make_shared<ImportArguments>();
  command.add_option("FORMAT", arguments->format, "fclib: frictional contact problems of Siconos (HDF5)")
      ->required()
      ->check(CLI::IsMember({"fclib"}));
  command.add_option("FILE", arguments->files, "files of this format, each one step")->required();
  command.add_option("--out", arguments->out, "scenes file to write")->required();
  command.add_flag("--symmetrize", arguments->symmetrize, "take the mean of a matrix and its transpose");
  return [arguments] { return import_files(*arguments); };
}

}  // namespace lcpbench
