#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/lcp.h"
#include "study/evaluation/bounded_inertia.h"
#include "core/quad_inertia.h"

namespace lcpbench {

/// Rows of |M| in double, made when they are first asked for, with a bound on their error. They decide which rows of M
/// are worth measuring in the arithmetic of the measures, and never enter a measure.
struct MagnitudeEstimate {
  struct Row {
    bool known = false;
    std::size_t begin = 0, end = 0;  ///< of its entries, in the columns that represent others
    double sum = 0;                  ///< of all |M_ij|
    double diagonal = 0;             ///< M_ii
    double error = 0;                ///< | |M_ij| - entry | <= error column_scale[j]; entries left out are zero
  };
  std::vector<Row> rows;
  std::vector<std::size_t> columns;  ///< of the entries; there is room for more than there are
  std::vector<double> entries;
  std::size_t count = 0;  ///< of the entries
  std::vector<double> column_scale;

  void make_room(std::size_t more) {
    if (count + more <= entries.size()) return;
    columns.resize(2 * (count + more));
    entries.resize(2 * (count + more));
  }
  /// Where there is room.
  void add(std::size_t column, double entry) {
    columns[count] = column;
    entries[count++] = entry;
  }
};

/// LCP(q, M) in the arithmetic of Real, Quad or Bounded, behind an interface that never asks for the whole of M.
///
/// A point z is carried with its response u = response(z), from which any row of w = M z + q follows and which is cheap
/// to correct when an entry of z is set to zero. `support` always lists the nonzero entries of z.
template <class Real>
class EvaluatedLcp {
 public:
  virtual ~EvaluatedLcp() = default;
  EvaluatedLcp() = default;
  EvaluatedLcp(const EvaluatedLcp&) = delete;
  EvaluatedLcp& operator=(const EvaluatedLcp&) = delete;

  std::size_t size() const { return q_.size(); }
  Real q(std::size_t i) const { return q_[i]; }

  /// Entries from here on are lambdas [m/s]; those before are impulses [N s]. size() where there is one kind only.
  virtual std::size_t lambda_offset() const { return size(); }

  virtual std::vector<Real> response(const std::vector<Real>& z) = 0;
  /// Sets what z's entries of an island determine of u to what response() makes of it.
  /// @param rows  of the island, ascending.
  virtual void respond(std::span<const std::size_t> rows, const std::vector<Real>& z, std::vector<Real>& u) = 0;
  /// Corrects u for z_j, whose value was `value`, becoming zero.
  virtual void remove(std::size_t j, Real value, std::vector<Real>& u) = 0;
  /// w_i = (M z + q)_i.
  virtual Real row(std::size_t i, const std::vector<Real>& z, const std::vector<Real>& u) const = 0;
  /// Sets w_i for each of `rows`, ascending; a friction row's contact has all of its rows among them.
  virtual void fill_rows(std::span<const std::size_t> rows, const std::vector<Real>& z, const std::vector<Real>& u,
                         std::vector<Real>& w) const;
  /// All of w.
  std::vector<Real> all_rows(const std::vector<Real>& z, const std::vector<Real>& u) const;
  /// M_ii.
  virtual Real diagonal(std::size_t i) = 0;
  /// sum over the support of |M_ij| |z_j|.
  virtual Real abs_row_times(std::size_t i, const std::vector<Real>& z, std::span<const std::size_t> support) = 0;
  /// ||M_i||_1.
  virtual Real abs_row_sum(std::size_t i) = 0;

  /// At most abs_row_times() and abs_row_sum(), for z >= 0 and in double: by those entries of M that are in the data,
  /// all of a cone row and a friction row's of its lambda, and by a lower bound of M_ii.
  virtual double plain_row_times(std::size_t, const std::vector<Real>&) const { return 0; }
  virtual double plain_row_sum(std::size_t) const { return 0; }

  /// The column of the same magnitudes that stands for column j in the estimate; so it does for row j.
  virtual std::size_t representative(std::size_t j) const { return j; }
  /// Made on first use, for row i's representative. nullptr when the estimate would hold more than about 2^25 entries.
  const MagnitudeEstimate::Row* estimated_row(std::size_t i);
  /// The rows that were asked for.
  const MagnitudeEstimate& estimate() const { return estimate_; }
  /// w in double, without a bound on its error: size() entries, of which those of `rows` are filled.
  virtual std::vector<double> estimate_w(const std::vector<Real>& z, const std::vector<Real>& u,
                                         std::span<const std::size_t> rows) const = 0;

