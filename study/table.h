#pragma once

#include <iosfwd>

#include "study/store.h"

namespace lcpbench {

/// Prints what a store holds so far, one line per set and solver: trials, solved, false claims, median time.
void print_table(Store& store, std::ostream& out);

}  // namespace lcpbench
