#pragma once

#include "native/steppers/world.h"

namespace lcpbench::steppers {

/// How the velocities at the contacts depend on the impulses f, three numbers a contact in its frame: W f + g, with the
/// offsets of the normals in g.
struct Delassus {
  SparseMatrix W;
  Vector g;
};

/// @param world  with the forces of the step in its velocities
Delassus delassus(const World& world, double h);

/// Moves the three numbers of each contact to the nearest point of its cone |f_T| <= mu f_N.
void project_on_cones(const World& world, Vector& f);

struct ConeStepperSettings {
  std::int64_t iterations = 100;
  double tolerance = 1e-8;
  Projection projection;
  bool warm = true;

  void visit(auto&& field) {
    field("iterations", iterations, IntegerRange{.min = 1}, "at most");
    field("tolerance", tolerance, RealRange{.min = 0},
          "stop when the residuals, as velocities, are at most this share of the free velocities: admm by Euclidean "
          "norms, apgd by largest entries");
    field("warm", warm, "start from the impulses of the step before, by contact");
    projection.visit(field);
  }
};

/// A stepper that solves for all impulses of the round cones at once. Positions as in sequential_impulses.
class ConeStepper : public BodyStepper {
 public:
  explicit ConeStepper(const ConeStepperSettings& settings) : settings_(settings) {}

 protected:
  /// @param start impulses within the cones @returns the impulses. @pre there is a contact
  virtual Vector solve(const World& world, const Delassus& contacts, const Vector& start) const = 0;

  ConeStepperSettings settings_;

 private:
  void run(World& world, double h) final;
};

}  // namespace lcpbench::steppers
