#pragma once

#include <optional>
#include <vector>

#include "core/answer/contact_scale.h"
#include "core/contact_problem.h"
#include "core/islands.h"
#include "core/quad_inertia.h"

namespace lcpbench {

/// Whether impulses solve contacts with the round Coulomb cone, or its convex relaxation, by the measure of the verdict
/// and from the data alone: the solver's own residual uses the root of the inertia that made the answer.
class ConeTest {
 public:
  /// Factors the inertia and finds M_ii. @param problem  must stay as it is until the next load.
  /// @pre why_no_round_cone() is empty
  void load(const ContactProblem& problem, bool convex);

  /// The largest residual relative to its island's scale, in 113 bits; infinity where the inertia is not resolved.
  /// Allocates nothing for inertia that 113 bits prove positive definite.
  /// @param v  before the impact @param z  of the LCP, finite @param error  [m/s] residuals up to this count as zero
  double residual(const Vector& v, const Vector& z, double error);

  /// v+ of the last residual().
  void take_velocity(Vector& velocity) const {
    for (Index i = 0; i < velocity.size(); ++i) velocity(i) = to_double(u_[static_cast<std::size_t>(i)]);
  }

 private:
  void measure_scales(const Vector& v);
  Quad project(Index column, const QuadVector& x) const;
  Quad diagonal(Index column);
  Quad friction_residual(Index contact, const Vector& z) const;
  Quad convex_residual(Index contact, const Vector& z) const;
  Quad normal_velocity(Index contact, const Vector& z) const;
  struct Tangential {
    Quad f1 = 0, f2 = 0, w1 = 0, w2 = 0;
  };
  Tangential tangential(Index contact, const Vector& z) const;

  const ContactProblem* problem_ = nullptr;
  bool convex_ = false;
  ContactLayout layout_;
  RowIslands islands_;
  std::optional<QuadInertia> inertia_;
  QuadVector normal_, tangent_;  ///< M_nn and M_tt, by contact
  QuadVector u_, residuals_;
  std::vector<ContactScale<Quad>> scales_;  ///< by island
  Vector none_;                             ///< no impulses
};

}  // namespace lcpbench
