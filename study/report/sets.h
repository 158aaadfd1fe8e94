#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/spec.h"
#include "study/summary/summary.h"

// What a report knows of a problem set by its name and its problems.

namespace lcpbench::report {

/// The text parsed as a spec; if it is not a valid one, as a file's name may be, a spec of that name without options.
Spec spec_or_name(const std::string& text);

/// The kind of a set in reports.
enum class SetKind {
  kRobots,          ///< captured steps, at least one of them with an inertia that couples joints
  kStacks,          ///< captured steps of stacks, card houses and walls of free bodies
  kPiles,           ///< captured steps of piles
  kScenes,          ///< other captured steps
  kFrictionless,    ///< other contact problems, without friction
  kFrictional,      ///< other contact problems, with friction
  kIllConditioned,  ///< other contact problems whose set asks for ill-conditioned inertia
  kDial,            ///< contact problems of paper/ or rigid/ whose set has the option `condition`
  kBare,            ///< LCPs without contact data, or a mixture
  kHard,            ///< a hard case: one problem by a formula
};
/// "robots", "stacks", "piles", "scenes", "frictionless", "frictional", "ill_conditioned", "dial", "bare", "hard".
const char* to_string(SetKind kind);
SetKind kind_of(const SetSummary& set);

/// scene/FAMILY/ENGINE of the collection, or the user's own file:F.scenes.
struct SceneName {
  std::string family;  ///< "stack"; for a file the name of the set, "file:F.scenes"
  std::string engine;  ///< "ode"; "" for a file
};
/// nullopt for a set that holds no captured steps.
std::optional<SceneName> scene_name(const std::string& set);

/// The engine that a set's steps were captured from, also of one step "file:F.scenes#120". As the collection's name has
/// it ("mujoco") or the header of the file ("MuJoCo"); "" where it is unknown or the file cannot be read.
std::string engine_of(const std::string& set);

/// Summary::engine, from the files of the sets that the solver `engine` was asked about.
std::string only_engine(const Summary& summary);

/// Explains false claims of the solver `engine`, the capturing engine's own answers: most engines soften contacts or
/// correct penetration on purpose, and are judged on hard contacts. "" where there is nothing to explain.
std::string soft_engine_note(const Summary& summary);

/// Whether a set is one of the hard cases, by its name.
bool is_hard_set(std::string_view name);

/// What is known of the solutions of a hard case, and why: "no solution, by Farkas' lemma". "" for another set, and for
/// a case that this program does not know.
std::string hard_truth(const std::string& set);

/// One name for the sets that differ in nothing but their engine, their condition number or their case: "stack",
/// "paper/monotone/exp5-*", "hard/contact".
std::string family_of(const SetSummary& set);

/// Does the solver replace the pyramid of some problems of the set by another friction model?
bool solves_other_model(const SetSummary& set, const SolverRow& solver);

/// SolverRow::text(), in which Summary::engine takes the place of `engine`; followed by instruction-set level, library
/// and version where several solvers of the summary that are in no sweep have this text.
std::string solver_label(const Summary& summary, std::size_t solver);

}  // namespace lcpbench::report
