#pragma once

#include "core/types.h"

namespace lcpbench {

/// A vector whose memory only grows: it takes any length up to the longest so far without allocating, where Vector
/// allocates at each change of length. After resize() the entries are undefined. Growth, also by reserve(), discards
/// them and invalidates data() and the views. Copy it by `a = b.view()`: `a = b` may allocate, and shrink the memory.
class GrowingVector {
 public:
  void reserve(Index size) {
    if (size > memory_.size()) memory_.resize(size);
  }
  void resize(Index size) {
    reserve(size);
    size_ = size;
  }
  template <class Values>
  GrowingVector& operator=(const Eigen::MatrixBase<Values>& values) {
    resize(values.size());
    view() = values;
    return *this;
  }

  Index size() const { return size_; }
  double* data() { return memory_.data(); }
  const double* data() const { return memory_.data(); }
  double operator()(Index i) const { return memory_(i); }
  Eigen::Map<Vector> view() { return {memory_.data(), size_}; }
  Eigen::Map<const Vector> view() const { return {memory_.data(), size_}; }
  Eigen::ArrayWrapper<Eigen::Map<Vector>> array() { return view().array(); }

  /// The same memory as a matrix, by columns. @pre rows * columns == size()
  Eigen::Map<Matrix> as_matrix(Index rows, Index columns) { return {memory_.data(), rows, columns}; }

 private:
  Vector memory_;
  Index size_ = 0;
};

}  // namespace lcpbench
