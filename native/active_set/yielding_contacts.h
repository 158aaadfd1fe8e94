#pragma once

#include "native/active_set/symmetric_system.h"
#include "native/active_set/whitening.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Contacts that all yield, r_j > 0. With x the whitened change of velocity, g = N'v + b, and W the whitened normals,
///
///     minimize 1/2 |x|^2 + sum min(0, g_j + W_j'x)^2 / (2 r_j),
///
/// by Newton's method with a line search. The function is strictly convex, and quadratic as long as the same contacts
/// press, so that the method ends [Sun 1997, On piecewise quadratic Newton and trust region problems]. The impulses are
/// f_j = -min(0, g_j + W_j'x) / r_j.
///
/// A step solves for the p contacts that press, (R + W'W) f = -g, or if these are more than the coordinates, for those:
/// (I + W R^-1 W') x = -W R^-1 g. O(ngc (nc + p min(p, ngc))), however many contacts begin or cease to press.
class YieldingContacts {
  using L = Lanes<double>;

 public:
  enum class Step { kTaken, kLast, kFailed };

  explicit YieldingContacts(Whitening& whitening) : whitening_(whitening) {}

  /// Room for all problems that are not larger.
  void reserve(Count ngc, Count nc) {
    const Count order = ngc < nc ? ngc : nc;
    const Count most = L::padded(ngc < nc ? nc : ngc) + 1;
    const Count normals_by_columns = nc * L::padded(ngc), normals_by_rows = ngc * L::padded(order);
    vectors_.resize((normals_by_columns > normals_by_rows ? normals_by_columns : normals_by_rows) + 1);
    system_.reserve(order, most);
    resize_all(most, x_, next_x_, slack_, next_slack_, compliance_, impulse_, missing_, solution_);
    resize_all(nc + 1, pressing_, presses_);
  }

  /// @param given  g; must outlive the steps
  /// @param start  nc: at first contacts with a positive entry press; nullptr: those that approach
  void begin(const double* given, const double* start) {
    given_ = given;
    set_zero(x_.data(), whitening_.velocity_lanes());
    copy(slack_.data(), given, whitening_.contact_lanes());
    is_guess_ = start != nullptr;
    find_pressing([&](Count j) { return is_guess_ ? start[j] > 0 : given[j] < 0; });
  }

  /// Multiplications of the next step, about, without its line search and corrections.
  Count work() const {
    const Count rank = whitening_.rank(), other = by_contact() ? rank : count_;
    const Count order = by_contact() ? count_ : rank;
    return order * order * (2 * order + 3 * other) / 6 + 2 * rank * (whitening_.contact_lanes() + count_);
  }

  /// @param threshold  the largest (velocity / |W_j|)^2 of a contact that counts as a rounding of 0
  Step step(double threshold) {
    if (!solve()) return Step::kFailed;
    move(next_x_.data());
    threshold += rounding();
    if (!finite(threshold)) return Step::kFailed;  // any contact would be within it
    if (is_settled(threshold)) return is_right(threshold) ? Step::kLast : Step::kFailed;
    const double length = is_guess_ ? 1.0 : length_of_step();  // from a guess it may lead uphill
    if (!finite(length)) return Step::kFailed;
    is_guess_ = false;
    go(x_.data(), next_x_.data(), length, whitening_.velocity_lanes());
    go(slack_.data(), next_slack_.data(), length, whitening_.contact_lanes());
    find_pressing([this](Count j) { return slack_[j] < 0; });
    return Step::kTaken;
  }

  // After the last step.

  /// Contacts that press; by rounding an impulse may be below zero.
  Count count() const { return count_; }
  Count contact(Count k) const { return pressing_[k]; }
  double impulse(Count k) const { return impulse_[k]; }
  /// x
  const double* change() const { return next_x_.data(); }

 private:
  static constexpr int kMostCorrections = 3;
  static constexpr int kMostLengths = 50;
  static constexpr double kFlat = 0.1;  ///< a length will do where no more of the slope at the start is left

  bool by_contact() const { return count_ <= whitening_.rank(); }

  template <class Presses>
  void find_pressing(const Presses& presses) {
    count_ = 0;
    for (Count j = 0; j < whitening_.nc(); ++j) {
      presses_[j] = presses(j);
      if (presses_[j]) pressing_[count_++] = j;
    }
  }

  /// next_slack_ := g + W'x
  void move(const double* x) {
    combine_rows(next_slack_.data(), given_, whitening_.row(0), whitening_.row_stride(), x, whitening_.rank(),
                 whitening_.contact_lanes());
  }

  static void go(double* from, const double* to, double length, Count size) {
    const auto factor = L::broadcast(length);
    for (Count i = 0; i < size; i += L::kWidth) {
      const auto start = L::load(from + i);
      L::store(from + i, start + factor * (L::load(to + i) - start));
    }
  }

  /// impulse_ of the pressing contacts, and next_x_ = W f.
  bool solve() {
    if (!factor()) return false;
    for (Count k = 0; k < count_; ++k) {
      impulse_[k] = 0;
      missing_[k] = -given_[pressing_[k]];
    }
    correct();
    return true;
  }

