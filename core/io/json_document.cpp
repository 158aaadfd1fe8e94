#include "core/io/json_document.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/io/problem_checks.h"
#include "core/settings.h"

namespace lcpbench {
namespace {

constexpr std::size_t kMaxFields = 100;
constexpr std::size_t kMaxDepth = 10;

/// What an error says was found: a boolean by its value, else the type.
const char* type_name(const Json& json) {
  switch (json.type()) {
    case Json::value_t::null: return "null";
    case Json::value_t::boolean: return json.get<bool>() ? "true" : "false";
    case Json::value_t::string: return "a text";
    case Json::value_t::array: return "a list";
    case Json::value_t::object: return "an object";
    default: return "a number";
  }
}

/// Builds the document from nlohmann-json's events. It may throw through the parser, which holds no resource then.
class Builder {
 public:
  Builder(std::string_view text, const std::string& origin, bool one_line)
      : text_(text), origin_(origin), one_line_(one_line) {}

  Json take() { return std::move(root_); }

  bool null() { return add(nullptr); }
  bool boolean(bool value) { return add(value); }
  // Only "-0" comes as a signed zero: the parser gives every other integer without a minus as unsigned.
  bool number_integer(Json::number_integer_t value) { return add(value == 0 ? Json(-0.0) : Json(value)); }
  bool number_unsigned(Json::number_unsigned_t value) { return add(value); }
  bool number_float(Json::number_float_t value, const Json::string_t&) { return add(value); }
  bool binary(Json::binary_t&) { return false; }  // JSON texts have none
  bool string(Json::string_t& text) { return add(std::move(text)); }
  bool start_object(std::size_t) { return open(Json::object()); }
  bool start_array(std::size_t) { return open(Json::array()); }
  bool end_object() { return close(); }
  bool end_array() { return close(); }

  bool key(Json::string_t& name) {
    Json& object = *open_.back();
    const bool twice = object.contains(name);
    field_ = &object[name];
    if (twice) throw input_error(origin_, path(name) + ": given twice");
    if (object.size() > kMaxFields) {
      throw input_error(origin_, path(name) + ": more than " + std::to_string(kMaxFields) + " fields in an object");
    }
    return true;
  }

  bool parse_error(std::size_t after, const std::string& token, const nlohmann::detail::exception& error) {
    constexpr int kNumberOverflow = 406;
    const std::string where = path();
    if (error.id == kNumberOverflow) {
      throw input_error(origin_,
                        where + (where.empty() ? "" : ": ") + in_quotes(token) + " is beyond the range of double");
    }
    const std::string inside = where.empty() ? "" : " (in " + where + ")";
    if (text_.empty()) throw input_error(origin_, "empty file");
    if (after > text_.size()) {
      throw input_error(origin_, std::string("truncated: the ") + (one_line_ ? "line" : "file") + " ends at " +
                                     position(text_.size()) + inside);
    }
    const std::size_t last = after == 0 ? 0 : after - 1;
    throw input_error(origin_, position(last) + ": not valid JSON" + describe(text_[last]) + inside);
  }

  std::string position(std::size_t offset) const {
    return one_line_ ? "column " + std::to_string(offset + 1) : line_and_column(text_, offset);
  }

 private:
  static std::string describe(char c) {
    if (static_cast<unsigned char>(c) >= 0x80) return ", or not UTF-8";
    if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7F) return "";
    return std::string(": unexpected '") + c + "'";
  }

  /// Puts a value where it belongs.
  Json& place(Json value) {
    if (open_.empty()) return root_ = std::move(value);
    Json& outer = *open_.back();
    // A text or a list that is a field takes no more memory than the text of the document.
    const bool is_counted = outer.is_array() || !(value.is_string() || value.is_array());
    if (is_counted && ++count_ > kMaxNumbers) {
      throw input_error(origin_, path() + ": more than " + std::to_string(kMaxNumbers) + " numbers in the file");
    }
    if (outer.is_object()) return *field_ = std::move(value);
    outer.push_back(std::move(value));
    return outer.back();
  }

  bool add(Json value) {
    place(std::move(value));
    return true;
  }

  bool open(Json empty) {
    if (open_.size() == kMaxDepth) {
      throw input_error(origin_, "more than " + std::to_string(kMaxDepth) + " levels of lists and objects");
    }
    open_.push_back(&place(std::move(empty)));
    return true;
  }

  bool close() {
    open_.pop_back();
    return true;
  }

