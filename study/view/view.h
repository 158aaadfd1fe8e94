#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "core/io/scenes_file.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/friction_model.h"
#include "study/output/json_output.h"
#include "study/replay/replay_folder.h"
#include "study/store/store.h"

// What the page shows in 3D: docs/schema/view.schema.json. Each view is one JSON object.

namespace lcpbench {

/// An answer to a step, as a view shows it.
struct ViewedAnswer {
  std::string solver;  ///< solver_label(): "psor{max_iterations=10}", "my engine 0.1"
  FrictionModel model = FrictionModel::kPyramid;
  Claim claim = Claim::kNumericalFailure;
  Verdict verdict = Verdict::kOpen;
  Errors errors;
  double time_s = std::numeric_limits<double>::quiet_NaN();  ///< NaN or infinity: not known
  Vector z;                                                  ///< empty where the solver gave none
};

/// A step with answers to it: bodies, contacts, and what follows from the z of each answer: impulses, velocities and
/// residuals. Numbers for the picture have six digits. @pre the problem is no bare LCP
/// @param source  shown as the origin: "F.scenes#120", a problem file, or "scene/stack/ode#120" for a collected step
Json step_view(const ScenesHeader& header, const SceneStep& step, const std::string& source,
               const std::vector<ViewedAnswer>& answers);

/// For the report: views of at most `most` captured steps, with their answers in the store. Nothing is solved again.
///
/// A step qualifies if one solver solved it and another, not the engine itself, failed. Each scene gets one step,
/// whichever engine captured it. Steps with a false claim come first, then those whose failed answer has the largest
/// residual [m/s]. Steps that cannot be read, or whose data have changed since, are left out.
///
/// A view starts with the fastest verified answer and the worst failed one; others follow as far as `bytes` allow, which
/// are those of the view without its shapes. A step whose view is larger with these two alone is left out.
std::vector<Json> stored_step_views(Store& store, std::size_t most = 6, std::size_t bytes = 60'000);

/// The replays of one scene as films: for each solver the poses of its frames and the measures over time. The baseline
/// without contact impulses is left out, unless it is the only replay.
Json replay_view(const ReplayedFiles& replays);

}  // namespace lcpbench