  bool factor() {
    const Count rank = whitening_.rank(), lanes = whitening_.velocity_lanes();
    for (Count k = 0; k < count_; ++k) compliance_[k] = whitening_.compliance(pressing_[k]);
    double* const diagonal = solution_.data();
    if (by_contact()) {
      const Count stride = L::padded(count_);
      for (Count i = 0; i < rank; ++i) {
        double* const to = vectors_.data() + i * stride;
        const double* const from = whitening_.row(i);
        for (Count k = 0; k < count_; ++k) to[k] = from[pressing_[k]];
        for (Count k = count_; k < stride; ++k) to[k] = 0;
      }
      return system_.factor(compliance_.data(), count_, vectors_.data(), stride, rank);
    }
    for (Count k = 0; k < count_; ++k) {
      double* const to = vectors_.data() + k * lanes;
      copy(to, whitening_.normal(pressing_[k]), lanes);
      scale(to, 1 / square_root(compliance_[k]), lanes);
    }
    for (Count i = 0; i < rank; ++i) diagonal[i] = 1;
    return system_.factor(diagonal, rank, vectors_.data(), lanes, count_);
  }

  /// Adds to the impulses those that remove missing_, the error of the velocity at the contacts, and computes next_x_.
  void correct() {
    const Count lanes = whitening_.velocity_lanes();
    if (by_contact()) {
      for (Count k = count_; k < L::padded(count_); ++k) missing_[k] = 0;
      system_.solve(missing_.data());
      for (Count k = 0; k < count_; ++k) impulse_[k] += missing_[k];
    } else {
      set_zero(solution_.data(), lanes);
      for (Count k = 0; k < count_; ++k) {
        add_multiple(solution_.data(), missing_[k] / compliance_[k], whitening_.normal(pressing_[k]), lanes);
      }
      system_.solve(solution_.data());
      for (Count k = 0; k < count_; ++k) {
        const double moved = dot(whitening_.normal(pressing_[k]), solution_.data(), lanes);
        impulse_[k] += (missing_[k] - moved) / compliance_[k];
      }
    }
    set_zero(next_x_.data(), lanes);
    for (Count k = 0; k < count_; ++k) {
      add_multiple(next_x_.data(), impulse_[k], whitening_.normal(pressing_[k]), lanes);
    }
  }

  /// What the rounding of impulses adds to a threshold of step(): they may be large and cancel each other.
  double rounding() const {
    double terms = 0;
    for (Count k = 0; k < count_; ++k) {
      terms += magnitude(impulse_[k]) * square_root(whitening_.squared_norm(pressing_[k]));
    }
    const double noise = whitening_.noise() * terms;
    return noise * noise;
  }

  /// Whether the same contacts press, but for rounding.
  bool is_settled(double threshold) const {
    for (Count j = 0; j < whitening_.nc(); ++j) {
      if ((next_slack_[j] < 0) != presses_[j] && is_off(j, next_slack_[j], threshold)) return false;
    }
    return true;
  }
  bool is_off(Count contact, double speed, double threshold) const {
    return !(speed * speed * whitening_.weights()[contact] <= threshold);
  }

  /// Whether all contacts are where they should be but for rounding, once the impulses have been corrected.
  bool is_right(double threshold) {
    for (int corrections = 0;; ++corrections) {
      bool is_exact = true;
      for (Count k = 0; k < count_; ++k) {
        const Count j = pressing_[k];
        missing_[k] = -(next_slack_[j] + compliance_[k] * impulse_[k]);
        is_exact = is_exact && !is_off(j, missing_[k], threshold);
      }
      if (is_exact) break;
      if (corrections == kMostCorrections) return false;
      correct();
      move(next_x_.data());
    }
    for (Count k = 0; k < count_; ++k) {
      const Count j = pressing_[k];
      if (impulse_[k] < 0 && is_off(j, impulse_[k] * whitening_.squared_norm(j), threshold)) return false;
    }
    for (Count j = 0; j < whitening_.nc(); ++j) {
      if (!presses_[j] && next_slack_[j] < 0 && is_off(j, next_slack_[j], threshold)) return false;
    }
    return true;
  }

  /// How far to go towards next_x_, as a part of the way: about where the function is least. @returns infinity if it
  /// does not fall
  double length_of_step() {
    double squared = 0, along = 0;
    for (Count i = 0; i < whitening_.rank(); ++i) {
      const double d = next_x_[i] - x_[i];
      squared += d * d;
      along += d * x_[i];
    }
    const double at_start = slope(0, along, squared).value;
    if (!(at_start < 0)) return kInfinity<double>;
    double low = 0, high = kInfinity<double>, length = 1;
    for (int k = 0; k < kMostLengths; ++k) {
      const Slope now = slope(length, along, squared);
      if (!(magnitude(now.value) > -kFlat * at_start)) break;
      (now.value < 0 ? low : high) = length;
      length -= now.value / now.change;
      if (!(length > low && length < high)) length = finite(high) ? (low + high) / 2 : 2 * low;
    }
    return length;
  }

  struct Slope {
    double value, change;
  };
  Slope slope(double length, double along, double squared) const {
    Slope sum{along + length * squared, squared};
    for (Count j = 0; j < whitening_.nc(); ++j) {
      const double change = next_slack_[j] - slack_[j];
      const double speed = slack_[j] + length * change;
      if (!(speed < 0)) continue;
      const double pressure = change / whitening_.compliance(j);
      sum.value += speed * pressure;
      sum.change += change * pressure;
    }
    return sum;
  }

  Whitening& whitening_;
  SymmetricSystem system_;
  const double* given_ = nullptr;
  bool is_guess_ = false;  ///< which contacts press

  Count count_ = 0;
  Buffer<Count> pressing_;
  Buffer<bool> presses_;       ///< by contact
  Buffer<double> compliance_;  ///< of the pressing ones, as all from here to missing_
  Buffer<double> impulse_;
  Buffer<double> missing_;  ///< of the velocity that they should have
  Buffer<double> vectors_;  ///< their normals by rows or columns, see factor()
  Buffer<double> x_, next_x_;
  Buffer<double> slack_, next_slack_;  ///< g + W'x
  Buffer<double> solution_;
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
