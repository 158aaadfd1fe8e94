#pragma once

#include <string>
#include <utility>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "core/contact_problem.h"
#include "core/error.h"

// What comes from Python, checked: every error is one line that names the argument and its shape.

namespace lcpbench::python {

namespace py = pybind11;

using Array = py::array_t<double, py::array::f_style | py::array::forcecast>;

inline std::string shape_text(const py::array& array) { return py::str(array.attr("shape")); }

/// @throws py::type_error for anything but real numbers
inline Array numbers(const py::handle& value, const std::string& name) {
  if (py::isinstance<Array>(value)) return py::reinterpret_borrow<Array>(value);
  const auto any = py::array::ensure(value);
  if (!any) {
    const std::string type = py::str(py::type::of(value).attr("__name__"));
    throw py::type_error(name + ": expected an array of numbers, got " + type);
  }
  if (std::string("biuf").find(any.dtype().kind()) == std::string::npos) {
    throw py::type_error(name + ": expected real numbers, got " + std::string(py::str(any.dtype())));
  }
  return Array(any);
}

/// @param size  -1: any
inline Vector vector(const py::handle& value, const std::string& name, Index size = -1) {
  const Array array = numbers(value, name);
  if (array.ndim() != 1 || (size >= 0 && array.shape(0) != size)) {
    throw InputError(name + " has shape " + shape_text(array) + ", expected (" +
                     (size >= 0 ? std::to_string(size) : std::string("n")) + ",)");
  }
  return Eigen::Map<const Vector>(array.data(), array.shape(0));
}

inline Matrix matrix(const py::handle& value, const std::string& name, Index rows = -1, Index cols = -1) {
  const Array array = numbers(value, name);
  const auto fits = [&](int axis, Index size) { return size < 0 || array.shape(axis) == size; };
  if (array.ndim() != 2 || !fits(0, rows) || !fits(1, cols)) {
    const auto word = [](Index size, const char* any) { return size >= 0 ? std::to_string(size) : std::string(any); };
    throw InputError(name + " has shape " + shape_text(array) + ", expected (" + word(rows, "n") + ", " +
                     word(cols, "m") + ")");
  }
  return Eigen::Map<const Matrix>(array.data(), array.shape(0), array.shape(1));
}

/// A dense array, or what scipy.sparse has.
inline Jacobian jacobian(const py::handle& value, const std::string& name, Index rows, Index cols) {
  if (!py::hasattr(value, "tocsc")) return matrix(value, name, rows, cols);
  const auto csc = py::reinterpret_borrow<py::object>(value).attr("tocsc")();
  const auto shape = csc.attr("shape").cast<std::pair<Index, Index>>();
  if (shape.first != rows || shape.second != cols) {
    throw InputError(name + " has shape " + std::string(py::str(csc.attr("shape"))) + ", expected (" +
                     std::to_string(rows) + ", " + std::to_string(cols) + ")");
  }
  csc.attr("sum_duplicates")();
  const Vector values = vector(csc.attr("data"), name);
  const auto inner = csc.attr("indices").cast<py::array_t<int, py::array::forcecast>>();
  const auto outer = csc.attr("indptr").cast<py::array_t<int, py::array::forcecast>>();
  return SparseMatrix(
      Eigen::Map<const SparseMatrix>(rows, cols, values.size(), outer.data(), inner.data(), values.data()));
}

}  // namespace lcpbench::python
