#pragma once

#include <cstddef>
#include <vector>

namespace lcpbench {

/// A plain rows x cols array, column after column, zero at first.
///
/// Generators compute in it with loops that are written out: a linear-algebra library may reorder or fuse the
/// operations of a product, and the last bit of a problem would depend on compiler and processor.
template <class T>
struct ColumnMajor {
  std::size_t rows = 0;
  std::size_t cols = 0;
  std::vector<T> data;

  ColumnMajor() = default;
  ColumnMajor(std::size_t row_count, std::size_t column_count)
      : rows(row_count), cols(column_count), data(row_count * column_count) {}

  T& operator()(std::size_t row, std::size_t col) { return data[col * rows + row]; }
  const T& operator()(std::size_t row, std::size_t col) const { return data[col * rows + row]; }
  T* column(std::size_t col) { return data.data() + col * rows; }
  const T* column(std::size_t col) const { return data.data() + col * rows; }
};

}  // namespace lcpbench
