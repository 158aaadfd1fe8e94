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
  std::string solver;  ///< "psor{max_iterations=10}"
  FrictionModel model = FrictionModel::kPyramid;
  Claim claim = Claim::kNumericalFailure;
  Verdict verdict = Verdict::kOpen;
  Errors errors;
  double time_s = std::numeric_limits<double>::quiet_NaN();  ///< NaN or infinity: not known
  Vector z;                                                  ///< empty where the solver gave none
};

/// A step with answers to it: bodies, contacts, and the impulses, velocities and residuals of each answer. Numbers for
/// the picture have six digits.
/// @param source  as `lcpbench solve` takes it: "F.scenes#120", or the name of a problem file; of a collected step
///                "scene/stack/ode#120"
Json step_view(const ScenesHeader& header, const SceneStep& step, const std::string& source,
               const std::vector<ViewedAnswer>& answers);

/// For the report: of at most `most` captured steps of the store, the view with the answers that the store has. Chosen
/// are steps that one solver solved and another did not, one of each scene: false claims first, then by the residual of
/// the answer that failed [m/s]. Nothing is solved again. Sets whose files are gone, or no longer those of the store,
/// are left out. Each view has at most `bytes`: the fastest verified answer and the one that failed, others as far as
/// they fit.
std::vector<Json> stored_step_views(Store& store, std::size_t most = 6, std::size_t bytes = 60'000);

/// The replays of one scene as films: for each solver the poses of its frames and the measures over time.
Json replay_view(const ReplayedFiles& replays);

}  // namespace lcpbench
