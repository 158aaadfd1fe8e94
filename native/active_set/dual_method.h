#pragma once

#include "native/active_set/orthogonal_basis.h"
#include "native/active_set/steps.h"
#include "native/active_set/whitening.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// The projection of v onto {u : N'u + b >= 0} in the metric of the inertia, by the dual active-set method of Goldfarb
/// and Idnani (1983) in whitened coordinates: min 1/2 |y - y0|^2 subject to W'y + b >= 0.
///
/// The iterate is optimal for the contacts of the active set alone, and their impulses are not negative. A step takes
/// in the contact whose half-space is furthest away, and lets go of contacts whose impulse comes to zero on the way.
/// The objective increases with each full step, so that no active set recurs. A contact whose normal depends on the
/// active ones takes the place of one of them, or shows that nothing is feasible.
///
/// slack_, the normal velocities N'u + b, is carried along instead of y. Per step O(ngc (nc + active)).
class DualMethod {
  using L = Lanes<double>;

 public:
  explicit DualMethod(Whitening& whitening) : whitening_(whitening) {}

  /// Room for all problems that are not larger.
  void reserve(Count ngc, Count nc) {
    const Count most = ngc < nc ? ngc : nc;
    resize_all(L::padded(nc) + 1, slack_, weight_, merit_);
    resize_all(most + 2, active_, active_impulse_, share_, coefficients_);
    resize_all(L::padded(ngc) + 1, rest_, change_);
    basis_.reserve(L::padded(ngc), most);
  }

  /// From v, with no contact active. The arrays must outlive the solve.
  /// @param y0  C v, where G has a factor C
  /// @param given  N'v + b
  /// @param b  nullptr: zero
  void begin(const double* v, const double* y0, const double* given, const double* b) {
    v_ = v;
    y0_ = y0;
    given_ = given;
    b_ = b;
    basis_.clear(lanes(), most_active());
    copy(slack_.data(), given_, contact_lanes());
    copy(weight_.data(), whitening_.weights(), contact_lanes());
    squared_scale_ = whitening_.triangular() ? dot(y0_, y0_, lanes()) : 0.0;
    if (!whitening_.triangular() || b_ != nullptr) {
      const double merit = measure_merits();
      squared_scale_ = merit > squared_scale_ ? merit : squared_scale_;
    }
  }

  /// The scale of squared distances to half-spaces: |v|_G^2 if G has a factor C. Without C, or with an offset, at least
  /// the largest squared distance at v to a half-space that is violated.
  double squared_scale() const { return squared_scale_; }
  /// The largest squared distance to a half-space that counts as rounding.
  double threshold() const { return whitening_.noise() * whitening_.noise() * squared_scale_; }

  /// Takes in the contacts with a positive entry (nc), less those that would be pulled. @returns how many these are
  Count warm_start(const double* start) {
    Count dropped = 0;
    for (Count j = 0; j < whitening_.nc(); ++j) {
      if (start[j] > 0) append_independent(j);
    }
    for (;; ++dropped) {
      find_impulses();
      Count most_pulled = -1;
      double least = 0;
      for (Count k = 0; k < basis_.size(); ++k) {
        if (!(active_impulse_[k] < least)) continue;
        least = active_impulse_[k];
        most_pulled = k;
      }
      if (most_pulled < 0) break;
      drop(most_pulled);
    }
    add_to_slack(given_, change_.data());
    return dropped;
  }

