#pragma once

#include "native/active_set/whitening.h"

namespace lcpbench::active_set::LCPBENCH_LEVEL {

/// Contacts with friction that all yield, along their normals and their tangents. Each has three rows: its normal and
/// two tangents. With x the whitened change of velocity and s = g + W'x the velocities of the rows, the impulses are
///
///     f_N = max(0, -s_N / r_n),  f_T = the point of |f_1| + |f_2| <= mu f_N that is nearest to -s_T / r_t,
///
/// what a pyramid of four edges asks for. x = W f(s) is solved by Newton's method, whose step is halved until |x - W f|
/// falls. [Qi, Sun 1993, A nonsmooth version of Newton's method] It need not converge. A step takes O(rank^2 (rank +
/// rows that press)).
class YieldingFriction {
  using L = Lanes<double>;

 public:
  explicit YieldingFriction(Whitening& whitening) : whitening_(whitening) {}

  void reserve(Count ngc, Count rows) {
    const Count lanes = L::padded(ngc);
    matrix_.resize(ngc * lanes + 1);
    slopes_.resize(rows * lanes + 1);
    resize_all(lanes + 1, x_, next_x_, missing_, next_missing_, step_);
    resize_all(L::padded(rows) + 1, speed_, impulse_, factors_);
    rows_.resize(rows + 1);
  }

  /// From x = 0. @param given, mu  g, and one entry for each contact; must outlive the steps
  void begin(const double* given, const double* mu) {
    given_ = given;
    mu_ = mu;
    set_zero(x_.data(), lanes());
    left_ = respond(x_.data(), missing_.data());
  }

  /// Whether rounding leaves the impulses -s / r exact to this part of themselves: s sums terms of size M_ii f, so that
  /// f has an error of M_ii / r unit round-offs.
  bool resolves(double part) const {
    for (Count row = 0; row < whitening_.nc(); ++row) {
      const double lost = kUnitRoundoff<double> * whitening_.squared_norm(row);
      if (!(lost <= part * whitening_.compliance(row))) return false;
    }
    return true;
  }
  /// |x - W f|^2. It is the only measure of the impulses. @pre begin()
  double left() const { return left_; }
  double impulse(Count row) const { return impulse_[row]; }

  /// @returns whether less is left; if not, only begin() may follow
  bool step() {
    form();
    if (!solve()) return false;
    double length = 1;
    for (int halvings = 0; halvings < kMostHalvings; ++halvings, length /= 2) {
      copy(next_x_.data(), x_.data(), lanes());
      add_multiple(next_x_.data(), length, step_.data(), lanes());
      const double left = respond(next_x_.data(), next_missing_.data());
      const double falls = 1 - kLeastFall * length;
      if (!(left < falls * falls * left_)) continue;
      left_ = left;
      copy(x_.data(), next_x_.data(), lanes());
      copy(missing_.data(), next_missing_.data(), lanes());
      return true;
    }
    return false;
  }

 private:
  static constexpr int kMostHalvings = 6;
  static constexpr double kLeastFall = 0.1;  ///< of |x - W f|, by a whole step

  Count lanes() const { return whitening_.velocity_lanes(); }

  struct Friction {
    double first, second;
    bool slides;
  };
  /// @param first, second  without a limit @param most  mu f_N
  static Friction limited(double first, double second, double most) {
    const double a = magnitude(first), b = magnitude(second);
    if (a + b <= most) return {first, second, false};
    const double share = (a - b + most) / 2;
    const double of_first = share > 0 ? (share < most ? share : most) : 0.0;
    return {first < 0 ? -of_first : of_first, second < 0 ? of_first - most : most - of_first, true};
  }

  /// impulse_ := f, missing := W f - x. @returns its square
  double respond(const double* x, double* missing) {
    combine_rows(speed_.data(), given_, whitening_.row(0), whitening_.row_stride(), x, whitening_.rank(),
                 whitening_.contact_lanes());
    set_zero(missing, lanes());
    add_multiple(missing, -1.0, x, lanes());
    for (Count row = 0; row < whitening_.nc(); row += 3) {
      const double normal = -speed_[row] / whitening_.compliance(row);
      const double pressed = normal > 0 ? normal : 0.0;
      const Friction friction =
          limited(-speed_[row + 1] / whitening_.compliance(row + 1), -speed_[row + 2] / whitening_.compliance(row + 2),
                  mu_[row / 3] * pressed);
      const double impulses[] = {pressed, pressed > 0 ? friction.first : 0.0,
                                 pressed > 0 ? friction.second : 0.0};
      for (Count k = 0; k < 3; ++k) {
        impulse_[row + k] = impulses[k];
        if (impulses[k] != 0) add_multiple(missing, impulses[k], whitening_.normal(row + k), lanes());
      }
    }
    return dot(missing, missing, lanes());
  }

