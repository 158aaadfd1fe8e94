#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/response.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The post-impact velocity of a basis, without the detour by impulses, which are as large as G is ill-conditioned.
///
/// In whitened coordinates, u~ = L'u with G = L L', the velocity is the projection of v~ along the columns A~ = L^-1 A
/// of the basic impulses onto the velocities with B~'u~ + o = 0, o what the rows have of the offset: u~ = v~ - Q
/// (B~'Q)^-1 (B~'v~ + o) with A~ = Q R. Without friction A~ = B~ and the projection is orthogonal. Q is made by
/// Gram-Schmidt with column pivoting and a second pass.
template <class Scalar>
class Polish {
 public:
  /// Takes all memory that load() needs; touches none of it.
  void reserve(Count ngc) {
    padded_ = P::padded(ngc);
    most_ = ngc;
    Buffer<Scalar>* const vectors[] = {&white_, &step_};
    for (Buffer<Scalar>* buffer : vectors) buffer->resize(padded_);
    Buffer<Scalar>* const matrices[] = {&A_, &B_};
    for (Buffer<Scalar>* buffer : matrices) buffer->resize(most_ * padded_);
    right_.resize(P::padded(most_));
    system_.resize(most_ * (most_ + 1));
    R_.resize(most_ * most_);
    order_.resize(most_);
    moved_.resize(most_);
    offset_.resize(most_);
  }

  void load(Count ngc) {
    reserve(ngc);
    fill_with_zeros(most_ * padded_, A_, B_);
    fill_with_zeros(padded_, white_, step_);
    fill_with_zeros(P::padded(most_), right_);
  }

  void clear() { columns_ = rows_ = 0; }
  /// The whitened vector to be written; nullptr when there are more than ngc.
  Scalar* next_column() { return columns_ < most_ ? A_.data() + padded_ * columns_++ : nullptr; }
  Scalar* next_row(Scalar offset) {
    if (rows_ >= most_) return nullptr;
    offset_[rows_] = offset;
    return B_.data() + padded_ * rows_++;
  }

  /// u, ngc entries padded. False when the columns are dependent or the projection breaks down.
  bool run(const Contacts<Scalar>& contacts, const Response<Scalar>& response, Scalar* u) {
    if (columns_ != rows_ || !orthonormalise(true)) return false;
    response.whiten_velocity(contacts.velocity(), white_.data());
    for (Count k = 0; k < columns_; ++k) moved_[k] = 0;
    for (Count pass = 0; pass < kPasses; ++pass) {
      if (!project()) return false;
    }
    response.unwhiten(white_.data(), u);
    for (Count i = contacts.moving(); i < contacts.ngc(); ++i) u[i] = contacts.velocity()[i];
    solve_for_impulses();
    return true;
  }

  /// Shares y of the columns, each what `round(column, share)` makes of it, for which the sum of y_k a_k hardly differs
  /// from that of all a_k. Each is rounded before the next is solved for, which so makes up for the rounding; the
  /// shortest is the last, since nothing makes up for that. False when the columns are dependent. [Babai 1986, the
  /// nearest-plane method]
  template <class Round>
  bool round_shares(Round&& round) {
    if (!orthonormalise(false)) return false;
    for (Count k = columns_ - 1; k >= 0; --k) {
      Scalar left = R(k, k);
      for (Count j = k + 1; j < columns_; ++j) left += R(k, j) * (Scalar(1) - right_[j]);
      right_[k] = round(order_[k], left / R(k, k));
    }
    return true;
  }

  /// Of the columns in the order in which they were written. @pre run() returned true
  Scalar impulse(Count column) const {
    Count k = 0;
    while (order_[k] != column) ++k;
    return right_[k];
  }

 private:
  using P = Packed<Scalar>;
  static constexpr Count kPasses = 2;
  static constexpr double kDependent = 64;  // roundings of a column's length, below which nothing of it is left

  Scalar* column(Count j) { return A_.data() + j * padded_; }

  Scalar& R(Count k, Count j) { return R_[k * most_ + j]; }

