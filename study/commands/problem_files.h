#pragma once

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "study/output/terminal.h"

namespace lcpbench {

/// Reads each file and calls visit(problem, file). What is wrong with one (InputError, of `visit` too) is told in a
/// line on stderr and does not stop the others. A `stop` that is raised ends the walk before the next file.
/// @returns whether nothing was wrong with any
template <class Visit>
bool for_each_problem_file(const std::vector<std::string>& files, const volatile std::sig_atomic_t* stop, Visit visit) {
  bool complete = true;
  for (const std::string& file : files) {
    if (*stop != 0) break;
    try {
      visit(read_problem(file), file);
    } catch (const InputError& error) {
      complete = false;
      say(stderr, "lcpbench: {}\n", error.what());
    }
  }
  return complete;
}

/// {"name", "kind", "n", "ngc", "nc", "edges"}, as every document about single problems has it: the last three null for
/// a bare LCP. A problem without a name is called after its file.
nlohmann::ordered_json problem_summary_json(const Problem& problem, const std::string& file);

/// "box.json: contact, n 5, 6 coordinates, 5 contacts, 0 friction edges".
std::string problem_summary_text(const Problem& problem, const std::string& file);

}  // namespace lcpbench
