#pragma once

// The program as users' scripts run it: exit code, standard output, standard error.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

namespace lcpbench {

/// A file's bytes; "" for none.
inline std::string read_file(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// Whether the process whose id is in the file runs on; it is given a minute to end.
inline bool runs_on(const std::filesystem::path& id_file) {
  const std::string stat = "/proc/" + std::to_string(std::stoi(read_file(id_file))) + "/stat";
  for (int i = 0; i < 3000; ++i) {
    const std::string text = read_file(stat);
    const std::size_t name_end = text.rfind(") ");
    if (name_end == std::string::npos || text[name_end + 2] == 'Z') return false;
    usleep(20'000);
  }
  return true;
}

struct ProgramRun {
  int exit_code = -1;  ///< -1: a signal ended it
  std::string out;
  std::string err;
};

#ifdef LCPBENCH_PROGRAM
/// Runs the program in `folder`, by the shell. Its outputs are left there as files `out` and `err`; redirections in
/// `arguments` come later and win.
inline ProgramRun run_program(const std::filesystem::path& folder, const std::string& arguments) {
  const std::string command = "cd '" + folder.string() + "' && '" LCPBENCH_PROGRAM "' >out 2>err " + arguments;
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder / "out"), read_file(folder / "err")};
}
#endif

}  // namespace lcpbench