  /// matrix_ := I + W Phi W', Phi the slopes of -f at the velocities of x, which respond() left in speed_.
  void form() {
    count_ = 0;
    for (Count row = 0; row < whitening_.nc(); row += 3) {
      if (speed_[row] < 0) add_slopes(row);
    }
    for (Count i = 0; i < whitening_.rank(); ++i) {
      for (Count k = 0; k < count_; ++k) factors_[k] = whitening_.row(i)[rows_[k]];
      double* const to = matrix_.data() + i * lanes();
      set_zero(to, lanes());
      to[i] = 1;
      combine_rows(to, to, slopes_.data(), lanes(), factors_.data(), count_, lanes());
    }
  }

  double* next_slope(Count row) {
    rows_[count_] = row;
    double* const to = slopes_.data() + count_++ * lanes();
    set_zero(to, lanes());
    return to;
  }

  /// The rows of Phi W' of a contact that presses.
  void add_slopes(Count row) {
    const double* const normals[] = {whitening_.normal(row), whitening_.normal(row + 1), whitening_.normal(row + 2)};
    const double stiff = 1 / whitening_.compliance(row);
    add_multiple(next_slope(row), stiff, normals[0], lanes());
    const double mu = mu_[row / 3];
    const double most = mu * stiff * -speed_[row];
    if (!(most > 0)) return;
    const double of_tangents[] = {1 / whitening_.compliance(row + 1), 1 / whitening_.compliance(row + 2)};
    const double free[] = {-speed_[row + 1] * of_tangents[0], -speed_[row + 2] * of_tangents[1]};
    const Friction friction = limited(free[0], free[1], most);
    const double held[] = {friction.first, friction.second};
    const bool is_corner = friction.slides && (held[0] == 0 || held[1] == 0);
    for (Count k = 0; k < 2; ++k) {
      const double sign = free[k] < 0 ? -1.0 : 1.0;
      if (!friction.slides) {
        add_multiple(next_slope(row + 1 + k), of_tangents[k], normals[1 + k], lanes());
      } else if (is_corner && held[k] != 0) {
        add_multiple(next_slope(row + 1 + k), sign * mu * stiff, normals[0], lanes());
      } else if (!is_corner) {
        const double other = free[1 - k] < 0 ? -1.0 : 1.0;
        double* const to = next_slope(row + 1 + k);
        add_multiple(to, of_tangents[k] / 2, normals[1 + k], lanes());
        add_multiple(to, -sign * other * of_tangents[1 - k] / 2, normals[2 - k], lanes());
        add_multiple(to, sign * mu * stiff / 2, normals[0], lanes());
      }
    }
  }

  /// step_ := matrix_^-1 missing_, by elimination with the largest pivot of each column.
  bool solve() {
    const Count rank = whitening_.rank();
    copy(step_.data(), missing_.data(), lanes());
    for (Count k = 0; k < rank; ++k) {
      Count pivot = k;
      for (Count i = k + 1; i < rank; ++i) {
        if (magnitude(entry(i, k)) > magnitude(entry(pivot, k))) pivot = i;
      }
      if (!(magnitude(entry(pivot, k)) > 0) || !finite(entry(pivot, k))) return false;
      const Count first = k / L::kWidth * L::kWidth;
      for (Count j = first; j < lanes(); ++j) swap(entry(k, j), entry(pivot, j));
      swap(step_[k], step_[pivot]);
      const double inverse = 1 / entry(k, k);
      for (Count i = k + 1; i < rank; ++i) {
        const double factor = entry(i, k) * inverse;
        if (factor == 0) continue;
        add_multiple(&entry(i, first), -factor, &entry(k, first), lanes() - first);
        step_[i] -= factor * step_[k];
      }
    }
    for (Count k = rank - 1; k >= 0; --k) {
      for (Count j = k + 1; j < rank; ++j) step_[k] -= entry(k, j) * step_[j];
      step_[k] /= entry(k, k);
    }
    for (Count i = rank; i < lanes(); ++i) step_[i] = 0;
    return true;
  }

  double& entry(Count i, Count j) { return matrix_[i * lanes() + j]; }

  Whitening& whitening_;
  const double* given_ = nullptr;
  const double* mu_ = nullptr;
  double left_ = 0;
  Buffer<double> matrix_;
  Count count_ = 0;
  Buffer<Count> rows_;       ///< of slopes_
  Buffer<double> slopes_;    ///< Phi W' but for zeros
  Buffer<double> x_, next_x_, missing_, next_missing_, step_;
  Buffer<double> speed_, impulse_, factors_;
};

}  // namespace lcpbench::active_set::LCPBENCH_LEVEL
