#include "native/steppers/define_stepper.h"

namespace lcpbench {
namespace {

struct NothingSettings {
  void visit(auto&&) {}
};

/// A step as if there were no contacts, for comparison: every other stepper should have smaller errors.
class Nothing : public Stepper {
 public:
  explicit Nothing(const NothingSettings&) {}

  void step(const StepProblem& step, StepAnswer& answer) override {
    answer = {};
    answer.velocity =
        std::visit([](const auto& contacts) { return Problem("", contacts).contact()->v; }, step.contacts);
    answer.claim = Claim::kIterationLimit;
  }
};

}  // namespace

StepperDefinition lcpbench_stepper_nothing() {
  return define_stepper<Nothing, NothingSettings>(
      {.name = "nothing",
       .summary = "no contact at all: the baseline of comparisons",
       .source = "this project's",
       .bodies_only = false});
}

}  // namespace lcpbench
