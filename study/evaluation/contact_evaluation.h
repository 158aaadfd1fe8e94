#pragma once

#include <cstddef>
#include <memory_resource>
#include <optional>
#include <type_traits>
#include <vector>

#include "core/exact_inertia.h"
#include "core/round_cone.h"
#include "study/evaluation/cone_friction.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/contact_lcp.h"
#include "study/evaluation/island_rows.h"

namespace lcpbench {

/// The contact side of an Evaluator: what needs v, N, D, mu and G apart.
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

  /// v + G* J f and w = M z + q, of exact arithmetic where the rounding of G* in 113 bits may count. @returns false
  /// where it may count and exact arithmetic does not take the inertia
  bool respond(const Vector& answer, const RealVector& z, RealVector& v_plus, RealVector& w);
  void measure(const RealVector& z, const RealVector& v_plus, const RealVector& w, Errors& errors);
  /// Whether the rounding of G* in 113 bits may be a part of the residuals that counts.
  bool is_in_doubt(const RealVector& z, const RealVector& v_plus, const RealVector& w);
  /// From now on residuals are those of exact arithmetic, where there is G* in it.
  bool resolve();
  double forward_velocity(const RealVector& velocity) const;
  /// Of the islands' residuals. An answer that leaves none needs no scale.
  const RealVector& scales();
  /// M_ii of a normal or friction row.
  Real diagonal(std::size_t row);
  /// The entry of r, see Errors::velocity_residual_m_per_s. @param w  all rows under z
  Real row_residual(std::size_t row, const RealVector& z, const RealVector& w);

  const ContactProblem& problem;
  const IslandRows& islands;
  RealInertia inertia;
  std::optional<ContactLcp<Real>> lcp;
  std::optional<ConeFriction<Real>> cone;  // where the friction names one
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
