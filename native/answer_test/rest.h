#pragma once

#include "core/answer/contact_scale.h"
#include "core/contact_problem.h"
#include "core/quad.h"

namespace lcpbench {

/// Whether z = 0, with the slips at v as lambdas, solves an island by the measure of the verdict. Contacts may approach
/// if that is the rounding of N'v + b, or far slower than the other velocities. For islands that no method solved.
///
/// The sums are taken in 113 bits. Never with inertia that may be singular, or an offset below zero: there need be no
/// solution. Allocates nothing.
class RestTest {
 public:
  /// @param layout of the problem @param v the velocity now
  RestTest(const ContactProblem& problem, const ContactLayout& layout, const Vector& v)
      : problem_(problem), layout_(layout), v_(v) {}

  /// @pre all contacts added are in one island
  void add(Index contact);
  bool passes() const;

 private:
  const ContactProblem& problem_;
  const ContactLayout& layout_;
  const Vector& v_;
  ContactScale<Quad> scale_;
};

}  // namespace lcpbench
