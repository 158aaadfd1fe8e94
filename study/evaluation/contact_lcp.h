#pragma once

#include <cmath>
#include <memory_resource>
#include <optional>
#include <type_traits>
#include <vector>

#include "study/evaluation/bounded_inertia.h"
#include "core/compliance.h"
#include "core/quad_inertia.h"

namespace lcpbench {

/// The LCP of a contact problem in the arithmetic of Real, Quad or Bounded. M is never formed: a point z is carried
/// with its response, the velocity u = v + G* J f, from which any row of w = M z + q follows. A diagonal entry M_ii =
/// J_i' G* J_i costs one solve with G. Opposite directions of friction are twins: the columns of J that differ in sign
/// alone share their entries, and their rows share q_i, J_i'u and M_ii up to that sign.
template <class Real>
class ContactLcp {
  using Inertia = std::conditional_t<std::is_same_v<Real, Quad>, QuadInertia, BoundedInertia>;
  using RealVector = std::vector<Real>;

 public:
  /// @param problem, inertia, memory  must outlive this object; inertia.well_defined() must hold.
  ContactLcp(const ContactProblem& problem, const Inertia& inertia,
             std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  std::size_t size() const { return q_.size(); }
  Real q(std::size_t i) const { return q_[i]; }
  /// q_i - J_i'v: b_i of a normal row, the tangential offset along the direction of a friction row.
  Real offset(std::size_t i) const { return i < b_.size() ? b_[i] : Real{0}; }
  /// The offsets of the rows from this one on are zero.
  std::size_t offsets() const { return b_.size(); }

  /// u = v + G* J f for the impulses f in z. One solve with G; v itself where no impulse acts.
  RealVector response(const RealVector& z) const;
  /// w_i = (M z + q)_i. @param u  response(z)
  Real row(std::size_t i, const RealVector& z, const RealVector& u) const;
  /// All of w.
  RealVector all_rows(const RealVector& z, const RealVector& u) const;
  /// M_ii.
  Real diagonal(std::size_t i);
  /// Takes another M_ii for it and its twins.
  void set_diagonal(std::size_t i, Real value) {
    diagonals_.resize(impulses());
    diagonals_[twin_[i]] = value;
  }

  /// The earlier of the two twins that row j belongs to; j itself for a row without a twin.
  std::size_t representative(std::size_t j) const { return j < impulses() ? twin_[j] : j; }
  /// A lower bound of M_ii of a normal or friction row. O(entries of J_i), without a solve.
  double least_diagonal(std::size_t i) const
    requires std::is_same_v<Real, Bounded>
  {
    const Entries of = entries(i);
    return inertia_.least_energy({of.rows, of.count}, of.values);
  }

  std::size_t impulses() const { return begin_.size() - 1; }
  std::size_t contacts() const { return contacts_; }
  const RealVector& velocity_before() const { return v_; }
  /// The normal row of the contact to which cone row i belongs.
  std::size_t normal_of_cone(std::size_t i) const { return normal_of_cone_[i - impulses()]; }

  const ContactLayout& layout() const { return layout_; }

  /// Whether every impulse in z is zero.
  bool at_rest(const RealVector& z) const;
  /// J f for the impulses f in z.
  RealVector generalized_impulse(const RealVector& z) const;
  /// |J| |f|, entry by entry: the scale of rounding in J f.
  RealVector generalized_impulse_scale(const RealVector& z) const;
  /// A bound on what w_i may be off by through G*. @param bounds  QuadInertia::rounding() @param u  the velocity
  double rounding(std::size_t i, const std::vector<double>& bounds, const RealVector& u) const {
    double sum = 0;
    const Entries of = entries(i);
    const double own = static_cast<double>(of.count + 2) * 0x1p-110;
    for (std::size_t e = 0; e < of.count; ++e) {
      sum += std::abs(of.values[e]) * (bounds[of.rows[e]] + own * std::abs(to_double(u[of.rows[e]])));
    }
    return sum;
  }
  /// J_i' x.
  Real project(std::size_t i, const RealVector& x) const;
  /// The largest rounding error of q_i = J_i'v + b_i in double: (k + 1) 2^-53 (|J_i|'|v| + |b_i|), k the terms that
  /// are not zero in the data. 0 for cone rows, whose q_i is zero in the data. A Bounded one is formed in double.
  Real formation_error(std::size_t i) const;
  /// An upper bound of formation_error(i). O(1)
  double formation_limit(std::size_t i) const;

 private:
  /// The nonzero entries of a column of J; of the later twin, those of the earlier one, with the opposite sign.
  struct Entries {
    const std::size_t* rows;
    const double* values;
    std::size_t count;
  };
  Entries entries(std::size_t j) const {
    const std::size_t begin = begin_[twin_[j]];
    return {rows_.data() + begin, values_.data() + begin, begin_[twin_[j] + 1] - begin};
  }
  bool is_twin(std::size_t j) const { return twin_[j] != j; }

  /// What the compliance of its contact adds to row i. @pre soft_
  Real yielding(std::size_t i, const RealVector& z) const;
  void soften(const ContactProblem& problem);
  Real offset_size(std::size_t i) const;
  std::size_t offset_terms(std::size_t i) const;
  std::pair<Index, Index> friction_of_row(std::size_t i) const;
  void add_columns(const ContactProblem& problem);
  void add_column(const Jacobian& J, Index column);
  void add_twin(std::size_t of);
  void list_cones(const ContactProblem& problem, const ContactLayout& layout);
  /// sum of e values[e] x[rows[e]] over the entries of column i: J_i'x but for the sign of a twin.
  Real sum_of(std::size_t i, const RealVector& x) const;
  Real cone_row(std::size_t cone, const RealVector& z) const;

  const Inertia& inertia_;
  RealVector q_;
  RealVector v_;
  RealVector b_;  ///< of the rows from the first on; beyond its end zero
  std::size_t contacts_ = 0;
  ContactLayout layout_;
  std::optional<SoftRows<Real>> soft_;   ///< of a problem with compliance or tangential offsets
  std::pmr::vector<std::size_t> begin_;  ///< of each column of J = [N D], by columns; a twin has no entries of its own
  std::pmr::vector<std::size_t> rows_;
  std::pmr::vector<double> values_;
  std::pmr::vector<std::size_t>
      twin_;  ///< the column's own index, or that of an earlier column of which it is the negative
  std::pmr::vector<double> sizes_;        ///< of each column the sum of its magnitudes, rounded
  double largest_speed_ = 0;              ///< max |v_i|

  std::pmr::vector<Real> mu_;                       ///< of each cone row
  std::pmr::vector<std::size_t> normal_of_cone_;    ///< index in z of the cone's normal impulse
  std::pmr::vector<std::size_t> friction_of_cone_;  ///< cones + 1 offsets in z of the cone's friction impulses
  std::pmr::vector<std::size_t> lambda_of_;         ///< per friction impulse: index in z of its contact's lambda

  // These are allocated when they are first needed.
  std::vector<std::optional<Real>> diagonals_;  ///< of representatives
  RealVector scratch_;                          ///< ngc zeros between uses
};

}  // namespace lcpbench
