#pragma once

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
  /// Relative to the fastest approach: what a contact may be open, or its velocity off, and still touch.
  static constexpr double kTouching = 1e-9;
  /// Imbalance of impulses near which those of rest may be found.
  static constexpr double kNear = 1e-5;

  static bool takes(const ContactProblem& contact);

  /// O(nonzeros of N and G). @pre takes() @param contact must outlive the next load @param v velocity before the impact
  void load(const ContactProblem& contact, const Vector& v);

  /// Whether the offsets and some v allow rest at all.
  bool is_possible() const { return is_possible_; }

  /// By how much the impulses of z miss the balance of the momentum, over the magnitudes that it sums up, of the worst
  /// body; each coordinate counts by the root of its energy. Infinity if an impulse is outside of its cone, or presses
  /// an open contact. O(nonzeros)
  double imbalance(const Vector& z);
  /// Whether the impulses of z hold the island: the balance is met to rounding.
  bool holds(const Vector& z);
  /// Whether they may, by the balance of one coordinate, to kNear: false for most answers that move. O(nonzeros)
  static bool may_hold(const ContactProblem& contact, const Vector& v, const Vector& z);

  /// Whether no impulses hold it. The proof is a y with (N_i + mu_i d)'y >= 0 for every touching contact and direction,
  /// and y'G v > 0: impulses in the cones never give y less momentum, but all of it would have to go. Looks for it near
  /// a velocity, by a few sweeps of projections; a proof may be missed. O(nonzeros) for each sweep
  /// @param near velocity of an answer that slips
  bool is_refuted(const Vector& near);

  /// v+ of the island at rest: coordinates that no contact moves keep their velocity.
  void write_velocity(AnswerVector& u) const;

 private:
  template <class Normals, class Directions>
  bool widen(const Normals& N, const Directions& D, double target);
  template <class Normals, class Directions>
  void push(const Normals& N, const Directions& D, Index contact, Index direction, double factor, double missing);
  bool touches(Index contact) const { return contact_->offset(contact) <= touching_; }

  const ContactProblem* contact_ = nullptr;
  Vector v_;
  bool is_possible_ = false;
  double touching_ = 0;  ///< offset up to which a contact touches
  Vector momentum_;      ///< G v, zero where no contact moves the coordinate
  Vector magnitude_;     ///< of the products that momentum_ sums up
  Vector mass_;          ///< diagonal of G
  std::vector<char> moves_;  ///< by coordinate: a contact moves it
  Vector y_, sum_, magnitudes_, column_;
  std::vector<Index> rows_;  ///< of column_ that are not zero
};

}  // namespace lcpbench