  bool orthonormalise(bool longest_first) {
    for (Count k = 0; k < columns_; ++k) order_[k] = k;
    for (Count k = 0; k < columns_; ++k) {
      bring_next_to(k, longest_first);
      const Scalar before = square_root(dot(column(k), column(k), padded_));
      for (Count j = 0; j < k; ++j) {
        const Scalar rest = dot(column(j), column(k), padded_);
        R(j, k) += rest;
        add_multiple(column(k), -rest, column(j), padded_);
      }
      const Scalar length = square_root(dot(column(k), column(k), padded_));
      if (!(length > static_cast<Scalar>(kDependent * kUnitRoundoff<Scalar>) * before)) return false;
      R(k, k) = length;
      scale(column(k), Scalar(1) / length, padded_);
      for (Count j = k + 1; j < columns_; ++j) {
        R(k, j) = dot(column(k), column(j), padded_);
        add_multiple(column(j), -R(k, j), column(k), padded_);
      }
    }
    return true;
  }

  /// The longest, or else the shortest, of the columns from k on.
  void bring_next_to(Count k, bool longest) {
    Count next = k;
    Scalar best = dot(column(k), column(k), padded_);
    for (Count j = k + 1; j < columns_; ++j) {
      const Scalar square = dot(column(j), column(j), padded_);
      if (longest ? square > best : square < best) {
        best = square;
        next = j;
      }
    }
    if (next == k) return;
    for (Count i = 0; i < padded_; ++i) exchange(column(k)[i], column(next)[i]);
    for (Count i = 0; i < k; ++i) exchange(R(i, k), R(i, next));
    exchange(order_[k], order_[next]);
  }

  template <class T>
  static void exchange(T& a, T& b) {
    const T keep = a;
    a = b;
    b = keep;
  }

  void solve_for_impulses() {
    for (Count k = columns_ - 1; k >= 0; --k) {
      Scalar sum = -moved_[k];
      for (Count j = k + 1; j < columns_; ++j) sum -= R(k, j) * right_[j];
      right_[k] = sum / R(k, k);
    }
  }

  /// white_ -= Q (B'Q)^-1 (B' white_ + offset_)
  bool project() {
    const Count width = columns_ + 1;
    for (Count r = 0; r < rows_; ++r) {
      const Scalar* const b = B_.data() + r * padded_;
      for (Count j = 0; j < columns_; ++j) system_[r * width + j] = dot(b, column(j), padded_);
      system_[r * width + columns_] = dot(b, white_.data(), padded_);
      if (offset_[r] != 0) system_[r * width + columns_] += offset_[r];
    }
    if (!solve_system(width)) return false;
    for (Count k = 0; k < columns_; ++k) moved_[k] += right_[k];
    combine(A_.data(), padded_, columns_, right_.data(), step_.data(), padded_);
    add_multiple(white_.data(), Scalar(-1), step_.data(), padded_);
    return true;
  }

  /// Gaussian elimination with partial pivoting; the last column is the right-hand side.
  bool solve_system(Count width) {
    Scalar* const S = system_.data();
    for (Count k = 0; k < columns_; ++k) {
      Count pivot = k;
      for (Count r = k + 1; r < columns_; ++r) {
        if (magnitude(S[r * width + k]) > magnitude(S[pivot * width + k])) pivot = r;
      }
      if (!(magnitude(S[pivot * width + k]) > 0)) return false;
      for (Count j = k; j < width; ++j) exchange(S[k * width + j], S[pivot * width + j]);
      for (Count r = k + 1; r < columns_; ++r) {
        const Scalar factor = S[r * width + k] / S[k * width + k];
        for (Count j = k; j < width; ++j) S[r * width + j] -= factor * S[k * width + j];
      }
    }
    for (Count k = columns_ - 1; k >= 0; --k) {
      Scalar sum = S[k * width + columns_];
      for (Count j = k + 1; j < columns_; ++j) sum -= S[k * width + j] * right_[j];
      right_[k] = sum / S[k * width + k];
    }
    return true;
  }

  Count padded_ = 0, most_ = 0, columns_ = 0, rows_ = 0;
  Buffer<Scalar> A_, B_, white_, step_, right_, system_;
  Buffer<Scalar> R_, moved_, offset_;
  Buffer<Count> order_;  ///< where the columns came from
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