 protected:
  static constexpr std::size_t kLargestEstimate = std::size_t{1} << 25;

  virtual double column_scale(std::size_t j) const = 0;
  /// Adds the entries of a representative row, and sets all else but where they begin and end.
  virtual void fill_row(std::size_t i, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) = 0;

  std::vector<Real> q_;

 private:
  MagnitudeEstimate estimate_;
};

using QuadLcp = EvaluatedLcp<Quad>;

/// The LCP of given q and M, in 113 bits. u is w itself.
class BareQuadLcp final : public QuadLcp {
 public:
  /// @param lcp  must outlive this object.
  explicit BareQuadLcp(const Lcp& lcp);

  QuadVector response(const QuadVector& z) override;
  void respond(std::span<const std::size_t> rows, const QuadVector& z, QuadVector& u) override;
  void remove(std::size_t j, Quad value, QuadVector& u) override;
  Quad row(std::size_t i, const QuadVector& z, const QuadVector& u) const override;
  Quad diagonal(std::size_t i) override;
  Quad abs_row_times(std::size_t i, const QuadVector& z, std::span<const std::size_t> support) override;
  Quad abs_row_sum(std::size_t i) override;
  std::vector<double> estimate_w(const QuadVector& z, const QuadVector& u,
                                 std::span<const std::size_t> rows) const override;

 private:
  double column_scale(std::size_t) const override { return 0; }
  void fill_row(std::size_t i, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) override;
  double M(std::size_t i, std::size_t j) const { return lcp_.M(static_cast<Index>(i), static_cast<Index>(j)); }

  const Lcp& lcp_;
};

/// The LCP of a contact problem. u is the velocity v + G* J f, so M is never formed: an entry M_ij = J_i' G* J_j costs
/// one solve with G (kept per column) and one product of sparse columns. M is symmetric in the impulses, as G* is.
template <class Real>
class ContactLcp final : public EvaluatedLcp<Real> {
  using Inertia = std::conditional_t<std::is_same_v<Real, Quad>, QuadInertia, BoundedInertia>;
  using RealVector = std::vector<Real>;
  using EvaluatedLcp<Real>::q_;

 public:
  /// @param problem, inertia, memory  must outlive this object; inertia.well_defined() must hold.
  ContactLcp(const ContactProblem& problem, const Inertia& inertia,
             std::pmr::memory_resource* memory = std::pmr::get_default_resource());

  std::size_t lambda_offset() const override { return impulses(); }
  RealVector response(const RealVector& z) override;
  void respond(std::span<const std::size_t> rows, const RealVector& z, RealVector& u) override;
  void remove(std::size_t j, Real value, RealVector& u) override;
  Real row(std::size_t i, const RealVector& z, const RealVector& u) const override;
  void fill_rows(std::span<const std::size_t> rows, const RealVector& z, const RealVector& u,
                 RealVector& w) const override;
  Real diagonal(std::size_t i) override;
  Real abs_row_times(std::size_t i, const RealVector& z, std::span<const std::size_t> support) override;
  Real abs_row_sum(std::size_t i) override;
  std::vector<double> estimate_w(const RealVector& z, const RealVector& u,
                                 std::span<const std::size_t> rows) const override;

  double plain_row_times(std::size_t i, const RealVector& z) const override;
  double plain_row_sum(std::size_t i) const override;
  std::size_t representative(std::size_t j) const override { return j < impulses() ? twin_[j] : j; }
  /// M_ii is at least this, found at the cost of the row's entries of J, or by an estimate of the row.
  double plain_least_diagonal(std::size_t i) const;
  double least_diagonal(std::size_t i);

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
  /// |J| |f|: the scale of rounding in J f.
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
  /// What forming q_i = J_i'v + b_i in double may lose to rounding: (k + 1) 2^-53 (|J_i|'|v| + |b_i|), k the terms that
  /// are not zero in the data. 0 for cone rows, whose q_i is zero in the data. A Bounded one is formed in double.
  Real formation_error(std::size_t i) const;
  /// At least that, without looking at the row's entries.
  double formation_limit(std::size_t i) const;

