#pragma once

#include <sys/types.h>

namespace lcpbench {

/// The next time that poll() finds nothing in this process, and before it says so: waits until `child` has stopped
/// itself, lets it go on, and waits for its end, without reaping it. So what it says at its end comes after one look at
/// its output and before the next look at whether it lives.
void end_stopped_child_in_next_empty_poll(pid_t child);

/// Whether that has happened.
bool child_has_ended_in_empty_poll();

}  // namespace lcpbench