  /// What is being read: "bodies[3].mass". @param last  the field of the innermost object, where it is not its newest
  std::string path(const std::string& last = "") const {
    std::string result;
    for (std::size_t level = 0; level < open_.size(); ++level) {
      const bool innermost = level + 1 == open_.size();
      const Json& json = *open_[level];
      if (json.is_array()) {
        result = entry_name(result, json.size() - (innermost ? 0 : 1));
      } else if (!json.empty()) {
        const std::string& newest = json.get_ref<const Json::object_t&>().back().first;
        result += (result.empty() ? "" : ".") + (innermost && !last.empty() ? last : newest);
      }
    }
    return result;
  }

  std::string_view text_;
  const std::string& origin_;
  bool one_line_;
  Json root_;
  std::vector<Json*> open_;  ///< lists and objects that have no end yet
  Json* field_ = nullptr;    ///< the value of the newest field of the innermost object
  std::size_t count_ = 0;    ///< numbers, and what lists hold
};

}  // namespace

std::string line_and_column(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - line_begin + 1);
}

Json parse_json_document(std::string_view text, const std::string& origin, bool one_line) {
  Builder builder(text, origin, one_line);
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {  // the parser would take it for the end
    throw input_error(origin, builder.position(nul) + ": a NUL byte: not a text file");
  }
  Json::sax_parse(text.data(), text.data() + text.size(), &builder);
  return builder.take();
}

JsonObject::JsonObject(const Json& json, const std::string& origin, std::string path)
    : json_(json), origin_(origin), path_(std::move(path)) {
  if (!json.is_object()) {
    throw input_error(origin_, path_ + (path_.empty() ? "" : ": ") + "expected an object, found " + type_name(json));
  }
  if (!path_.empty()) path_ += ".";
}

void JsonObject::only(std::initializer_list<std::string_view> fields, const std::string& of) const {
  for (const auto& [name, value] : json_.items()) {
    if (std::find(fields.begin(), fields.end(), name) != fields.end()) continue;
    const std::string outer = path_.empty() ? "" : path_.substr(0, path_.size() - 1) + ": ";
    throw input_error(origin_, outer + "unknown field " + in_quotes(name) + of);
  }
}

void JsonObject::check_format(const std::string& expected) const {
  const std::string& format = text("format");
  if (format != expected) fail("format", ": " + in_quotes(format) + ", expected '" + expected + "'");
  const double version = number("version");
  if (version != 1) fail("version", ": " + format_real(version) + " is not known; this program reads version 1");
}

void JsonObject::fail(std::string_view field, const std::string& message) const {
  throw input_error(origin_, path_ + std::string(field) + message);
}

void JsonObject::wrong_type(const std::string& field, const char* expected, const Json& found) const {
  fail(field, std::string(": expected ") + expected + ", found " + type_name(found));
}

const Json& JsonObject::value(std::string_view field) const {
  const auto found = json_.find(std::string(field));
  if (found == json_.end()) fail(field, ": missing");
  return *found;
}

const Json& JsonObject::list(const Json& json, const std::string& field, const char* expected) const {
  if (!json.is_array()) wrong_type(field, expected, json);
  return json;
}

const std::string& JsonObject::text(std::string_view field) const {
  const Json& json = value(field);
  if (!json.is_string()) wrong_type(std::string(field), "a text", json);
  return json.get_ref<const std::string&>();
}

bool JsonObject::boolean(std::string_view field) const {
  const Json& json = value(field);
  if (!json.is_boolean()) wrong_type(std::string(field), "true or false", json);
  return json.get<bool>();
}

std::uint64_t JsonObject::unsigned_integer(std::string_view field) const {
  const Json& json = value(field);
  if (json.is_number_unsigned()) return json.get<std::uint64_t>();
  if (json.is_number()) fail(field, " is " + format_real(json.get<double>()) + ", expected an integer in [0, 2^64)");
  wrong_type(std::string(field), "an integer in [0, 2^64)", json);
}

std::int64_t JsonObject::integer(std::string_view field, std::int64_t low, std::int64_t high) const {
  const double found = number(field);
  if (found >= static_cast<double>(low) && found <= static_cast<double>(high) && found == std::floor(found)) {
    return static_cast<std::int64_t>(found);
  }
  fail(field, " is " + format_real(found) + ", expected an integer in [" + std::to_string(low) + ", " +
                  std::to_string(high) + "]");
}

std::vector<std::string> JsonObject::texts(std::string_view field) const {
  const std::string name(field);
  std::vector<std::string> result;
  for (const Json& entry : list(value(field), name, "a list of texts")) {
    if (!entry.is_string()) wrong_type(entry_name(name, result.size()), "a text", entry);
    result.push_back(entry);
  }
  return result;
}

double JsonObject::number(std::string_view field) const {
  const Json& json = value(field);
  if (!json.is_number()) wrong_type(std::string(field), "a number", json);
  return json.get<double>();
}