 private:
  /// G* J_j by its nonzero blocks.
  struct Response {
    bool known = false;
    std::vector<std::size_t> pattern;
    RealVector values;
    Real diagonal = 0;  ///< M_jj
  };

  /// The nonzero entries of a column of J, but for its sign: twins share them.
  struct Entries {
    const std::size_t* rows;
    const double* values;
    std::size_t count;
  };
  Entries entries(std::size_t j) const {
    const std::size_t begin = begin_[twin_[j]];
    return {rows_.data() + begin, values_.data() + begin, begin_[twin_[j] + 1] - begin};
  }
  std::span<const std::size_t> rows(std::size_t j) const { return std::span(entries(j).rows, entries(j).count); }
  bool is_twin(std::size_t j) const { return twin_[j] != j; }

  /// b_i of a normal row, 0 of any other.
  Real offset(std::size_t i) const { return i < b_.size() ? b_[i] : Real{0}; }
  void add_columns(const ContactProblem& problem);
  void add_column(const Jacobian& J, Index column);
  void add_twin(std::size_t of);
  void list_cones(const ContactProblem& problem, const ContactLayout& layout);
  void list_columns_of_rows();
  /// Calls visit(j) for each column j, but for twins, that has an entry in a row of the pattern.
  template <class Visit>
  void for_each_column_at(const std::vector<std::size_t>& pattern, Visit&& visit);
  /// sum of e values[e] x[rows[e]] over the entries of column i: J_i'x but for the sign of a twin.
  Real sum_of(std::size_t i, const RealVector& x) const;
  /// The same for v before the impact, given as doubles, too.
  Real speed_before(std::size_t i, const Vector& v) const;
  const Response& response_of(std::size_t column);
  Real cone_row(std::size_t cone, const RealVector& z) const;
  double column_scale(std::size_t j) const override;
  void fill_row(std::size_t i, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) override;
  void fill_cone_row(std::size_t cone, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) const;
  /// G* J_i in estimate_x_, for the rows in estimate_pattern_. Returns a bound on the error of an entry.
  double estimate_response(std::size_t i);
  double sum_of_entries(std::size_t begin, std::size_t end, const double* x) const;
  /// Spreads the response over scratch_; gather() makes scratch_ zero again.
  void scatter(const Response& response);
  void gather(const Response& response);

  const Inertia& inertia_;
  RealVector v_;
  RealVector b_;  ///< of the normal rows; empty: zero
  std::size_t contacts_ = 0;
  ContactLayout layout_;
  std::pmr::vector<std::size_t> begin_;  ///< of each column of J = [N D], by columns; a twin has no entries of its own
  std::pmr::vector<std::size_t> rows_;
  std::pmr::vector<double> values_;
  std::pmr::vector<std::size_t>
      twin_;  ///< the column's own index, or that of an earlier column of which it is the negative
  std::pmr::vector<double> sizes_;        ///< of each column the sum of its magnitudes, rounded
  double largest_speed_ = 0;              ///< max |v_i|
  std::pmr::vector<double> represented_;  ///< columns of which it is the twin
  std::vector<std::size_t> row_begin_;    ///< the columns that meet each row of J but for twins, when first asked for
  std::vector<std::size_t> columns_of_row_;
  std::vector<std::size_t> twin_from_;  ///< of each column the one that is its twin, or itself; listed with the others

  std::pmr::vector<Real> mu_;                       ///< of each cone row
  std::pmr::vector<std::size_t> normal_of_cone_;    ///< index in z of the cone's normal impulse
  std::pmr::vector<std::size_t> friction_of_cone_;  ///< cones + 1 offsets in z of the cone's friction impulses
  std::pmr::vector<std::size_t> lambda_of_;         ///< per friction impulse: index in z of its contact's lambda

  // What follows is allocated when it is first needed.
  mutable std::vector<double> least_diagonals_;  ///< plain ones, of representatives
  std::vector<Response> responses_;
  RealVector abs_row_sum_;
  std::vector<bool> abs_row_sum_known_;
  RealVector scratch_;              ///< ngc zeros between uses
  std::vector<double> estimate_x_;  ///< the same, in double
  std::vector<std::size_t> estimate_pattern_;
  std::vector<std::uint32_t> visited_;  ///< per column: the last visit's number
  std::uint32_t visit_ = 0;
};

using ContactQuadLcp = ContactLcp<Quad>;

}  // namespace lcpbench
