#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/io/scenes_file.h"
#include "core/problem.h"
#include "core/spec.h"
#include "study/evaluation/evaluation.h"
#include "study/output/explanation.h"
#include "study/run/interrupt.h"

namespace lcpbench {

/// What `act` gives, which reads or examines a file: an interrupt ends the process, if that takes long.
template <class Act>
auto interruptibly(Act act) {
  const AbandonedAfterInterrupt abandoned;
  return act();
}

/// A captured step and the file that it is of, which may be part of the program.
struct NamedStep {
  std::shared_ptr<const ScenesFile> scenes;
  std::int64_t number = 0;

  SceneStep read() const { return scenes->read(scenes->index_of(number)); }
};

/// The step "F.scenes#120" or "scene/stack/ode#120", whose file is opened once; nullopt for any other name.
/// @throws InputError where the file cannot be read
std::optional<NamedStep> named_step(const std::string& name);

/// The problem of a file, of a step, or of a set: "SET#TRIAL", of seed 1. @throws InputError
Problem read_named_problem(const std::string& name);

/// Looks at a problem of `file`: prints what people read, or adds rows for programs.
using Examine = std::function<void(const Problem& problem, const std::string& file, Json& rows)>;

/// Reads each file, or other name of a problem, and examines it; of a scenes file every step, as "F.scenes#120". What is wrong with one
/// (InputError, of `examine` too) is told in a line on stderr and does not stop the others. An interrupt ends the walk
/// before the next problem. The rows are printed at the end, if `json`.
/// @returns the exit code
int examine_problem_files(const std::vector<std::string>& files, bool json, const Examine& examine);

/// The solver `engine` by the friction that the engine solves, unless its settings say which: MuJoCo's soft contacts with
/// friction are those of the convex model.
/// @param file  where the problem is from: the name of a step
Spec judged_as_solved(Spec spec, const Problem& problem, const std::string& file);

/// The names of the contacts of a step; none of any other file, and where the step has none.
std::vector<std::string> contact_names(const std::string& file);

/// Every metric by its name, the worst row, and the worst bounded row.
Json errors_json(const Problem& problem, const Errors& errors);

/// The numbers with blanks between them; "" for none, and where they are too many for a line or two.
std::string few_numbers(const Vector& numbers);

/// "box.json: contact, n 5, 6 coordinates, 5 contacts, 0 friction edges".
std::string problem_summary_text(const Problem& problem, const std::string& file);

}  // namespace lcpbench
