#pragma once

#include <limits>
#include <vector>

#include "core/contact_problem.h"
#include "core/solver.h"

namespace lcpbench {

/// Whether hard contacts can hold an island at rest: the velocity u = 0.
///
/// They can if, and only if, impulses f in the friction cones balance the momentum, J f = -G v, with f_N = 0 where a
/// contact is open (b > 0). Offsets of at most kTouching times the fastest approach count as zero. G must be given.
class Rest {
 public:
  /// Relative to the fastest approach: what a contact may be open, and still touch.
  static constexpr double kTouching = 1e-9;
  /// Imbalance (see there) that is rounding, and the largest of rest: roundings of v may lie where no contact can
  /// balance them. Impulses of rest may be near those of an iterative method with kNear; and near those of a method
  /// that pivots with kNearByPivots, unless masses of a ratio above kUnlike cost it its digits.
  static constexpr double kRounding = 64 * std::numeric_limits<double>::epsilon(), kBalanced = 4e-12;
  /// Largest residual_speed() of impulses that stay as they were in the last step: `auto` aims at 1e-9 from nothing.
  static constexpr double kStill = 5e-10;
  static constexpr double kNear = 0.1, kNearByPivots = 1e-7, kUnlike = 1e8;

  static bool takes(const ContactProblem& contact);

  /// Takes the memory of load().
  void reserve(Index coordinates) { room_.resize(coordinates, kParts); }
  /// O(nonzeros of N and G). @pre takes() @param contact must outlive the next load @param v velocity before the
  /// impact; likewise
  void load(const ContactProblem& contact, const Vector& v);

  /// Whether the offsets and some v allow rest at all.
  bool is_possible() const { return is_possible_; }
  /// Offset up to which a contact touches.
  double touching() const { return touching_; }

  /// By how much the impulses of z miss the balance of the momentum, over the magnitudes that it sums up, of the worst
  /// body; each coordinate counts by the root of its energy. More than kBalanced if a
  /// coordinate misses much of its own terms. Infinity if an impulse is outside of its cone, or presses
  /// an open contact. O(nonzeros)
  double imbalance(const Vector& z);
  /// Of the z that imbalance() measured last: the fastest velocity at a contact that the missing momentum would give
  /// each coordinate by itself, over the fastest approach. O(nonzeros)
  double residual_speed();
  /// Takes away impulses of open contacts and what is outside of a cone. O(n)
  void bring_into_cones(Vector& z) const;
  /// Of the coordinates that contacts move, by the diagonal of G.
  double ratio_of_masses() const;
  /// Whether they may, by the balance of the fastest coordinate: false for most answers that move. O(nonzeros)
  static bool may_hold(const ContactProblem& contact, const Vector& v, const Vector& z);

  /// Whether no impulses hold it: the momentum is not in their range; or there is a y with (N_i + mu_i d)'y >= 0 for
  /// every touching contact and direction, and y'G v > 0: impulses in the cones never give y less momentum, but all of
  /// it would have to go. Looks for y of a single body, and then near a velocity, by a few sweeps of projections; a
  /// proof may be missed. O(nonzeros) for each sweep
  /// @param near velocity of an answer that slips
  bool is_refuted(const Vector& near);

  /// v+ of the island at rest: coordinates that no contact moves keep their velocity. Empty where G may be singular:
  /// then motion without momentum goes on. O(size^3) for each block of G
  void write_velocity(AnswerVector& u);

 private:
  using Coordinates = Eigen::Map<Vector>;
  /// Coordinates, from the first to before the last.
  struct Rows {
    Index first, last;
    bool contain(Index row) const { return first <= row && row < last; }
  };
  struct AllRows {
    static constexpr bool contain(Index) { return true; }
  };
  /// What a contact moves of one body.
  struct Part {
    Index contact, direction;
    Rows body;
  };
  static constexpr Index kParts = 6;  ///< of room_

  bool has_free_momentum();
  template <class Normals, class Directions, class Body>
  double parting(const Normals& N, const Directions& D, Index contact, Body body, Index& direction,
                 double& factor) const;
  template <class Normals, class Directions, class Body>
  void push(const Normals& N, const Directions& D, Index contact, Body body, Index direction, double factor,
            double missing);
  bool has_several_bodies() const;
  template <class Normals, class Directions>
  void find_parts(const Normals& N, const Directions& D);
  template <class Normals, class Directions>
  bool refutes_a_body(const Normals& N, const Directions& D);
  template <class Normals, class Directions>
  bool refutes(const Normals& N, const Directions& D);
  bool is_out_of_range() const;
  bool is_inertia_regular();
  bool touches(Index contact) const { return contact_->offset(contact) <= touching_; }

  const ContactProblem* contact_ = nullptr;
  const Vector* v_ = nullptr;
  bool is_possible_ = false;
  double touching_ = 0, fastest_ = 0;
  Matrix room_;                       ///< of what follows
  Coordinates momentum_{nullptr, 0};  ///< G v, zero where no contact moves the coordinate
  Coordinates mass_{nullptr, 0};      ///< diagonal of G
  Coordinates moves_{nullptr, 0};     ///< 1 where a contact moves the coordinate, else 0
  Coordinates y_{nullptr, 0}, magnitude_{nullptr, 0}, column_{nullptr, 0};
  Matrix factor_;              ///< scratch: Cholesky's, of a block
  std::vector<double> needs_;  ///< by contact: how fast it approaches at the first y
  std::vector<Index> rows_;    ///< of column_ that are not zero
  std::vector<Part> parts_;    ///< of the touching contacts
};

}  // namespace lcpbench
