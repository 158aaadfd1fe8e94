#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/types.h"

namespace lcpbench {

/// A JSON value. Numbers of a text are 64-bit integers if they fit, else correctly rounded doubles; -0 keeps its sign.
using Json = nlohmann::ordered_json;

/// Parses a JSON document. Memory is bounded by kMaxNumbers numbers, rows and items, by 100 fields in an object and by
/// ten levels of nesting, which are refused as they appear.
/// @param one_line  the text is one line of a file, which the origin names: errors tell the column alone
/// @throws InputError naming the line and column or the field; also for a field given twice and a number that overflows
Json parse_json_document(std::string_view text, const std::string& origin, bool one_line = false);

/// "line 3, column 14" of a byte offset, both counted from 1, columns in bytes.
std::string line_and_column(std::string_view text, std::size_t offset);

/// Reads typed values out of a JSON object. Every error is an InputError that names the file and the path of the field
/// ("contacts[2].mu"). Views the object and the origin.
class JsonObject {
 public:
  JsonObject(const Json& json, const std::string& origin, std::string path = "");

  /// Refuses all other fields. @param of  what the fields belong to, for the message
  void only(std::initializer_list<std::string_view> fields, const std::string& of = "") const;

  /// Refuses documents of another format or of a version other than 1.
  void check_format(const std::string& expected) const;

  bool given(std::string_view field) const { return json_.contains(std::string(field)); }
  [[noreturn]] void fail(std::string_view field, const std::string& message) const;

  /// The field's value, of whatever type.
  const Json& value(std::string_view field) const;
  const std::string& text(std::string_view field) const;
  bool boolean(std::string_view field) const;
  std::vector<std::string> texts(std::string_view field) const;
  double number(std::string_view field) const;
  int integer(std::string_view field) const;
  /// @pre both bounds are below 2^53
  std::int64_t integer(std::string_view field, std::int64_t low, std::int64_t high) const;
  std::uint64_t unsigned_integer(std::string_view field) const;
  Vector vector(std::string_view field) const;
  Vector vector(std::string_view field, Index size) const;
  /// Numbers, and `none` where null stands.
  Vector vector_with_nulls(std::string_view field, Index size, double none) const;
  std::vector<int> integers(std::string_view field) const;
  /// The same of numbers that are there already.
  std::vector<int> integers(std::string_view field, const Vector& numbers) const;
  /// Rows of any lengths.
  std::vector<Vector> rows(std::string_view field) const;
  Matrix matrix(std::string_view field, Index rows, Index cols) const;
  /// Columns of the first row; nullopt when there is no row to tell.
  std::optional<Index> columns(std::string_view field) const;
  /// A list of square matrices.
  std::vector<Matrix> square_matrices(std::string_view field) const;

  bool is_object(std::string_view field) const { return given(field) && json_.at(std::string(field)).is_object(); }
  JsonObject inside(std::string_view field) const;
  std::vector<JsonObject> objects(std::string_view field) const;

 private:
  const Json& list(const Json& json, const std::string& field, const char* expected) const;
  Vector numbers(const Json& json, const std::string& field, std::optional<double> none = std::nullopt) const;
  Vector sized(Vector result, std::string_view field, Index size) const;
  Matrix matrix_of(const Json& json, const std::string& field, Index rows, Index cols) const;
  int to_integer(double number, const std::string& field) const;
  [[noreturn]] void wrong_type(const std::string& field, const char* expected, const Json& found) const;

  const Json& json_;
  const std::string& origin_;
  std::string path_;  ///< "" or with a dot at its end
};

}  // namespace lcpbench
