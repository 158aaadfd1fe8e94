#pragma once

#include <sys/types.h>

namespace lcpbench::worker {

/// Makes this process the parent of every descendant whose own parent ends, also of a daemon that left its session.
/// Only so can end_children() find them. Does nothing where the system refuses (some emulators do).
void adopt_orphans();

/// Reaps the adopted orphans that have ended, which would otherwise stay zombies. Does not reap `program`, a child that
/// its starter waits for; once that has ended, orphans may stay until end_children().
void reap_orphans(pid_t program);

/// Kills and reaps all children of this process, and the orphans that it adopts while they die, until none is left; it
/// gives up after a third of a second, or where a child cannot be killed (a set-uid program). Fast without children.
/// Safe in a signal handler.
void end_children();

}  // namespace lcpbench::worker
