#include "study/report/gnuplot.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace lcpbench::report {

namespace {

/// A directory that goes away with this object.
class ScratchDirectory {
 public:
  ScratchDirectory() {
    std::error_code error;
    const std::filesystem::path parent = std::filesystem::temp_directory_path(error);
    if (error) throw FigureError("there is no directory for temporary files (TMPDIR): " + error.message());
    std::string pattern = (parent / "lcpbench-figure-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) {
      throw FigureError("cannot make a directory for figures in " + parent.string() + ": " + std::strerror(errno));
    }
    path_ = pattern;
  }
  ~ScratchDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  std::string file(const char* name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

void write_text(const std::string& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw FigureError(file + ": cannot be written: " + std::strerror(errno));
}

std::string read_text(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The first line that says something; gnuplot sets off its messages by blank lines and carets.
std::string first_message(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    if (line.find("line ") != std::string::npos) return line;
  }
  return "no message";
}

/// Redirections of a child process.
class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;

  void open(int descriptor, const std::string& file, int flags) {
    posix_spawn_file_actions_addopen(&actions_, descriptor, file.c_str(), flags, 0600);
  }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

int wait_for(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) throw FigureError(std::string("waiting for gnuplot failed: ") + std::strerror(errno));
  }
  return status;
}

}  // namespace

std::string run_gnuplot(const std::string& script) {
  const ScratchDirectory scratch;
  write_text(scratch.file("script"), script);

  constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
  FileActions actions;
  actions.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  actions.open(STDOUT_FILENO, scratch.file("output"), kWrite);
  actions.open(STDERR_FILENO, scratch.file("messages"), kWrite);

  std::string program = "gnuplot";
  std::string without_startup_file = "-d";
  std::string script_file = scratch.file("script");
  char* const arguments[] = {program.data(), without_startup_file.data(), script_file.data(), nullptr};
  pid_t child = 0;
  const int failure = posix_spawnp(&child, program.c_str(), actions.get(), nullptr, arguments, environ);
  if (failure == ENOENT) throw FigureError("gnuplot is not installed (Debian package gnuplot-nox)");
  if (failure != 0) throw FigureError(std::string("gnuplot cannot be started: ") + std::strerror(failure));

  const int status = wait_for(child);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw FigureError("gnuplot failed: " + first_message(read_text(scratch.file("messages"))));
  }
  std::string output = read_text(scratch.file("output"));
  if (output.empty()) throw FigureError("gnuplot drew nothing");
  return output;
}

std::string gnuplot_quote(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return quoted + "'";
}

}  // namespace lcpbench::report
