#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

#include "native/steppers/define_stepper.h"
#include "native/steppers/delassus.h"

namespace lcpbench {
namespace {

/// The alternating direction method of multipliers on contacts with the round cone (Carpentier, Le Lidec, Montaut,
/// From compliant to rigid contact simulation, 2024, Algorithm 1): a linear system with a fixed matrix, a projection on
/// the cones and De Saxce's correction in turn, the penalty chosen by the spectrum of W. Positions as in
/// sequential_impulses.
class Admm final : public steppers::ConeStepper {
 public:
  using ConeStepper::ConeStepper;

 protected:
  Vector solve(const steppers::World& world, const steppers::Delassus& contacts, const Vector& start) const override {
    constexpr double kProximal = 1e-6;  // of the largest eigenvalue of W
    constexpr double kUnbalanced = 10;
    const auto& [W, g] = contacts;
    const double largest = largest_eigenvalue(W);
    const double eta = kProximal * largest;
    double power = 0.2;
    double rho = 0;
    SparseMatrix identity(W.rows(), W.cols());
    identity.setIdentity();
    Eigen::SimplicialLDLT<SparseMatrix> factors;
    factors.analyzePattern(W + identity);
    const auto choose = [&] {
      rho = std::sqrt(largest * eta) * std::pow(largest / eta, power);
      factors.factorize(W + (rho + eta) * identity);
    };
    choose();
    Vector x = start;
    Vector y = x;
    Vector z = dual(world, W * y + g);
    std::int64_t next_choice = 10;  // the last ones are far apart, so that the penalty comes to rest
    for (std::int64_t i = 1; i <= settings_.iterations; ++i) {
      const Vector s = de_saxce(world, z);
      const Vector right = z + rho * y + eta * x - g - s;  // not within solve(), which writes to x while it reads
      x = factors.solve(right);
      const Vector last = y;
      y = x - z / rho;
      project_on_cones(world, y);
      z -= rho * (x - y);
      const double primal = (x - y).norm();
      const double change = rho * (y - last).norm();
      if (std::max(largest * primal, change) <= settings_.tolerance * g.norm()) break;
      if (i < next_choice) continue;
      next_choice = i + std::max<std::int64_t>(10, i / 2);
      const double relative_primal = primal / std::max(x.norm(), y.norm());
      const double relative_change = change / z.norm();
      if (!(std::max(relative_primal, relative_change) > kUnbalanced * std::min(relative_primal, relative_change)))
        continue;
      power += relative_primal > relative_change ? 0.05 : -0.05;
      choose();
    }
    return y;
  }

 private:
  static double largest_eigenvalue(const SparseMatrix& W) {
    Vector x = Vector::LinSpaced(W.rows(), 1, 2);
    double value = 0;
    for (int i = 0; i < 20; ++i) {
      x.normalize();
      x = W * x;
      value = x.norm();
    }
    return value;
  }

  /// What sliding adds to the normals, so that bodies glide along the ground and do not lift off.
  static Vector de_saxce(const steppers::World& world, const Vector& velocity) {
    Vector s = Vector::Zero(velocity.size());
    for (std::size_t i = 0; i < world.contacts.size(); ++i) {
      const auto at = static_cast<Index>(3 * i);
      s(at) = world.contacts[i].mu * velocity.segment<2>(at + 1).norm();
    }
    return s;
  }

  /// The nearest point of the dual cones.
  static Vector dual(const steppers::World& world, const Vector& velocity) {
    Vector other = -velocity;
    project_on_cones(world, other);
    return velocity + other;
  }
};

}  // namespace

StepperDefinition lcpbench_stepper_admm() {
  return define_stepper<Admm, steppers::ConeStepperSettings>(
      {.name = "admm",
       .summary = "the alternating direction method of multipliers on contacts with the round cone",
       .source = "Carpentier, Le Lidec, Montaut, From compliant to rigid contact simulation, 2024"});
}

}  // namespace lcpbench
