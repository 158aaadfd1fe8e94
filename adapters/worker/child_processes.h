#pragma once

#include <csignal>

#include <sys/prctl.h>
#include <unistd.h>

namespace lcpbench::worker {

/// For a child, with its parent's id: SIGKILL ends it as soon as the parent ends, in whatever way. The kernel takes the
/// end of the thread that started the child for the end of the parent.
inline void end_with_parent(pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(0);  // it died before the line above
}

/// Makes this process the parent of every descendant whose own parent ends, also of a daemon that left its session.
/// Only so can end_children() find them. Does nothing where the system refuses (some emulators do).
void adopt_orphans();

/// Reaps the adopted orphans that have ended, which else stay as zombies. Leaves `program`, another child, alone.
void reap_orphans(pid_t program);

/// Kills and reaps all children of this process, and the orphans that it adopts while they die, until none is left; it
/// gives up after a third of a second, or where a child cannot be killed (a set-uid program). Fast without children.
/// Safe in a signal handler.
void end_children();

}  // namespace lcpbench::worker
