#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/solver.h"

/// The fields of a message between the program and a worker, one after the other, in the byte order of the machine, as
/// both ends run on it: numbers in eight bytes, the indices of sparse matrices in four. Lists follow their lengths,
/// dense matrices (by columns) their dimensions unless these are fixed, variants the index of their kind. A structure
/// has a function fields(io, value) that calls io with its fields; it serves for writing and for reading.
namespace lcpbench::worker {

/// Bytes are no valid message; what() says why, in one clause.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <class Text>
void require(bool condition, const Text& fault) {
  if (!condition) throw BadMessage(fault);
}

/// Appends fields to a text.
class MessageWriter {
 public:
  explicit MessageWriter(std::string& out) : out_(out) {}

  void operator()(const auto&... values) { (write(values), ...); }

 private:
  void write(double value) { bytes(&value, sizeof value); }
  template <class Number>
    requires std::is_integral_v<Number>
  void write(Number value) {
    const auto word = static_cast<std::int64_t>(value);
    bytes(&word, sizeof word);
  }
  void write(const std::string& value) {
    write(value.size());
    bytes(value.data(), value.size());
  }
  template <class Dense>
  void write(const Eigen::PlainObjectBase<Dense>& value) {
    if constexpr (Dense::RowsAtCompileTime == Eigen::Dynamic) write(value.rows());
    if constexpr (Dense::ColsAtCompileTime == Eigen::Dynamic) write(value.cols());
    bytes(value.data(), static_cast<std::size_t>(value.size()) * sizeof(typename Dense::Scalar));
  }
  void write(const SparseMatrix& value) {
    SparseMatrix compressed = value;
    compressed.makeCompressed();
    const Index entries = compressed.nonZeros();
    const auto indices = [](const int* data, Index size) { return Eigen::VectorXi(Eigen::VectorXi::Map(data, size)); };
    (*this)(value.rows(), value.cols(), indices(compressed.outerIndexPtr(), value.cols() + 1),
            indices(compressed.innerIndexPtr(), entries), Vector(Vector::Map(compressed.valuePtr(), entries)));
  }
  template <class Item>
  void write(const std::vector<Item>& values) {
    write(values.size());
    for (const Item& value : values) write(value);
  }
  template <class... Kinds>
  void write(const std::variant<Kinds...>& value) {
    write(value.index());
    std::visit([&](const auto& held) { write(held); }, value);
  }
  template <class Structure>
    requires requires(MessageWriter& io, const Structure& structure) { fields(io, structure); }
  void write(const Structure& value) {
    fields(*this, value);
  }
  void bytes(const void* source, std::size_t count) { out_.append(static_cast<const char*>(source), count); }

  std::string& out_;
};

/// Reads fields in the order in which they were written. Each length is compared with the bytes that are left before
/// memory is taken. The indices of sparse matrices are not checked: only requests have any, and those are our own.
/// @throws BadMessage
class MessageReader {
 public:
  explicit MessageReader(std::string_view bytes) : left_(bytes) {}

  /// The bytes that are not read yet.
  std::string_view left() const { return left_; }
  void operator()(auto&... values) { (read(values), ...); }

 private:
  void read(double& value) { bytes(&value, sizeof value); }
  template <class Number>
    requires std::is_integral_v<Number>
  void read(Number& value) {
    std::int64_t word = 0;
    bytes(&word, sizeof word);
    value = static_cast<Number>(word);
    require(static_cast<std::int64_t>(value) == word, "a number is out of range");
  }
  void read(std::string& value) {
    value.resize(count(1));
    bytes(value.data(), value.size());
  }
  template <class Dense>
  void read(Eigen::PlainObjectBase<Dense>& value) {
    using Scalar = typename Dense::Scalar;
    Index rows = Dense::RowsAtCompileTime;
    Index cols = Dense::ColsAtCompileTime;
    if (rows == Eigen::Dynamic) rows = static_cast<Index>(count(0));
    if (cols == Eigen::Dynamic) cols = static_cast<Index>(count(0));
    const std::size_t room = left_.size() / sizeof(Scalar);
    require(rows == 0 || cols == 0 || rows <= static_cast<Index>(room) / cols, kTooMany);
    value.resize(rows, cols);
    bytes(value.data(), static_cast<std::size_t>(value.size()) * sizeof(Scalar));
  }
  /// By assignment: the function above would call resize() of the base class, not AnswerVector's own.
  void read(AnswerVector& value) {
    Vector plain;
    read(plain);
    value = plain;
  }
  void read(SparseMatrix& value) {
    Index rows = 0, cols = 0;
    Eigen::VectorXi outer, inner;
    Vector values;
    (*this)(rows, cols, outer, inner, values);
    value = Eigen::Map<const SparseMatrix>(rows, cols, values.size(), outer.data(), inner.data(), values.data());
  }
  template <class Item>
  void read(std::vector<Item>& values) {
    values.clear();
    for (std::size_t i = count(sizeof(std::int64_t)); i > 0; --i) read(values.emplace_back());
  }
  template <class... Kinds>
  void read(std::variant<Kinds...>& value) {
    std::size_t kind = 0;
    read(kind);
    require(kind < sizeof...(Kinds), "unknown kind");
    std::size_t next = 0;
    ((next++ == kind ? read(value.template emplace<Kinds>()) : void()), ...);
  }
  template <class Structure>
    requires requires(MessageReader& io, Structure& structure) { fields(io, structure); }
  void read(Structure& value) {
    fields(*this, value);
  }

  /// Reads a number of items. @throws BadMessage if the bytes left do not hold as many of `item_bytes` each; 0: not
  /// compared
  std::size_t count(std::size_t item_bytes) {
    Index value = 0;
    read(value);
    const auto items = static_cast<std::size_t>(value);
    require(value >= 0 && (item_bytes == 0 || items <= left_.size() / item_bytes), kTooMany);
    return items;
  }
  void bytes(void* out, std::size_t count) {
    require(count <= left_.size(), "the message is cut short");
    if (count > 0) std::memcpy(out, left_.data(), count);
    left_.remove_prefix(count);
  }

  static constexpr const char* kTooMany = "more entries than the message holds";
  std::string_view left_;
};

}  // namespace lcpbench::worker
