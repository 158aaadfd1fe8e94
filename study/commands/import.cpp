#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "study/commands/commands.h"

namespace lcpbench {
namespace {

struct ImportArguments {
  std::string format;
  std::vector<std::string> files;
  std::string out;
  bool symmetrize = false;
};

/// The program that stands beside this one, with these arguments; its exit code. @throws InputError when it is missing
int run_beside(const std::string& name, std::vector<std::string> arguments, const std::string& missing) {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
  if (!std::filesystem::exists(program)) throw InputError(missing);
  arguments.insert(arguments.begin(), program.string());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execv(argv.front(), argv.data());
    _exit(127);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (child < 0 || !WIFEXITED(status) || WEXITSTATUS(status) == 127) {
    throw InputError(fmt::format("{}: ended without an answer", program.string()));
  }
  return WEXITSTATUS(status);
}

int import_files(const ImportArguments& arguments) {
  if (!is_scenes_file(arguments.out)) {
    throw InputError("--out '" + arguments.out + "': a scenes file's name ends in .scenes");
  }
  for (const std::string& file : arguments.files) {
    std::error_code ignored;
    if (std::filesystem::equivalent(arguments.out, file, ignored)) {
      throw InputError(arguments.out + ": is read by this command; write elsewhere");
    }
  }
  std::vector<std::string> words{arguments.out};
  if (arguments.symmetrize) words.emplace_back("--symmetrize");
  words.insert(words.end(), arguments.files.begin(), arguments.files.end());
  return run_beside("lcpbench-import-fclib", std::move(words),
                    "import fclib: not in this build: install libhdf5-dev and build again");
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
