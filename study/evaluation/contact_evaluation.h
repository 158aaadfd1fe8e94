#pragma once

#include <cstddef>
#include <memory_resource>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/exact_inertia.h"
#include "core/round_cone.h"
#include "study/evaluation/cone_friction.h"
#include "study/evaluation/contact_lcp.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/island_rows.h"

namespace lcpbench {

/// Measures the answers to one contact problem in the arithmetic of Real: the part of an Evaluator that needs v, N, D,
/// mu and G, which an LCP's q and M do not show.
template <class Real>
struct ContactEvaluation {
  using RealVector = std::vector<Real>;
  using RealInertia = std::conditional_t<std::is_same_v<Real, Quad>, QuadInertia, BoundedInertia>;

  /// @param memory  must outlive this object.
  ContactEvaluation(const ContactProblem& contact, const IslandRows& of_rows, std::pmr::memory_resource* memory)
      : problem(contact), islands(of_rows), inertia(inertia_in(memory, contact.inertia)) {
    if (!inertia.well_defined()) return;
    lcp.emplace(contact, inertia, memory);
    if constexpr (std::is_same_v<Real, Quad>) {
      if (inertia.needs_exact()) resolve();
    }
    if (contact.frictional() && why_no_round_cone(contact).empty()) cone.emplace(contact, *lcp);
  }

  /// Computes v + G* J f and w = M z + q, in exact arithmetic if the rounding of G* in 113 bits may matter. @returns
  /// false if it may matter and exact arithmetic does not take the inertia
  bool respond(const Vector& answer, const RealVector& z, RealVector& v_plus, RealVector& w);
  void measure(const RealVector& z, const RealVector& v_plus, const RealVector& w, Errors& errors);
  /// Whether the rounding of G* in 113 bits may change the residuals noticeably.
  bool is_in_doubt(const RealVector& z, const RealVector& v_plus, const RealVector& w);
  /// Makes `exact`, by which residuals are computed from then on. @returns false if exact arithmetic does not take the
  /// inertia
  bool resolve();
  double forward_velocity(const RealVector& velocity) const;
  /// scale_I of each island, see Errors::velocity_residual_relative; computed at the first call.
  const RealVector& scales();
  /// M_ii of a normal or friction row.
  Real diagonal(std::size_t row);
  /// The entry of r, see Errors::velocity_residual_m_per_s. @param w  all rows under z
  Real row_residual(std::size_t row, const RealVector& z, const RealVector& w);

  const ContactProblem& problem;
  const IslandRows& islands;
  RealInertia inertia;
  std::optional<ContactLcp<Real>> lcp;
  std::optional<ConeFriction<Real>> cone;  // none without friction, or if its directions name no round cone
  std::optional<RealVector> v_star;
  std::optional<ExactContacts> exact;

 private:
  static RealInertia inertia_in(std::pmr::memory_resource* memory, const Inertia& inertia) {
    if constexpr (std::is_same_v<Real, Quad>) {
      return RealInertia(inertia);
    } else {
      return RealInertia(inertia, memory);
    }
  }
  Real island_scale(std::size_t island) const;
  RealVector measure_residual(const RealVector& z, const RealVector& w, Errors& errors);
  double model_error(const RealVector& z, const RealVector& v_plus, const RealVector& residuals);
  Real work_gain(const RealVector& z, const RealVector& v_plus) const;
  Real work_of_offset(const RealVector& z) const;

  RealVector scales_;     // made by scales()
  RealVector diagonals_;  // of exact; -1 where not yet made
};

}  // namespace lcpbench
