#pragma once

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "study/evaluation/evaluation.h"
#include "study/output/terminal.h"
#include "study/run/interrupt.h"

namespace lcpbench {

/// What `act` gives, which reads or examines a file: an interrupt ends the process, if that takes long.
template <class Act>
auto interruptibly(Act act) {
  const AbandonedAfterInterrupt abandoned;
  return act();
}

/// Reads each file and calls visit(problem, file); of a scenes file every step, as "F.scenes#120". What is wrong with
/// one (InputError, of `visit` too) is told in a line on stderr and does not stop the others. A `stop` that is raised
/// ends the walk before the next problem.
/// @returns whether nothing was wrong with any
template <class Visit>
bool for_each_problem_file(const std::vector<std::string>& files, const volatile std::sig_atomic_t* stop, Visit visit) {
  bool complete = true;
  const auto guarded = [&](auto&& act) {
    try {
      act();
    } catch (const InputError& error) {
      complete = false;
      say(stderr, "lcpbench: {}\n", error.what());
    }
    std::fflush(stdout);  // an interrupt while the next is read loses nothing
  };
  const auto visit_steps = [&](const std::string& file) {
    const ScenesFile scenes = interruptibly([&] { return ScenesFile(file); });
    if (!scenes.truncation().empty()) say(stderr, "lcpbench: {}\n", printable(scenes.truncation()));
    for (std::size_t i = 0; i < scenes.count() && *stop == 0; ++i) {
      guarded([&] {
        visit(interruptibly([&] { return scenes.read(i); }).problem,
              file + "#" + std::to_string(scenes.step_number(i)));
      });
    }
  };
  for (const std::string& file : files) {
    if (*stop != 0) break;
    guarded([&] {
      if (is_scenes_file(file)) return visit_steps(file);
      visit(interruptibly([&] { return read_problem(file); }), file);
    });
  }
  return complete;
}

/// {"name", "kind", "n", "ngc", "nc", "edges"}, as every document about single problems has it: the last three null for
/// a bare LCP. A problem without a name is called after its file.
nlohmann::ordered_json problem_summary_json(const Problem& problem, const std::string& file);

/// Every metric by its name, and the worst row.
nlohmann::ordered_json errors_json(const Errors& errors);

/// "box.json: contact, n 5, 6 coordinates, 5 contacts, 0 friction edges".
std::string problem_summary_text(const Problem& problem, const std::string& file);

}  // namespace lcpbench
