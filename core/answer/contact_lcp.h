#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/answer/contact_scale.h"
#include "core/answer/refined_inertia.h"
#include "core/compliance.h"

namespace lcpbench {

/// The LCP of a contact problem in 113 bits. M is never formed: a point z is carried
/// with its response, the velocity u = v + G* J f, from which any row of w = M z + q follows. A diagonal entry M_ii =
/// J_i' G* J_i costs one solve with G. Opposite directions of friction are twins: the columns of J that differ in sign
/// alone share their entries, and their rows share q_i, J_i'u and M_ii up to that sign. Bounded rows come last, after
/// the cone rows, which have no velocity. One thread at a time: const members share scratch.
class ContactLcp {
 public:
  /// @param problem, inertia  must outlive this object; inertia.well_defined() must hold.
  ContactLcp(const ContactProblem& problem, const RefinedInertia& inertia);

  /// Another velocity before the impact (ngc), in place of that of the problem.
  void set_velocity(const Vector& v);

  std::size_t size() const { return static_cast<std::size_t>(layout_.size()); }
  /// Of all rows but the cone rows, where it is zero.
  Quad q(std::size_t i) const { return project(i, v_) + offset(i); }
  /// q_i - J_i'v: b_i of a normal or bounded row, the tangential offset along the direction of a friction row.
  Quad offset(std::size_t i) const {
    if (is_bounded(i)) return problem_.rows.offset(number_of(i));
    return i < b_.size() ? b_[i] : Quad{0};
  }
  /// f'offset: what impulses gain by the offsets of their rows, with the opposite sign.
  Quad offset_work(const QuadVector& z) const;

  /// u = v + G* J f for the impulses f in z. One solve with G; v itself where no impulse acts.
  QuadVector response(const QuadVector& z) const {
    QuadVector u;
    respond(z, u);
    return u;
  }
  /// u := response(z), in the memory of u.
  void respond(const QuadVector& z, QuadVector& u) const;
  /// How far response() may be off where the inertia has reduced rank: see RefinedInertia::solve_error(). Else empty.
  QuadVector response_error(const QuadVector& z) const;
  /// How far that makes the residual of row i be off, M_ii included. @param off  response_error(z)
  Quad residual_error(std::size_t i, const QuadVector& z, Quad w, const QuadVector& off);
  /// w = M z + q. @param u  response(z)
  QuadVector all_rows(const QuadVector& z, const QuadVector& u) const {
    QuadVector w;
    write_rows(z, u, w);
    return w;
  }
  /// w := all_rows(z, u), in the memory of w.
  void write_rows(const QuadVector& z, const QuadVector& u, QuadVector& w) const;
  /// Sets the lambdas of z to the least doubles that its impulses allow. @param u  response(z)
  void complete(QuadVector& z, const QuadVector& u) const;
  /// w_i of a row without lambda: the velocity along it, with offset and compliance. @pre no cone row
  Quad velocity(std::size_t i, const QuadVector& z, const QuadVector& u) const {
    return project(i, u) + offset(i) + (soft_ || is_bounded(i) ? yielding(i, z) : Quad{0});
  }
  /// M_ii; 0 of a cone row.
  Quad diagonal(std::size_t i);
  /// |mid(M_ii (f - lower), M_ii (f - upper), w)| of a bounded row [m/s, rad/s]. @param w  w_i
  Quad bounded_residual(std::size_t i, const QuadVector& z, Quad w);
  /// |M_ci| over sqrt(M_cc M_ii) from which on a row moves a contact: less may be rounding.
  static constexpr double kLeastCoupling = 1e-9;
  /// What turns the residual of a bounded row into m/s: of an angle the root of M_cc / M_ii, both without compliance,
  /// M_cc the median over the contacts that the row moves, else over those of its island, else over the island's rows
  /// in m. 1 of rows in m, where M_ii = 0, and where there is no such M_cc.
  Quad lever(std::size_t i);
  /// How many rows from the first on are normal or friction rows.
  std::size_t impulses() const { return static_cast<std::size_t>(layout_.lambda_offset()); }
  bool is_bounded(std::size_t i) const { return i >= first_bounded_; }
  std::size_t first_bounded() const { return first_bounded_; }
  std::size_t contacts() const { return contacts_; }
  const QuadVector& velocity_before() const { return v_; }
  /// The contact to which row i belongs. @pre it is not bounded
  Index contact_of(Index i) const {
    if (i >= layout_.lambda_offset())
      return layout_.cone_contact[static_cast<std::size_t>(i - layout_.lambda_offset())];
    return i < layout_.nc ? i : contact_of_[static_cast<std::size_t>(i - layout_.nc)];
  }
  /// The normal row of the contact to which cone row i belongs.
  std::size_t normal_of_cone(std::size_t i) const {
    return static_cast<std::size_t>(layout_.cone_contact[i - impulses()]);
  }

  const ContactLayout& layout() const { return layout_; }