  /// The method, with the step numbers of the paper's section 3. kSolved: then find_impulses() has the solution.
  /// kInfeasible: then write_farkas() has the proof.
  Ending solve(Steps& steps) {
    if (immovable_contact_is_violated()) return Ending::kInfeasible;
    const double noise = whitening_.noise();
    for (;;) {
      // Step 1. The most violated contact enters. Where there is none, this is the solution.
      entering_ = most_violated();
      if (entering_ < 0) return Ending::kSolved;
      weight_[entering_] = 0;
      double entering_impulse = 0;
      for (bool is_full_step = false; !is_full_step;) {
        if (const Ending limit = steps.next(); limit != Ending::kSolved) return limit;
        steps.add_work(basis_.size() * (4 * lanes() + basis_.size()) + (whitening_.rank() + 4) * contact_lanes());

        // Step 2a. The step directions: of y what the active normals leave of the entering one, rest_ (z of the paper);
        // of the impulses its coordinates in the active ones, share_ (r of the paper).
        const double squared_norm = whitening_.squared_norm(entering_);
        const double left =
            basis_.split(whitening_.normal(entering_), squared_norm, coefficients_.data(), rest_.data());
        for (Count k = 0; k < basis_.size(); ++k) share_[k] = coefficients_[k];
        basis_.solve(share_.data());
        const bool is_independent = basis_.size() < most_active() && left > noise * noise * squared_norm;

        // Step 2b. The step length: the partial step t1, at which the impulse of an active contact comes to zero, or
        // the full step t2, at which the entering contact is on its boundary.
        Count leaving = -1;
        double partial = kInfinity<double>;
        for (Count k = 0; k < basis_.size(); ++k) {
          if (share_[k] > 0 && (leaving < 0 || active_impulse_[k] < partial * share_[k])) {
            partial = active_impulse_[k] / share_[k];
            leaving = k;
          }
        }
        const double full = is_independent ? -slack_[entering_] / left : kInfinity<double>;

        // Step 2c (i). Neither exists: nothing is feasible, unless the violation is rounding. A positive definite
        // inertia leaves nothing infeasible without an offset. If the violation is no rounding, the test of the answer
        // finds it.
        if (!is_independent && leaving < 0) {
          if ((!whitening_.triangular() || b_ != nullptr) && proves_infeasible()) return Ending::kInfeasible;
          break;
        }

        // Step 2c (ii, iii). The step, in the impulses alone where the entering normal depends on the active ones.
        is_full_step = !(partial < full);
        const double length = is_full_step ? full : partial;
        if (!finite(length)) return Ending::kBreakdown;
        for (Count k = 0; k < basis_.size(); ++k) active_impulse_[k] -= length * share_[k];
        entering_impulse += length;
        if (is_independent) move(length);
        if (is_full_step) {
          active_[basis_.size()] = entering_;
          active_impulse_[basis_.size()] = entering_impulse;
          basis_.append(coefficients_.data(), rest_.data(), left);
        } else {
          drop(leaving);
        }
      }
    }
  }

  /// change() = y - y0 with y the projection on the active contacts' boundaries, and the impulses that do it.
  void find_impulses() {
    double* const c = coefficients_.data();
    if (whitening_.triangular() && b_ == nullptr) {
      for (Count k = 0; k < basis_.size(); ++k) c[k] = -dot(basis_.q(k), y0_, lanes());
    } else {
      for (Count k = 0; k < basis_.size(); ++k) c[k] = -given_[active_[k]];
      basis_.solve_transposed(c);
    }
    set_zero(change_.data(), lanes());
    combine_rows(change_.data(), change_.data(), basis_.q(0), lanes(), c, basis_.size(), lanes());
    for (Count k = 0; k < basis_.size(); ++k) active_impulse_[k] = c[k];
    basis_.solve(active_impulse_.data());
  }

  // The active set, after find_impulses().

  Count count() const { return basis_.size(); }
  Count contact(Count k) const { return active_[k]; }
  double impulse(Count k) const { return active_impulse_[k]; }
  /// Coordinate k of change() in an orthonormal basis of the active normals.
  double coordinate(Count k) const { return coefficients_[k]; }
  const double* change() const { return change_.data(); }

  /// u of Engine::solve(): 1 for the entering contact and, unless nothing moves that, -share_ for the active ones, none
  /// of whose shares is positive then. @pre Ending::kInfeasible
  void write_farkas(double* u) const {
    for (Count j = 0; j < whitening_.nc(); ++j) u[j] = 0;
    u[entering_] = 1;
    if (!(whitening_.squared_norm(entering_) > 0)) return;
    for (Count k = 0; k < basis_.size(); ++k) u[active_[k]] = share_[k] < 0 ? -share_[k] : 0;
  }

 private:
  Count lanes() const { return whitening_.velocity_lanes(); }
  Count contact_lanes() const { return whitening_.contact_lanes(); }
  Count most_active() const { return whitening_.ngc() < whitening_.nc() ? whitening_.ngc() : whitening_.nc(); }

  /// Contacts that no impulse moves: violated ones stay so.
  bool immovable_contact_is_violated() {
    if (whitening_.triangular() && b_ == nullptr) return false;  // their normals are zero, and so is their velocity
    for (Count j = 0; j < whitening_.nc(); ++j) {
      if (whitening_.squared_norm(j) > 0) continue;
      if (given_[j] >= -whitening_.noise() * velocity_terms(j)) continue;
      entering_ = j;
      return true;
    }
    return false;
  }

