#include <cmath>
#include <limits>

#include "native/steppers/define_stepper.h"
#include "native/steppers/delassus.h"

namespace lcpbench {
namespace {

/// Accelerated projected gradient descent on the convex relaxation, in which what slides lifts off: min f'W f / 2 + g'f
/// on the cones (Mazhar et al., Using Nesterov's method to accelerate multibody dynamics with friction and contact,
/// 2015, Algorithm 1, as in Chrono). Positions as in sequential_impulses.
class Apgd final : public steppers::ConeStepper {
 public:
  using ConeStepper::ConeStepper;

 protected:
  Vector solve(const steppers::World& world, const steppers::Delassus& contacts, const Vector& start) const override {
    const auto& [W, g] = contacts;
    Vector f = start;
    Vector best = f;
    Vector y = f;
    const Vector all = Vector::Ones(f.size());
    double L = (W * all).norm() / all.norm();
    double theta = 1;
    double least = std::numeric_limits<double>::infinity();
    const auto cost = [&](const Vector& at, const Vector& W_at) { return at.dot(0.5 * W_at + g); };
    for (std::int64_t i = 0; i < settings_.iterations; ++i) {
      const Vector W_y = W * y;
      const Vector gradient = W_y + g;
      const double cost_y = cost(y, W_y);
      Vector next;
      Vector W_next;
      while (true) {
        next = y - gradient / L;
        project_on_cones(world, next);
        W_next = W * next;
        const Vector step = next - y;
        const double bound = cost_y + gradient.dot(step) + 0.5 * L * step.squaredNorm();
        if (!(cost(next, W_next) > bound + 1e-14 * std::abs(bound))) break;
        L *= 2;
      }
      const double theta_next = (std::sqrt(theta * theta + 4) - theta) * theta / 2;
      const double beta = theta * (1 - theta) / (theta * theta + theta_next);
      const Vector moved = next - f;
      Vector reached = next - (W_next + g) / L;
      project_on_cones(world, reached);
      const double residual = L * (next - reached).lpNorm<Eigen::Infinity>();
      if (residual < least) {
        least = residual;
        best = next;
      }
      if (residual <= settings_.tolerance * g.lpNorm<Eigen::Infinity>()) break;
      const bool uphill = gradient.dot(moved) > 0;
      f = next;
      y = uphill ? next : Vector(next + beta * moved);
      theta = uphill ? 1 : theta_next;
      L *= 0.9;
    }
    return best;
  }
};

}  // namespace

StepperDefinition lcpbench_stepper_apgd() {
  return define_stepper<Apgd, steppers::ConeStepperSettings>(
      {.name = "apgd",
       .summary = "accelerated projected gradient descent on the convex relaxation, as Chrono",
       .source = "Mazhar et al., Using Nesterov's method to accelerate multibody dynamics, 2015"});
}

}  // namespace lcpbench
