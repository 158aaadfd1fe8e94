#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

/// Limits on a program together with everything that it starts, by a control group (cgroup v2). A limit of the older
/// kind (setrlimit) holds for each process separately.
namespace lcpbench::worker {

/// One file of a group, and what is written to it.
struct GroupLimit {
  std::string file;
  std::string value;
  bool needed = true;  ///< false: where the system has no such file, there is nothing to limit
};

/// Limit on the processes and threads of a program and of all processes that it starts, together.
inline constexpr int kGroupProcesses = 512;

/// Memory, without swap beside it, and processes of a group.
std::vector<GroupLimit> group_limits(std::uint64_t memory_bytes);

/// The folders in which this process may be able to make a group: beside its own group, and in it. Empty without
/// cgroup v2.
std::vector<std::filesystem::path> group_folders();

/// Makes a group with these limits in the first folder where the system allows it, and where processes can be moved
/// into it. @returns false when there is none: most systems let users do so only below a group that is theirs. A
/// process has one group at most. Removes groups that killed processes left behind.
bool make_control_group(const std::vector<std::filesystem::path>& folders, const std::vector<GroupLimit>& limits);

/// Moves the calling process into the group that it, or the process that it was forked from, has made, if any.
/// @returns false, with errno, when there is one and the process could not be moved. Safe between fork and exec.
bool join_control_group();

/// Removes the group, if there is one and no process is left in it. Safe in a signal handler.
void remove_control_group();

}  // namespace lcpbench::worker
