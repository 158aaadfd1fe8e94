#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/spec.h"
#include "study/summary/summary.h"

// What a report knows of a problem set by its name and its problems.

namespace lcpbench::report {

/// The spec that a stored text stands for; a text that is none, as a file's name, is taken as a bare name.
Spec spec_or_name(const std::string& text);

/// What a set is to a reader.
enum class SetKind {
  kRobots,          ///< captured steps whose inertia couples joints
  kStacks,          ///< captured steps of stacks and walls of free bodies
  kPiles,           ///< captured steps of piles
  kScenes,          ///< other captured steps
  kFrictionless,    ///< other contact problems, without friction
  kFrictional,      ///< other contact problems, with friction
  kIllConditioned,  ///< other contact problems whose set asks for ill-conditioned inertia
  kDial,            ///< random contact problems whose set has the option `condition`
  kBare,            ///< LCPs without contact data, or a mixture
  kHard,            ///< a hard case: one problem by a formula
};
/// "robots", "stacks", "piles", "scenes", "frictionless", "frictional", "ill_conditioned", "dial", "bare", "hard".
const char* to_string(SetKind kind);
SetKind kind_of(const SetSummary& set);

/// scene/FAMILY/ENGINE of the collection, or the user's own file:F.scenes.
struct SceneName {
  std::string family;  ///< "stack"; of a file its name as a set
  std::string engine;  ///< "ode"; "" for a file
};
/// nullopt for a set that holds no captured steps.
std::optional<SceneName> scene_name(const std::string& set);

/// Who captured the steps of a set, or of "file:F.scenes#120": "mujoco", "Bullet"; "" where nobody knows, as where the
/// set's file is gone.
std::string engine_of(const std::string& set);

/// What to say of false claims of `engine` on steps of engines that solve other contacts on purpose; "" where there are
/// none.
std::string soft_engine_note(const Summary& summary);

/// Whether a set is one of the hard cases, by its name.
bool is_hard_set(std::string_view name);

/// What the formula of a hard case says of it: "no solution, by Farkas' lemma". "" for another set, and for a case that
/// this program does not know.
std::string hard_truth(const std::string& set);

/// One name for the sets that differ in nothing but their engine, their condition number or their case: "stack",
/// "paper/monotone/exp5-*", "hard/contact".
std::string family_of(const SetSummary& set);

/// Does the solver replace the pyramid of some problems of the set by another friction model?
bool solves_other_model(const SetSummary& set, const SolverRow& solver);

/// SolverRow::text(), with level and version behind it where another solver of the summary, not in a sweep, has the
/// same.
std::string solver_label(const Summary& summary, std::size_t solver);

}  // namespace lcpbench::report