  /// The contact that is furthest from its half-space; -1: none by more than rounding. NaN counts as none.
  Count most_violated() {
    const double largest = measure_merits();
    if (!(largest > threshold())) return -1;
    Count contact = 0;  // the lowest of equals; without a branch, which would be mispredicted
    for (Count j = contact_lanes() - L::kWidth; j >= 0; j -= L::kWidth) {
      const std::uint64_t equals = lanes_where<double>(L::load(merit_.data() + j) == L::broadcast(largest));
      contact = equals != 0 ? j + __builtin_ctzll(equals) : contact;
    }
    return contact;
  }

  /// merit_ = squared distance to the half-space where that is violated, else 0; 0 for active contacts. @returns
  /// largest
  double measure_merits() {
    const auto zero = L::broadcast(0);
    auto largest = zero;
    for (Count j = 0; j < contact_lanes(); j += L::kWidth) {
      const auto violation = L::min(L::load(slack_.data() + j), zero);
      const auto merit = violation * violation * L::load(weight_.data() + j);
      L::store(merit_.data() + j, merit);
      largest = L::max(largest, merit);
    }
    return L::max(largest);
  }

  /// Whether the entering contact and the active ones that its normal depends on, u >= 0 with N u in null(G), have
  /// (N'v + b)'u < 0 by more than rounding. Where it is rounding, most often at v+ = 0, where all contacts rest, the
  /// violation is rounding too.
  bool proves_infeasible() const {
    double value = given_[entering_];
    double terms = velocity_terms(entering_);
    for (Count k = 0; k < basis_.size(); ++k) {
      value -= share_[k] * given_[active_[k]];
      terms -= share_[k] * velocity_terms(active_[k]);
    }
    return value < -whitening_.noise() * terms;
  }

  /// Sum of the magnitudes of what N_j'v + b_j adds up.
  double velocity_terms(Count j) const {
    double terms = b_ != nullptr ? magnitude(b_[j]) : 0.0;
    for (Count i = 0; i < whitening_.ngc(); ++i) terms += magnitude(whitening_.normals(i)[j] * v_[i]);
    return terms;
  }

  /// y += length * rest_, of which slack_ alone is kept.
  void move(double length) {
    const auto factor = L::broadcast(length);
    for (Count i = 0; i < lanes(); i += L::kWidth) {
      L::store(change_.data() + i, factor * L::load(rest_.data() + i));
    }
    add_to_slack(slack_.data(), change_.data());
  }

  /// slack_ = start + W'change
  void add_to_slack(const double* start, const double* change) {
    combine_rows(slack_.data(), start, whitening_.row(0), whitening_.row_stride(), change, whitening_.rank(),
                 contact_lanes());
  }

  void drop(Count k) {
    weight_[active_[k]] = whitening_.weights()[active_[k]];
    basis_.remove(k);
    for (Count i = k; i < basis_.size(); ++i) {
      active_[i] = active_[i + 1];
      active_impulse_[i] = active_impulse_[i + 1];
    }
  }

  /// Appends `contact` to the active set unless its normal depends on those in it.
  void append_independent(Count contact) {
    if (basis_.size() >= most_active()) return;
    const double squared_norm = whitening_.squared_norm(contact);
    const double noise = whitening_.noise();
    const double left = basis_.split(whitening_.normal(contact), squared_norm, coefficients_.data(), rest_.data());
    if (!(left > noise * noise * squared_norm)) return;
    active_[basis_.size()] = contact;
    basis_.append(coefficients_.data(), rest_.data(), left);
    weight_[contact] = 0;
  }

  Whitening& whitening_;
  const double* v_ = nullptr;
  const double* y0_ = nullptr;
  const double* given_ = nullptr;
  const double* b_ = nullptr;  // nullptr: zero
  double squared_scale_ = 0;

  Buffer<double> slack_;   // by contact
  Buffer<double> weight_;  // 1 / |W_j|^2, 0 for active contacts
  Buffer<double> merit_;   // see measure_merits()

  OrthogonalBasis basis_;  // of the active normals
  Buffer<Count> active_;
  Buffer<double> active_impulse_;
  Count entering_ = 0;
  Buffer<double> coefficients_;
  Buffer<double> share_;   // of the entering normal in the active ones: R^-1 Q' of it
  Buffer<double> rest_;
  Buffer<double> change_;  // y - y0; during the iteration that of one step
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
