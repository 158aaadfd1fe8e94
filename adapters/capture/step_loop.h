#pragma once

#include <memory>
#include <string>

#include "adapters/capture/engine.h"
#include "core/timed_solve.h"

namespace lcpbench::capture {

/// A solver in the loop: a VelocitySolver.
class SolverLoop {
 public:
  enum class Use {
    kSolved,  ///< an answer that is not claimed to be solved ends the scene
    kReplay,  ///< as an engine uses it: every answer with finite impulses moves the scene on, and positions are
              ///< projected
  };

  /// @throws InputError for solvers that cannot run
  SolverLoop(const std::string& spec, Use use, double step_length);

  /// With kReplay it sets Snapshot::correction too.
  Eigen::VectorXd operator()(Snapshot& snapshot);

  /// Why the last step is the end; "" while there is none.
  const std::string& failure() const { return failure_; }
  /// The claim about the last step; "none" where nothing touched.
  const std::string& claim() const { return claim_; }

 private:
  bool solve(const Problem& problem);
  void correct(Snapshot& snapshot, const Eigen::VectorXd& velocity);

  std::string name_;
  Use use_;
  double h_;
  std::unique_ptr<TimedSolver> solver_;
  TimedAnswer timed_;
  std::string failure_;
  std::string claim_;
};

}  // namespace lcpbench::capture
