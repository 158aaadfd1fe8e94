#include "core/io/json_document.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "core/io/problem_checks.h"

namespace lcpbench {
namespace {

/// Longest number or string. Exact decimal expansions of doubles need up to 1,100 digits.
constexpr std::size_t kMaxTokenBytes = 4096;

bool is_boundary(char c) {
  switch (c) {
    case ' ':
    case '\t':
    case '\n':
    case '\r':
    case ',':
    case ':':
    case '[':
    case ']':
    case '{':
    case '}': return true;
    default: return false;
  }
}

/// Refuses what would make the parser hold an unbounded token, and binary files, in one pass over the bytes.
void check_tokens(std::string_view text, const std::string& origin) {
  bool in_string = false;
  std::size_t length = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\0') throw input_error(origin, line_and_column(text, i) + ": a NUL byte: not a text file");
    if (!in_string && is_boundary(c)) {
      length = 0;
      continue;
    }
    if (++length > kMaxTokenBytes) {
      throw input_error(origin, line_and_column(text, i) + ": a number or text longer than " +
                                    std::to_string(kMaxTokenBytes) + " bytes");
    }
    if (c == '"') {
      in_string = !in_string;
    } else if (in_string && c == '\\') {
      ++i;
      ++length;
    }
  }
}

const char* type_name(FieldType type) {
  switch (type) {
    case FieldType::kText: return "a text";
    case FieldType::kNumber: return "a number";
    case FieldType::kNumbers: return "a list of numbers";
    case FieldType::kRows: return "a list of rows of numbers";
    case FieldType::kObject: return "an object";
    case FieldType::kObjects: return "a list of objects";
  }
  return "nothing";
}

/// nlohmann-json's event interface. It may throw through the parser, because the parser holds no resource then.
class DocumentHandler {
 public:
  using Json = nlohmann::json;

  DocumentHandler(std::string_view text, const std::string& origin, std::span<const Field> fields,
                  const DocumentEvents& events)
      : text_(text), origin_(origin), events_(events), top_(fields) {}

  Record take() { return std::move(top_); }

  bool null() { wrong_type("null"); }
  bool boolean(bool value) { wrong_type(value ? "true" : "false"); }
  // Only "-0" comes as a signed zero: the parser gives every other integer without a minus as unsigned.
  bool number_integer(Json::number_integer_t value) {
    return add_number(value == 0 ? -0.0 : static_cast<double>(value));
  }
  bool number_unsigned(Json::number_unsigned_t value) { return add_number(static_cast<double>(value)); }
  bool number_float(Json::number_float_t value, const Json::string_t&) { return add_number(value); }
  bool binary(Json::binary_t&) { wrong_type("binary data"); }

  bool string(Json::string_t& text) {
    if (field_ == nullptr || field_->type != FieldType::kText) wrong_type("a text");
    value().text = std::move(text);
    complete_field();
    return true;
  }

  bool start_object(std::size_t) {
    if (!started_) {
      started_ = true;
      return true;
    }
    const bool expected =
        field_ != nullptr && !inside_ && field_->type == (depth_ == 0 ? FieldType::kObject : FieldType::kObjects);
    if (!expected) wrong_type("an object");
    count_towards_limit();
    outer_ = field_;
    if (item_.fields().data() != outer_->inside.data()) item_ = Record(outer_->inside);
    item_.clear();
    inside_ = true;
    depth_ = 0;
    field_ = nullptr;
    return true;
  }

  bool key(Json::string_t& name) {
    Record& record = current();
    field_ = record.find(name);
    if (field_ == nullptr) throw input_error(origin_, item_path(": ") + "unknown field " + in_quotes(name));
    if (value().given) throw input_error(origin_, path() + ": given twice");
    value().given = true;
    return true;
  }

  bool end_object() {
    if (!inside_) return true;
    inside_ = false;
    field_ = outer_;
    depth_ = array_depth(field_->type);
    if (field_->type == FieldType::kObject) {
      value().object.push_back(item_);
      complete_field();
    } else {
      events_.item(field_->name, items_, item_);
      ++items_;
    }
    return true;
  }

  bool start_array(std::size_t) {
    if (field_ == nullptr || depth_ >= array_depth(field_->type)) wrong_type("a list");
    ++depth_;
    return true;
  }

  bool end_array() {
    --depth_;
    if (field_->type == FieldType::kRows && depth_ == 1) {
      count_towards_limit();
      value().table.row_ends.push_back(value().table.numbers.size());
    }
    if (depth_ == 0) {
      items_ = 0;
      complete_field();
    }
    return true;
  }

  bool parse_error(std::size_t position, const std::string& token, const nlohmann::detail::exception& error) {
    constexpr int kNumberOverflow = 406;
    if (error.id == kNumberOverflow) {
      if (field_ == nullptr) wrong_type("a number");
      throw input_error(origin_, where() + ": " + in_quotes(token) + " is beyond the range of double");
    }
    const std::string inside = field_ == nullptr ? "" : " (in " + where() + ")";
    if (text_.empty()) throw input_error(origin_, "empty file");
    if (position > text_.size()) {
      throw input_error(origin_, "truncated: the file ends at " + line_and_column(text_, text_.size()) + inside);
    }
    const std::size_t last = position == 0 ? 0 : position - 1;
    throw input_error(origin_, line_and_column(text_, last) + ": not valid JSON" + describe(text_[last]) + inside);
  }

