#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/settings.h"
#include "core/types.h"

namespace lcpbench {

/// Reads typed values out of one record; `path` ("contacts[2].") and the file go into every error.
class RecordReader {
 public:
  RecordReader(const Record& record, const std::string& origin, std::string path = "")
      : record_(record), origin_(origin), path_(std::move(path)) {}

  bool given(std::string_view field) const { return record_.given(field); }

  [[noreturn]] void fail(std::string_view field, const std::string& message) const {
    throw input_error(origin_, path_ + std::string(field) + message);
  }

  const std::string& text(std::string_view field) const { return required(field).text; }

  double number(std::string_view field) const { return required(field).table.numbers.front(); }

  int integer(std::string_view field) const { return to_integer(number(field), std::string(field)); }

  Vector vector(std::string_view field) const {
    const std::vector<double>& numbers = required(field).table.numbers;
    return Eigen::Map<const Vector>(numbers.data(), static_cast<Index>(numbers.size()));
  }

  const std::vector<std::string>& texts(std::string_view field) const { return required(field).texts; }

  /// Whether the field is given as an object.
  bool has_object(std::string_view field) const { return !record_.value(field).object.empty(); }

  RecordReader inside(std::string_view field) const {
    return {required(field).object.front(), origin_, path_ + std::string(field) + "."};
  }

  const NumberTable& table(std::string_view field) const { return required(field).table; }

  std::vector<int> integers(std::string_view field) const {
    const std::vector<double>& numbers = required(field).table.numbers;
    std::vector<int> result(numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      result[i] = to_integer(numbers[i], std::string(field) + "[" + std::to_string(i) + "]");
    }
    return result;
  }

  /// Columns of the first row; nullopt when there is no row to tell.
  std::optional<Index> columns(std::string_view field) const {
    const NumberTable& table = required(field).table;
    if (table.row_ends.empty()) return std::nullopt;
    return static_cast<Index>(table.row_length(0));
  }

  Matrix matrix(std::string_view field, Index rows, Index cols) const {
    const NumberTable& table = required(field).table;
    if (static_cast<Index>(table.row_ends.size()) != rows) {
      fail(field,
           ": " + count_of(static_cast<Index>(table.row_ends.size()), "row") + ", expected " + std::to_string(rows));
    }
    for (std::size_t row = 0; row < table.row_ends.size(); ++row) {
      if (static_cast<Index>(table.row_length(row)) == cols) continue;
      fail(field, ": row " + std::to_string(row) + " has " +
                      count_of(static_cast<Index>(table.row_length(row)), "entry") + ", expected " +
                      std::to_string(cols));
    }
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const RowMajor>(table.numbers.data(), rows, cols);
  }

  Eigen::Vector2d vector2(std::string_view field) const { return vector_of(field, 2); }
  Eigen::Vector3d vector3(std::string_view field) const { return vector_of(field, 3); }

 private:
  Vector vector_of(std::string_view field, Index size) const {
    Vector numbers = vector(field);
    if (numbers.size() == size) return numbers;
    fail(field, ": " + count_of(numbers.size(), "entry") + ", expected " + std::to_string(size));
  }

  const Record::Value& required(std::string_view field) const {
    const Record::Value& value = record_.value(field);
    if (!value.given) fail(field, ": missing");
    return value;
  }

  int to_integer(double number, const std::string& field) const {
    const bool fits = number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max();
    if (!fits || number != std::floor(number)) fail(field, " is " + format_real(number) + ", expected an integer");
    return static_cast<int>(number);
  }

  const Record& record_;
  const std::string& origin_;
  std::string path_;
};

}  // namespace lcpbench
