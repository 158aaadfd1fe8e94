#pragma once

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include <nanobind/eigen/dense.h>
#include <nanobind/eigen/sparse.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include "core/contact_problem.h"
#include "core/error.h"
#include "core/round_cone.h"

// What comes from Python, checked: every error is one line that names the argument and its shape.

namespace lcpbench::python {

namespace nb = nanobind;

using Array = nb::ndarray<const double, nb::device::cpu>;  // with any strides

/// Of an array, a matrix of scipy.sparse or nested lists.
inline std::string shape_text(nb::handle value) {
  return nb::str(nb::module_::import_("numpy").attr("shape")(value)).c_str();
}

inline Index length(const Array& array, std::size_t axis) { return static_cast<Index>(array.shape(axis)); }

/// @throws nb::type_error for anything but real numbers
inline Array numbers(nb::handle value, const std::string& name) {
  Array array;
  if (nb::try_cast(value, array, false)) return array;
  nb::object any;
  try {
    any = nb::module_::import_("numpy").attr("asarray")(value);
  } catch (const nb::python_error&) {
    nb::raise_type_error("%s: expected an array of numbers, got %s", name.c_str(),
                         nb::str(value.type().attr("__name__")).c_str());
  }
  const nb::object type = any.attr("dtype");
  if (std::string("biuf").find(nb::cast<std::string>(type.attr("kind"))) == std::string::npos) {
    nb::raise_type_error("%s: expected real numbers, got %s", name.c_str(), nb::str(type).c_str());
  }
  return nb::cast<Array>(any.attr("astype")("d"));
}

/// @param size  -1: any
inline Vector vector(nb::handle value, const std::string& name, Index size = -1) {
  const Array array = numbers(value, name);
  if (array.ndim() != 1 || (size >= 0 && length(array, 0) != size)) {
    throw InputError(name + " has shape " + shape_text(value) + ", expected (" +
                     (size >= 0 ? std::to_string(size) : std::string("n")) + ",)");
  }
  return Eigen::Map<const Vector, 0, Eigen::InnerStride<>>(array.data(), length(array, 0),
                                                           Eigen::InnerStride<>(array.stride(0)));
}

inline Matrix matrix(nb::handle value, const std::string& name, Index rows = -1, Index cols = -1) {
  const Array array = numbers(value, name);
  const auto fits = [&](std::size_t axis, Index size) { return size < 0 || length(array, axis) == size; };
  if (array.ndim() != 2 || !fits(0, rows) || !fits(1, cols)) {
    const auto word = [](Index size, const char* any) { return size >= 0 ? std::to_string(size) : std::string(any); };
    throw InputError(name + " has shape " + shape_text(value) + ", expected (" + word(rows, "n") + ", " +
                     word(cols, "m") + ")");
  }
  return nb::DMap<const Matrix>(array.data(), length(array, 0), length(array, 1), {array.stride(1), array.stride(0)});
}

/// An array of numpy, in a third of the time that nanobind's own conversion takes: for a simulator's loop.
inline nb::object array(const Vector& values) {
  static const nb::handle frombuffer = nb::getattr(nb::module_::import_("numpy"), "frombuffer").release();
  return frombuffer(nb::bytearray(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double)));
}

/// A dense array, or what scipy.sparse has.
inline Jacobian jacobian(nb::handle value, const std::string& name, Index rows, Index cols) {
  if (!nb::hasattr(value, "tocsc")) return matrix(value, name, rows, cols);
  const nb::object csc = value.attr("tocsc")(true);  // a copy, because sum_duplicates changes it
  if (nb::cast<std::pair<Index, Index>>(csc.attr("shape")) != std::pair(rows, cols)) {
    throw InputError(name + " has shape " + shape_text(csc) + ", expected (" + std::to_string(rows) + ", " +
                     std::to_string(cols) + ")");
  }
  csc.attr("sum_duplicates")();
  numbers(csc.attr("data"), name);  // names what holds no real numbers
  return nb::cast<SparseMatrix>(csc);
}

/// [f_N; f_D; f_R] from that, or from [f_N; f_D] or a row (normal, tangent, tangent) for each contact.
/// @param rows  f_R where `value` does not have it, or None
/// @param more  another shape that the caller takes, for the message @throws InputError
inline Vector contact_impulses(const ContactProblem& contact, nb::handle value, nb::handle rows,
                               const std::string& more = "") {
  const ContactLayout layout = contact_layout(contact);
  const Index all = layout.lambda_offset() + layout.rows;
  const Array given = numbers(value, "impulses");
  const Index of_value = rows.is_none() ? all : layout.lambda_offset();
  Vector f = Vector::Zero(all);
  if (!rows.is_none()) f.tail(layout.rows) = vector(rows, "row_impulses", layout.rows);
  if (given.ndim() == 1 && length(given, 0) == of_value) {
    f.head(of_value) = vector(value, "impulses");
    return f;
  }
  if (rows.is_none() && layout.rows > 0 && given.ndim() == 2) {
    throw InputError("row_impulses is missing: there are " + std::to_string(layout.rows) + " bounded rows");
  }
  if (given.ndim() != 2 || length(given, 0) != layout.nc || length(given, 1) != 3) {
    throw InputError("impulses has shape " + shape_text(value) + ", expected " + more + "(" +
                     std::to_string(of_value) +
                     (of_value > layout.lambda_offset() ? ",) for [f_N; f_D; f_R], or (" : ",) for [f_N; f_D], or (") +
                     std::to_string(layout.nc) +
                     ", 3) for the normal and both tangents");
  }
  // Four edges are along both tangents, even where a mechanism makes these the same direction.
  if (std::ranges::any_of(contact.edges, [](int edges) { return edges != 0 && edges != 4; })) {
    const std::string no_cone = why_no_round_cone(contact);
    if (!no_cone.empty()) throw InputError("impulses: " + no_cone);
  }
  const Matrix axes = matrix(value, "impulses");
  f.head(layout.nc) = axes.col(0);
  for (Index i = 0; i < layout.nc; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (contact.edges[at] > 0) {
      share_among_directions(axes(i, 1), axes(i, 2),
                             f.segment(layout.nc + layout.friction_begin[at], contact.edges[at]));
    } else if (axes(i, 1) != 0 || axes(i, 2) != 0) {
      throw InputError("impulses[" + std::to_string(i) + "] has friction, and the contact has none");
    }
  }
  return f;
}

/// @throws InputError for an entry that stands there twice
template <class Key>
void check_distinct(const std::vector<Key>& keys, const char* name) {
  std::unordered_map<Key, std::size_t> seen;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto [first, is_new] = seen.try_emplace(keys[i], i);
    if (is_new) continue;
    throw InputError(std::string(name) + "[" + std::to_string(i) + "] is that of contact " +
                     std::to_string(first->second) + " again; each contact has its own");
  }
}

}  // namespace lcpbench::python