  /// Whether every impulse in z is zero.
  bool at_rest(const QuadVector& z) const;
  /// J f for the impulses f in z. Impulses that cancel leave what 113 bits lose of their sum.
  QuadVector generalized_impulse(const QuadVector& z) const {
    QuadVector impulse;
    sum_impulses(z, impulse);
    return impulse;
  }
  /// |J| |f|, entry by entry: the scale of rounding in J f.
  QuadVector generalized_impulse_scale(const QuadVector& z) const;
  /// What the residuals of an island are relative to, from its rows. @param without  the residual of no impulses, where
  /// it is not that of pyramid and cone
  Quad scale(std::span<const std::size_t> rows, std::optional<Quad> without = std::nullopt);
  /// J_i' x.
  Quad project(std::size_t i, const QuadVector& x) const;

 private:
  /// The nonzero entries of a column of J; of the later twin, those of the earlier one, with the opposite sign.
  struct Entries {
    const std::size_t* rows;
    const double* values;
    std::size_t count;
  };
  Entries entries(std::size_t i) const {
    const std::size_t j = column_of(i);
    const std::size_t begin = begin_[twin_[j]];
    return {rows_.data() + begin, values_.data() + begin, begin_[twin_[j] + 1] - begin};
  }
  /// Of row i of z, no cone row, in J.
  std::size_t column_of(std::size_t i) const {
    return is_bounded(i) ? i - static_cast<std::size_t>(layout_.cones) : i;
  }
  /// Calls visit(i) for each row i of z that has an impulse.
  template <class Visit>
  void for_each_impulse(const QuadVector& z, const Visit& visit) const {
    for (std::size_t i = 0; i < impulses(); ++i) {
      if (z[i] != 0) visit(i);
    }
    for (std::size_t i = first_bounded_; i < size(); ++i) {
      if (z[i] != 0) visit(i);
    }
  }
  bool is_twin(std::size_t i) const {
    const std::size_t j = column_of(i);
    return twin_[j] != j;
  }
  /// The number of a bounded row among these.
  Index number_of(std::size_t i) const { return static_cast<Index>(i - first_bounded_); }

  /// What the compliance of its contact adds to row i, or its own. @pre soft_, or i is bounded
  Quad yielding(std::size_t i, const QuadVector& z) const;
  void soften();
  /// impulse := generalized_impulse(z)
  void sum_impulses(const QuadVector& z, QuadVector& impulse) const;
  /// @param fastest  the normal row of the largest -q_i
  template <class Number>
  ContactScale<Number> scale_in(std::span<const std::size_t> rows, std::size_t& fastest) const;
  template <class Number>
  Number add_velocity_before(std::size_t row, Number lever, ContactScale<Number>& scale) const;
  void add_bounded_rows(std::span<const std::size_t> rows, ContactScale<Quad>& scale);
  /// Of f_i of a bounded row, for the impulses in z.
  std::pair<Quad, Quad> bounds(std::size_t i, const QuadVector& z) const;
  std::pair<Index, Index> friction_of_row(std::size_t i) const;
  void add_columns();
  void add_column(const Jacobian& J, Index column);
  void add_twin(std::size_t of);
  /// sum of e values[e] x[rows[e]] over the entries of column i: J_i'x but for the sign of a twin.
  Quad sum_of(std::size_t i, const QuadVector& x) const;
  Quad cone_row(std::size_t i, const QuadVector& z) const;
  /// |J_i|'x.
  Quad project_magnitudes(std::size_t i, const QuadVector& x) const;
  Quad diagonal_error(std::size_t i) const;
  /// M_ii without compliance.
  Quad rigid_diagonal(std::size_t i);
  /// The entry of row i of J for a coordinate that it moves.
  double entry_of(std::size_t i, std::size_t coordinate) const;
  void find_levers();
  /// The index of the lambda of a friction row.
  std::size_t lambda_of(std::size_t i) const {
    return impulses() + static_cast<std::size_t>(layout_.lambda[static_cast<std::size_t>(contact_of_[i - contacts_])]);
  }

  const ContactProblem& problem_;
  const RefinedInertia& inertia_;
  Vector velocity_;  ///< before the impact
  QuadVector v_;     ///< the same
  QuadVector b_;  ///< of the rows from the first on; beyond its end zero
  std::size_t contacts_ = 0;
  ContactLayout layout_;
  std::size_t first_bounded_ = 0;
  std::optional<SoftRows<Quad>> soft_;  ///< of a problem with compliance or tangential offsets
  std::vector<std::size_t> begin_{0};   ///< of each column of J = [N D R], by columns; a twin has no entries of its own
  std::vector<std::size_t> rows_;
  std::vector<double> values_;
  std::vector<std::size_t> twin_;  ///< the column's own index, or that of an earlier column that is its negative
  std::vector<Index> contact_of_;  ///< of each friction row
  std::vector<std::optional<Quad>> diagonals_;  ///< without compliance; of the first of twins, where they were asked for
  QuadVector levers_;                           ///< of bounded rows, once one was asked for
  mutable QuadVector lost_;
};

}  // namespace lcpbench
