#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "core/error.h"
#include "generators/problem_io.h"
#include "study/terminal.h"

namespace lcpbench {

/// Reads each file and calls visit(problem, file). What is wrong with one (InputError, of `visit` too) is told in a
/// line on stderr and does not stop the others.
/// @returns whether nothing was wrong with any
template <class Visit>
bool for_each_problem_file(const std::vector<std::string>& files, Visit visit) {
  bool complete = true;
  for (const std::string& file : files) {
    try {
      visit(read_problem(file), file);
    } catch (const InputError& error) {
      complete = false;
      say(stderr, "lcpbench: {}\n", error.what());
    }
  }
  return complete;
}

}  // namespace lcpbench
