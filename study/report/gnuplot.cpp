#include "study/report/gnuplot.h"

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <sstream>

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

namespace lcpbench::report {

namespace {

/// A file in memory that has no name: nothing of it is left, however the program ends.
class NamelessFile {
 public:
  explicit NamelessFile(const char* purpose) : descriptor_(memfd_create(purpose, MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail();
  }
  ~NamelessFile() { close(descriptor_); }
  NamelessFile(const NamelessFile&) = delete;
  NamelessFile& operator=(const NamelessFile&) = delete;

  int descriptor() const { return descriptor_; }

  /// Writes the text, and goes back to its beginning.
  void write_all(std::string_view text) {
    while (!text.empty()) {
      const ssize_t written = write(descriptor_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail();
      text.remove_prefix(static_cast<std::size_t>(written));
    }
    lseek(descriptor_, 0, SEEK_SET);
  }

  std::string read_all() const {
    std::string text;
    char part[1 << 16];
    while (true) {
      const ssize_t count = pread(descriptor_, part, sizeof part, static_cast<off_t>(text.size()));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail();
      if (count == 0) return text;
      text.append(part, static_cast<std::size_t>(count));
    }
  }

 private:
  [[noreturn]] static void fail() {
    throw FigureError(std::string("cannot keep a figure in memory: ") + std::strerror(errno));
  }

  int descriptor_;
};

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

  void redirect(int stream, const NamelessFile& file) {
    posix_spawn_file_actions_adddup2(&actions_, file.descriptor(), stream);
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
  NamelessFile commands("gnuplot script");
  const NamelessFile drawing("gnuplot output");
  const NamelessFile messages("gnuplot messages");
  commands.write_all(script);

  FileActions actions;
  actions.redirect(STDIN_FILENO, commands);
  actions.redirect(STDOUT_FILENO, drawing);
  actions.redirect(STDERR_FILENO, messages);

  std::string program = "gnuplot";
  std::string without_startup_file = "-d";
  // As a file, which gnuplot opens anew and reads from its beginning: it ends at the first mistake in a file, but goes
  // on after one in its input.
  std::string script_file = "/dev/stdin";
  char* const arguments[] = {program.data(), without_startup_file.data(), script_file.data(), nullptr};
  pid_t child = 0;
  const int failure = posix_spawnp(&child, program.c_str(), actions.get(), nullptr, arguments, environ);
  if (failure == ENOENT) throw FigureError("gnuplot is not installed (Debian package gnuplot-nox)");
  if (failure != 0) throw FigureError(std::string("gnuplot cannot be started: ") + std::strerror(failure));

  const int status = wait_for(child);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw FigureError("gnuplot failed: " + first_message(messages.read_all()));
  }
  std::string output = drawing.read_all();
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
