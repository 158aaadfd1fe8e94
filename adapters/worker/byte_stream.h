#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/types.h"

/// The fields of a message between the program and a worker, one after the other: each begins at a multiple of eight
/// bytes, in the byte order of the machine.
namespace lcpbench::worker {

/// Every field is padded with zeros to a multiple of this.
inline constexpr std::size_t kAlignment = 8;

inline std::size_t padding_after(std::size_t bytes) { return (kAlignment - bytes % kAlignment) % kAlignment; }

/// Counts every byte and writes those that fit.
class ByteWriter {
 public:
  explicit ByteWriter(std::span<std::byte> out) : out_(out) {}

  std::size_t size() const { return size_; }

  void word(std::uint64_t value) { bytes(&value, sizeof value); }
  void integer(std::int64_t value) { bytes(&value, sizeof value); }
  void real(double value) { bytes(&value, sizeof value); }

  template <class T>
  void elements(const T* values, std::size_t count) {
    bytes(values, count * sizeof(T));
  }
  void text(std::string_view value) {
    word(value.size());
    bytes(value.data(), value.size());
  }
  void vector(const Vector& values) {
    integer(values.size());
    elements(values.data(), static_cast<std::size_t>(values.size()));
  }
  template <class Dense>
  void matrix(const Dense& values) {
    integer(values.rows());
    integer(values.cols());
    elements(values.data(), static_cast<std::size_t>(values.size()));
  }
  void overwrite_word(std::size_t at, std::uint64_t value) {
    if (at + sizeof value <= out_.size()) std::memcpy(out_.data() + at, &value, sizeof value);
  }

 private:
  void bytes(const void* source, std::size_t count) {
    static constexpr std::byte kZeros[kAlignment] = {};
    append(source, count);
    append(kZeros, padding_after(count));
  }
  void append(const void* source, std::size_t count) {
    if (count > 0 && size_ <= out_.size() && count <= out_.size() - size_) {
      std::memcpy(out_.data() + size_, source, count);
    }
    size_ += count;
  }

  std::span<std::byte> out_;
  std::size_t size_ = 0;
};

/// Reads forward. After the first failure, everything that is read is zero or empty.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }
  std::size_t remaining() const { return ok() ? bytes_.size() - at_ : 0; }

  void fail(const std::string& cause) {
    if (ok()) error_ = cause;
  }
  void require(bool condition, const std::string& cause) {
    if (!condition) fail(cause);
  }

  std::uint64_t word() { return scalar<std::uint64_t>(); }
  std::int64_t integer() { return scalar<std::int64_t>(); }
  double real() { return scalar<double>(); }

  /// A count of elements that are `element_bytes` each and still to come.
  std::size_t count(std::size_t element_bytes, const char* field) {
    const std::uint64_t value = word();
    require(value <= remaining() / element_bytes, std::string(field) + ": more entries than the message holds");
    return ok() ? static_cast<std::size_t>(value) : 0;
  }
  template <class T>
  void elements(T* out, std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!ok() || count > remaining() / sizeof(T)) return fail("the message is cut short");
    if (count > 0) std::memcpy(out, bytes_.data() + at_, count * sizeof(T));
    at_ += count * sizeof(T);
    skip_padding(count * sizeof(T));
  }
  std::string text(std::size_t max_bytes, const char* field) {
    const std::size_t length = count(1, field);
    require(length <= max_bytes, std::string(field) + ": longer than " + std::to_string(max_bytes) + " bytes");
    std::string value(ok() ? length : 0, '\0');
    elements(value.data(), value.size());
    return value;
  }
  Vector vector(const char* field) {
    Vector values(static_cast<Index>(count(sizeof(double), field)));
    elements(values.data(), static_cast<std::size_t>(values.size()));
    return values;
  }
  Matrix matrix(Index rows, Index cols, const char* field) {
    require_shape(rows, cols, field);
    require(
        cols == 0 || static_cast<std::size_t>(rows) <= remaining() / sizeof(double) / static_cast<std::size_t>(cols),
        std::string(field) + ": more entries than the message holds");
    if (!ok()) return Matrix();
    Matrix values(rows, cols);
    elements(values.data(), static_cast<std::size_t>(values.size()));
    return values;
  }
  void require_shape(Index rows, Index cols, const char* field) {
    const std::int64_t found_rows = integer();
    const std::int64_t found_cols = integer();
    require(found_rows == rows && found_cols == cols, std::string(field) + ": " + std::to_string(found_rows) + " x " +
                                                          std::to_string(found_cols) + ", expected " +
                                                          std::to_string(rows) + " x " + std::to_string(cols));
  }

 private:
  template <class T>
  T scalar() {
    T value{};
    elements(&value, 1);
    return value;
  }
  void skip_padding(std::size_t count) {
    const std::size_t padding = padding_after(count);
    if (padding > remaining()) return fail("the message is cut short");
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at_);
    require(
        std::all_of(begin, begin + static_cast<std::ptrdiff_t>(padding), [](std::byte b) { return b == std::byte{0}; }),
        "padding is not zero");
    at_ += padding;
  }

  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::string error_;
};

}  // namespace lcpbench::worker
