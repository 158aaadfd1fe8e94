#pragma once

#include "native/kernels/pack.h"
#include "native/lemke/column_sum.h"
#include "native/lemke/lemke_engine.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// M of one problem. The columns of its dense block are formed when they are first asked for.
class MatrixColumns {
 public:
  void load(const Input& input) {
    n_ = input.n;
    dense_ = input.dense;
    cones_ = input.cones;
    stride_ = Packed<double>::padded(dense_);
    formed_ = 0;
    place_.fill(dense_, -1);
    columns_.resize(dense_ * stride_);
    copy_jacobian(input);
    copy_cones(input);
    matrix_.resize(input.M != nullptr ? dense_ * dense_ : 0);
    factored_ = input.M == nullptr;
    for (Count i = 0; !factored_ && i < dense_ * dense_; ++i) matrix_[i] = input.M[i];
  }

  Count n() const { return n_; }
  Count dense() const { return dense_; }
  Count cones() const { return cones_; }
  Count stride() const { return stride_; }  ///< entries of a column with their padding of zeros

  /// Column j < dense() of the dense block.
  const double* column(Count j) {
    if (place_[j] < 0) form(j);
    return columns_.data() + place_[j] * stride_;
  }

  /// M(row, col) for any row and column.
  double entry(Count row, Count col) {
    if (col >= dense_) return friction_cone_[row] == col - dense_ ? 1 : 0;
    if (row >= dense_) return cone_[col] == row - dense_ ? cone_coefficient_[col] : 0;
    return column(col)[row];
  }

  /// The friction rows of a cone, [first, last).
  Count friction_first(Count cone) const { return friction_begin_[cone]; }
  Count friction_last(Count cone) const { return friction_begin_[cone + 1]; }
  /// The cone whose row meets column j < dense(), -1 for none, and the entry there.
  Count cone(Count j) const { return cone_[j]; }
  double cone_coefficient(Count j) const { return cone_coefficient_[j]; }

 private:
  void copy_jacobian(const Input& input) {
    ngc_ = input.ngc;
    J_.resize(ngc_ * stride_);
    for (Count g = 0; g < ngc_; ++g) {
      for (Count i = 0; i < dense_; ++i) J_[g * stride_ + i] = input.J[g * dense_ + i];
      for (Count i = dense_; i < stride_; ++i) J_[g * stride_ + i] = 0;
    }
    Ginv_.resize(ngc_ * ngc_);
    for (Count i = 0; i < ngc_ * ngc_; ++i) Ginv_[i] = input.Ginv[i];
    terms_.resize(ngc_);
  }

  void copy_cones(const Input& input) {
    cone_.fill(dense_, -1);
    friction_cone_.fill(n_, -1);
    cone_coefficient_.fill(dense_, 0);
    friction_begin_.resize(cones_ + 1);
    for (Count c = 0; c < cones_; ++c) {
      friction_begin_[c] = input.friction_begin[c];
      friction_begin_[c + 1] = input.friction_begin[c + 1];
      cone_[input.cone_normal[c]] = c;
      cone_coefficient_[input.cone_normal[c]] = input.mu[c];
      for (Count t = friction_begin_[c]; t < friction_begin_[c + 1]; ++t) {
        cone_[t] = friction_cone_[t] = c;
        cone_coefficient_[t] = -1;
      }
    }
  }

  void form(Count j) {
    double* column = columns_.data() + formed_ * stride_;
    place_[j] = formed_++;
    for (Count i = 0; i < stride_; ++i) column[i] = 0;
    if (!factored_) {
      for (Count i = 0; i < dense_; ++i) column[i] = matrix_[j * dense_ + i];
      return;
    }
    for (Count g = 0; g < ngc_; ++g) {
      double velocity = 0;
      for (Count h = 0; h < ngc_; ++h) velocity += Ginv_[h * ngc_ + g] * J_[h * stride_ + j];
      terms_[g] = {J_.data() + g * stride_, {velocity, 0}};
    }
    double* const sums[1] = {column};
    add_terms(terms_.data(), ngc_, stride_, sums);
  }

  Count n_ = 0, dense_ = 0, cones_ = 0, stride_ = 0, ngc_ = 0, formed_ = 0;
  bool factored_ = false;
  Buffer<Count> place_;  ///< of each dense column among the formed ones, -1 before that
  Buffer<double> columns_;
  Buffer<double> matrix_;
  Buffer<double> J_;  ///< row g at g * stride_
  Buffer<double> Ginv_;
  Buffer<Term> terms_;
  Buffer<Count> cone_, friction_cone_, friction_begin_;
  Buffer<double> cone_coefficient_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