int JsonObject::to_integer(double number, const std::string& field) const {
  const bool fits = number >= std::numeric_limits<int>::min() && number <= std::numeric_limits<int>::max();
  if (!fits || number != std::floor(number)) fail(field, " is " + format_real(number) + ", expected an integer");
  return static_cast<int>(number);
}

int JsonObject::integer(std::string_view field) const { return to_integer(number(field), std::string(field)); }

/// @param none  what null stands for, where it may stand
Vector JsonObject::numbers(const Json& json, const std::string& field, std::optional<double> none) const {
  Vector result(static_cast<Index>(list(json, field, "a list of numbers").size()));
  std::size_t i = 0;
  for (const Json& entry : json) {
    const bool is_none = none && entry.is_null();
    if (!is_none && !entry.is_number()) {
      wrong_type(entry_name(field, i), none ? "a finite number or null" : "a finite number", entry);
    }
    result(static_cast<Index>(i++)) = is_none ? *none : entry.get<double>();
  }
  return result;
}

Vector JsonObject::vector(std::string_view field) const { return numbers(value(field), std::string(field)); }

Vector JsonObject::sized(Vector result, std::string_view field, Index size) const {
  if (result.size() == size) return result;
  fail(field, ": " + count_of(result.size(), "entry") + ", expected " + std::to_string(size));
}

Vector JsonObject::vector(std::string_view field, Index size) const { return sized(vector(field), field, size); }

Vector JsonObject::vector_with_nulls(std::string_view field, Index size, double none) const {
  return sized(numbers(value(field), std::string(field), none), field, size);
}

std::vector<int> JsonObject::integers(std::string_view field) const { return integers(field, vector(field)); }

std::vector<int> JsonObject::integers(std::string_view field, const Vector& numbers) const {
  std::vector<int> result;
  for (const double number : numbers) {
    result.push_back(to_integer(number, entry_name(std::string(field), result.size())));
  }
  return result;
}

std::vector<Vector> JsonObject::rows(std::string_view field) const {
  const std::string name(field);
  std::vector<Vector> result;
  for (const Json& row : list(value(field), name, "a list of rows of numbers")) {
    result.push_back(numbers(row, entry_name(name, result.size())));
  }
  return result;
}

Matrix JsonObject::matrix_of(const Json& json, const std::string& field, Index rows, Index cols) const {
  const auto found = static_cast<Index>(list(json, field, "a list of rows of numbers").size());
  if (found != rows) fail(field, ": " + count_of(found, "row") + ", expected " + std::to_string(rows));
  std::size_t i = 0;
  for (const Json& row : json) {  // before memory is taken for what other fields promise
    const auto size = static_cast<Index>(list(row, entry_name(field, i), "a list of numbers").size());
    if (size != cols) {
      fail(field,
           ": row " + std::to_string(i) + " has " + count_of(size, "entry") + ", expected " + std::to_string(cols));
    }
    ++i;
  }
  Matrix matrix(rows, cols);
  i = 0;
  for (const Json& row : json) {
    matrix.row(static_cast<Index>(i)) = numbers(row, entry_name(field, i));
    ++i;
  }
  return matrix;
}

Matrix JsonObject::matrix(std::string_view field, Index rows, Index cols) const {
  return matrix_of(value(field), std::string(field), rows, cols);
}

std::optional<Index> JsonObject::columns(std::string_view field) const {
  const Json& rows = list(value(field), std::string(field), "a list of rows of numbers");
  if (rows.empty()) return std::nullopt;
  return static_cast<Index>(list(rows[0], entry_name(std::string(field), 0), "a list of numbers").size());
}

std::vector<Matrix> JsonObject::square_matrices(std::string_view field) const {
  const std::string name(field);
  std::vector<Matrix> result;
  for (const Json& block : list(value(field), name, "a list of matrices")) {
    const std::string path = entry_name(name, result.size());
    const auto order = static_cast<Index>(list(block, path, "a list of rows of numbers").size());
    if (order == 0) fail(path, ": empty");
    result.push_back(matrix_of(block, path, order, order));
  }
  return result;
}

JsonObject JsonObject::inside(std::string_view field) const {
  return {value(field), origin_, path_ + std::string(field)};
}

std::vector<JsonObject> JsonObject::objects(std::string_view field) const {
  const std::string name(field);
  std::vector<JsonObject> result;
  for (const Json& object : list(value(field), name, "a list of objects")) {
    result.emplace_back(object, origin_, path_ + entry_name(name, result.size()));
  }
  return result;
}

}  // namespace lcpbench
