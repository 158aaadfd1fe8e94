#pragma once

#include <cstddef>
#include <optional>

#include "core/round_cone.h"
#include "study/evaluation/cone_friction.h"
#include "study/evaluation/contact_lcp.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/island_rows.h"

namespace lcpbench {

/// Measures the answers to one contact problem in 113 bits: the part of an Evaluator that needs v, N, D, mu and G,
/// which an LCP's q and M do not show.
struct ContactEvaluation {
  /// @param contact, of_rows  must outlive this object
  ContactEvaluation(const ContactProblem& contact, const IslandRows& of_rows)
      : problem(contact), islands(of_rows), inertia(contact.inertia) {
    if (!inertia.well_defined()) return;
    lcp.emplace(contact, inertia);
    if (contact.frictional() && why_no_cone(contact).empty()) cone.emplace(contact, *lcp);
  }

  /// @param v_plus, w  the response and all rows of the LCP under z
  void measure(const QuadVector& z, const QuadVector& v_plus, const QuadVector& w, Errors& errors);
  double forward_velocity(const QuadVector& velocity) const;
  /// scale_I of each island, see Errors::velocity_residual_relative; computed at the first call.
  const QuadVector& scales();
  /// The entry of r, see Errors::velocity_residual_m_per_s. @param w  all rows under z
  Quad row_residual(std::size_t row, const QuadVector& z, const QuadVector& w);

  const ContactProblem& problem;
  const IslandRows& islands;
  RefinedInertia inertia;
  std::optional<ContactLcp> lcp;
  std::optional<ConeFriction> cone;  // none without friction, or if its directions name no cone
  std::optional<QuadVector> v_star;

 private:
  QuadVector measure_residual(const QuadVector& z, const QuadVector& w, Errors& errors);
  double model_error(const QuadVector& z, const QuadVector& v_plus, const QuadVector& residuals);
  Quad work_gain(const QuadVector& z, const QuadVector& v_plus) const;

  QuadVector scales_;  // made by scales()
};

}  // namespace lcpbench
