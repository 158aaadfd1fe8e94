#include "adapters/worker/control_group.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace lcpbench::worker {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "lcpbench-";
constexpr std::size_t kLongestPath = 4096;

// Plain memory, since a signal handler and a child before exec read them. Empty without a group.
std::array<char, kLongestPath> g_group{};
std::array<char, kLongestPath> g_members{};

bool write_file(const char* path, std::string_view text) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int cause = errno;
  close(file);
  errno = cause;
  return written;
}

/// Where the hierarchy of cgroup v2 is mounted; "" where it is not.
fs::path mount_point() {
  std::ifstream mounts("/proc/self/mounts");
  for (std::string line; std::getline(mounts, line);) {
    std::string device;
    std::string folder;
    std::string type;
    if (std::istringstream(line) >> device >> folder >> type && type == "cgroup2") return folder;
  }
  return {};
}

/// This process's group of cgroup v2, as the kernel names it: "/user.slice/..."; "" for none.
std::string own_group() {
  constexpr std::string_view kVersion2 = "0::";
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (line.starts_with(kVersion2)) return line.substr(kVersion2.size());
  }
  return {};
}

/// The groups of processes that were killed before they could remove them. Those with members stay: the kernel says so.
void remove_stale_groups(const fs::path& folder) {
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    pid_t owner = 0;
    if (!name.starts_with(kPrefix)) continue;
    const char* const end = name.data() + name.size();
    const auto parsed = std::from_chars(name.data() + kPrefix.size(), end, owner);
    if (parsed.ec != std::errc() || parsed.ptr != end) continue;
    if (kill(owner, 0) != 0 && errno == ESRCH) rmdir(entry.path().c_str());
  }
}

bool set_group(const fs::path& group) {
  const std::string members = (group / "cgroup.procs").string();
  if (members.size() >= kLongestPath) return false;
  std::strcpy(g_group.data(), group.c_str());
  std::strcpy(g_members.data(), members.c_str());
  return true;
}

/// Whether a process can be moved in: a child tries.
bool can_be_joined() {
  const pid_t child = fork();
  if (child == 0) _exit(join_control_group() ? 0 : 1);
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  return child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

bool set_limit(const fs::path& group, const GroupLimit& limit) {
  const fs::path file = group / limit.file;
  return write_file(file.c_str(), limit.value) || (!limit.needed && access(file.c_str(), F_OK) != 0);
}

bool make_in(const fs::path& folder, const std::vector<GroupLimit>& limits) {
  remove_stale_groups(folder);
  const fs::path group = folder / (std::string(kPrefix) + std::to_string(getpid()));
  if (mkdir(group.c_str(), 0755) != 0 || !set_group(group)) return false;
  bool limited = true;
  for (const GroupLimit& limit : limits) limited = limited && set_limit(group, limit);
  if (limited && can_be_joined()) return true;
  remove_control_group();
  return false;
}

}  // namespace

std::vector<GroupLimit> group_limits(std::uint64_t memory_bytes) {
  return {{"memory.max", std::to_string(memory_bytes)},
          {.file = "memory.swap.max", .value = "0", .needed = false},  // a system without swap has no such file
          {"pids.max", std::to_string(kGroupProcesses)}};
}

std::vector<fs::path> group_folders() {
  const fs::path mount = mount_point();
  const std::string own = own_group();
  if (mount.empty() || own.empty()) return {};
  const fs::path group = own == "/" ? mount : mount / own.substr(1);
  if (group == mount) return {group};
  return {group.parent_path(), group};
}

bool make_control_group(const std::vector<fs::path>& folders, const std::vector<GroupLimit>& limits) {
  for (const fs::path& folder : folders) {
    if (make_in(folder, limits)) return true;
  }
  return false;
}

bool join_control_group() { return g_members[0] == '\0' || write_file(g_members.data(), "0"); }

void remove_control_group() {
  if (g_group[0] != '\0') rmdir(g_group.data());
  g_group[0] = '\0';
  g_members[0] = '\0';
}

}  // namespace lcpbench::worker