 private:
  static int array_depth(FieldType type) {
    switch (type) {
      case FieldType::kNumbers:
      case FieldType::kObjects: return 1;
      case FieldType::kRows: return 2;
      default: return 0;
    }
  }

  static std::string describe(char c) {
    if (static_cast<unsigned char>(c) >= 0x80) return ", or not UTF-8";
    if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7F) return "";
    return std::string(": unexpected '") + c + "'";
  }

  bool add_number(double number) {
    const bool expected = field_ != nullptr && depth_ == array_depth(field_->type) &&
                          field_->type != FieldType::kText && field_->type != FieldType::kObject &&
                          field_->type != FieldType::kObjects;
    if (!expected) wrong_type("a number");
    count_towards_limit();
    value().table.numbers.push_back(number);
    if (depth_ == 0) complete_field();
    return true;
  }

  void complete_field() {
    const Field& field = *field_;
    field_ = nullptr;
    const bool scalar = field.type == FieldType::kText || field.type == FieldType::kNumber;
    if (!inside_ && scalar) events_.scalar(field.name, top_.value_of(field));
  }

  void count_towards_limit() {
    if (++count_ > kMaxNumbers) {
      throw input_error(origin_, path() + ": more than " + std::to_string(kMaxNumbers) + " numbers in the file");
    }
  }

  Record& current() { return inside_ ? item_ : top_; }
  Record::Value& value() { return current().value_of(*field_); }

  /// "bodies[3]" inside an item, "G_factors" inside an object, with `separator` behind; "" outside.
  std::string item_path(const char* separator) const {
    if (!inside_) return "";
    const std::string list(outer_->name);
    return (outer_->type == FieldType::kObject ? list : list + "[" + std::to_string(items_) + "]") + separator;
  }

  std::string path() const { return item_path(".") + std::string(field_->name); }

  /// The path with row and entry: what is being read now.
  std::string where() {
    std::string result = path();
    const NumberTable& table = value().table;
    if (field_->type == FieldType::kObjects && depth_ == 1) return result + "[" + std::to_string(items_) + "]";
    if (field_->type == FieldType::kNumbers && depth_ == 1) {
      return result + "[" + std::to_string(table.numbers.size()) + "]";
    }
    if (field_->type != FieldType::kRows || depth_ == 0) return result;
    result += ": row " + std::to_string(table.row_ends.size());
    const std::size_t row_begin = table.row_ends.empty() ? 0 : table.row_ends.back();
    return depth_ == 1 ? result : result + ", entry " + std::to_string(table.numbers.size() - row_begin);
  }

  std::string expected_here() const {
    if (depth_ == 0) return type_name(field_->type);
    if (field_->type == FieldType::kObjects) return "an object";
    if (field_->type == FieldType::kRows && depth_ == 1) return "a list of numbers";
    return "a finite number";
  }

  [[noreturn]] void wrong_type(const std::string& found) {
    if (field_ == nullptr) throw input_error(origin_, "expected an object, found " + found);
    throw input_error(origin_, where() + ": expected " + expected_here() + ", found " + found);
  }

  std::string_view text_;
  const std::string& origin_;
  const DocumentEvents& events_;
  Record top_;
  Record item_;                   ///< the object inside the outermost one that is being read
  const Field* field_ = nullptr;  ///< whose value is being read
  const Field* outer_ = nullptr;  ///< the field that item_ belongs to
  bool started_ = false;
  bool inside_ = false;    ///< item_ is being read
  int depth_ = 0;          ///< open lists of the field
  std::size_t items_ = 0;  ///< complete objects of the kObjects field
  std::size_t count_ = 0;  ///< numbers, rows and items of the document
};

}  // namespace

const Field* Record::find(std::string_view name) const {
  const auto it = std::find_if(fields_.begin(), fields_.end(), [&](const Field& field) { return field.name == name; });
  return it == fields_.end() ? nullptr : &*it;
}

std::size_t Record::index_of(std::string_view name) const {
  const Field* field = find(name);
  if (field == nullptr) throw std::logic_error("no such field: " + std::string(name));
  return static_cast<std::size_t>(field - fields_.data());
}

void Record::clear() {
  for (Value& value : values_) {
    value.given = false;
    value.text.clear();
    value.table.numbers.clear();
    value.table.row_ends.clear();
    value.object.clear();
  }
}

std::string line_and_column(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, offset);
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t line_begin = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - line_begin + 1);
}

Record parse_json_document(std::string_view text, const std::string& origin, std::span<const Field> fields,
                           const DocumentEvents& events) {
  check_tokens(text, origin);
  DocumentHandler handler(text, origin, fields, events);
  nlohmann::json::sax_parse(text.data(), text.data() + text.size(), &handler);
  return handler.take();
}

}  // namespace lcpbench
