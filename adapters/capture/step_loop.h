#pragma once

#include <memory>
#include <string>

#include "adapters/capture/engine.h"
#include "core/stepper.h"

namespace lcpbench::capture {

/// A stepper in the loop: a VelocitySolver.
class StepLoop {
 public:
  enum class Use {
    kSolved,  ///< a solver: from a cold start, without a correction of positions; an answer that is not claimed to be
              ///< solved ends the scene
    kReplay,  ///< a stepper, as an engine uses it: every answer with a finite velocity moves the scene on
  };

  /// @throws InputError for steppers and solvers that cannot run
  StepLoop(const std::string& spec, Use use, double step_length);

  /// Sets Snapshot::correction too. @pre the contacts have their ids
  Eigen::VectorXd operator()(Snapshot& snapshot);

  /// Why the last step is the end; "" while there is none.
  const std::string& failure() const { return failure_; }
  /// The claim about the last step; "none" where nothing touched.
  const std::string& claim() const { return claim_; }
  /// CPU time of the last step, from the contacts that the engine found to the velocity [s].
  double cpu_s() const { return cpu_s_; }

 private:
  std::string name_;
  Use use_;
  double h_;
  std::unique_ptr<Stepper> stepper_;
  StepAnswer answer_;
  std::string failure_;
  std::string claim_;
  double cpu_s_ = 0;
};
}  // namespace lcpbench::capture
