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
/// both ends run on it: numbers in eight bytes, lists after their lengths. A structure has a function fields(io, value)
/// that calls io for each of its fields; it serves for writing and for reading.
namespace lcpbench::worker {

/// A message that is none; the text is one clause.
class BadMessage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

inline void require(bool condition, const std::string& fault) {
  if (!condition) throw BadMessage(fault);
}
inline void require(bool condition, const char* field, const char* fault) {
  if (!condition) throw BadMessage(std::string(field) + ": " + fault);
}

/// Appends fields to a text.
class MessageWriter {
 public:
  explicit MessageWriter(std::string& out) : out_(out) {}

  void operator()(double value, const char*) { bytes(&value, sizeof value); }
  template <class Number>
    requires std::is_integral_v<Number>
  void operator()(Number value, const char*) {
    const auto word = static_cast<std::int64_t>(value);
    bytes(&word, sizeof word);
  }
  void operator()(const std::string& value, const char* field) {
    (*this)(value.size(), field);
    bytes(value.data(), value.size());
  }
  template <class Dense>
  void operator()(const Eigen::PlainObjectBase<Dense>& value, const char* field) {
    if constexpr (Dense::RowsAtCompileTime == Eigen::Dynamic) (*this)(value.rows(), field);
    if constexpr (Dense::ColsAtCompileTime == Eigen::Dynamic) (*this)(value.cols(), field);
    bytes(value.data(), static_cast<std::size_t>(value.size()) * sizeof(typename Dense::Scalar));
  }
  void operator()(const SparseMatrix& value, const char* field) {
    SparseMatrix compressed = value;
    compressed.makeCompressed();
    const Index entries = compressed.nonZeros();
    for (const Index shape : {value.rows(), value.cols()}) (*this)(shape, field);
    (*this)(Eigen::VectorXi(Eigen::VectorXi::Map(compressed.outerIndexPtr(), value.cols() + 1)), field);
    (*this)(Eigen::VectorXi(Eigen::VectorXi::Map(compressed.innerIndexPtr(), entries)), field);
    (*this)(Vector(Vector::Map(compressed.valuePtr(), entries)), field);
  }
  template <class Item>
  void operator()(const std::vector<Item>& values, const char* field) {
    (*this)(values.size(), field);
    for (const Item& value : values) (*this)(value, field);
  }
  template <class... Kinds>
  void operator()(const std::variant<Kinds...>& value, const char* field) {
    (*this)(value.index(), field);
    std::visit([&](const auto& held) { (*this)(held, field); }, value);
  }
  template <class Structure>
    requires requires(MessageWriter& io, const Structure& structure) { fields(io, structure); }
  void operator()(const Structure& value, const char*) {
    fields(*this, value);
  }

 private:
  void bytes(const void* source, std::size_t count) { out_.append(static_cast<const char*>(source), count); }

  std::string& out_;
};

/// Reads fields in the order in which they were written. @throws BadMessage that names the field; each length is held
/// against the bytes that are left before memory is asked for.
class MessageReader {
 public:
  explicit MessageReader(std::string_view bytes) : left_(bytes) {}

  std::string_view left() const { return left_; }

  void operator()(double& value, const char* field) { bytes(&value, sizeof value, field); }
  template <class Number>
    requires std::is_integral_v<Number>
  void operator()(Number& value, const char* field) {
    std::int64_t word = 0;
    bytes(&word, sizeof word, field);
    value = static_cast<Number>(word);
    require(static_cast<std::int64_t>(value) == word, field, "out of range");
  }
  void operator()(std::string& value, const char* field) {
    value.resize(count(1, field));
    bytes(value.data(), value.size(), field);
  }
  template <class Dense>
  void operator()(Eigen::PlainObjectBase<Dense>& value, const char* field) {
    using Scalar = typename Dense::Scalar;
    const std::size_t room = left_.size() / sizeof(Scalar);
    Index rows = Dense::RowsAtCompileTime;
    Index cols = Dense::ColsAtCompileTime;
    if (rows == Eigen::Dynamic) rows = static_cast<Index>(count(0, field));
    if (cols == Eigen::Dynamic) cols = static_cast<Index>(count(0, field));
    require(rows == 0 || cols == 0 || static_cast<std::size_t>(rows) <= room / static_cast<std::size_t>(cols),
            field, "more entries than the message holds");
    value.resize(rows, cols);
    bytes(value.data(), static_cast<std::size_t>(value.size()) * sizeof(Scalar), field);
  }
  void operator()(AnswerVector& value, const char* field) {
    Vector plain;
    (*this)(plain, field);
    value = plain;
  }
  void operator()(SparseMatrix& value, const char* field);
  template <class Item>
  void operator()(std::vector<Item>& values, const char* field) {
    values.clear();
    for (std::size_t i = count(sizeof(std::int64_t), field); i > 0; --i) (*this)(values.emplace_back(), field);
  }
  template <class... Kinds>
  void operator()(std::variant<Kinds...>& value, const char* field) {
    std::size_t kind = 0;
    (*this)(kind, field);
    require(kind < sizeof...(Kinds), field, "unknown kind");
    std::size_t next = 0;
    ((next++ == kind ? (*this)(value.template emplace<Kinds>(), field) : void()), ...);
  }
  template <class Structure>
    requires requires(MessageReader& io, Structure& structure) { fields(io, structure); }
  void operator()(Structure& value, const char*) {
    fields(*this, value);
  }

 private:
  /// A number of items that take at least `item_bytes` each and are still to come.
  std::size_t count(std::size_t item_bytes, const char* field) {
    Index value = 0;
    (*this)(value, field);
    const auto items = static_cast<std::size_t>(value);
    require(value >= 0 && (item_bytes == 0 || items <= left_.size() / item_bytes),
            field, "more entries than the message holds");
    return items;
  }
  void bytes(void* out, std::size_t count, const char* field) {
    require(count <= left_.size(), field, "the message is cut short");
    if (count > 0) std::memcpy(out, left_.data(), count);
    left_.remove_prefix(count);
  }

  std::string_view left_;
};

}  // namespace lcpbench::worker
