#include "core/io/json_document.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <utility>

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

/// Where in the text an error is.
std::string position(std::string_view text, std::size_t offset, bool one_line) {
  return one_line ? "column " + std::to_string(offset + 1) : line_and_column(text, offset);
}

/// Refuses what would make the parser hold an unbounded token, and binary files, in one pass over the bytes.
void check_tokens(std::string_view text, const std::string& origin, bool one_line) {
  bool in_string = false;
  std::size_t length = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\0') throw input_error(origin, position(text, i, one_line) + ": a NUL byte: not a text file");
    if (!in_string && is_boundary(c)) {
      length = 0;
      continue;
    }
    if (++length > kMaxTokenBytes) {
      throw input_error(origin, position(text, i, one_line) + ": a number or text longer than " +
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
    case FieldType::kBlocks: return "a list of matrices";
    case FieldType::kTexts: return "a list of texts";
    case FieldType::kObject: return "an object";
    case FieldType::kObjects: return "a list of objects";
  }
  return "nothing";
}

/// nlohmann-json's event interface. Throws through the parser, which holds nothing that needs it to return.
class DocumentHandler {
 public:
  using Json = nlohmann::json;

  DocumentHandler(std::string_view text, const std::string& origin, std::span<const Field> fields,
                  const DocumentEvents& events)
      : text_(text), origin_(origin), events_(events) {
    frames_.push_back({Record(fields)});
  }

  Record take() { return std::move(frames_.front().record); }

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
    const Frame& in = frame();
    if (in.field != nullptr && in.field->type == FieldType::kTexts && in.depth == 1) {
      count_towards_limit();
      value().texts.push_back(std::move(text));
      return true;
    }
    if (in.field == nullptr || in.field->type != FieldType::kText) wrong_type("a text");
    value().text = std::move(text);
    complete_field();
    return true;
  }

  bool start_object(std::size_t) {
    if (!started_) {
      started_ = true;
      return true;
    }
    if (!object_expected()) wrong_type("an object");
    count_towards_limit();
    const Field& outer = *frame().field;
    ++level_;
    if (level_ == frames_.size()) frames_.push_back({});
    Frame& inner = frame();
    if (inner.record.fields().data() != outer.inside.data()) inner.record = Record(outer.inside);
    inner.record.clear();
    inner.field = nullptr;
    inner.depth = 0;
    return true;
  }

  bool key(Json::string_t& name) {
    Frame& in = frame();
    in.field = in.record.find(name);
    if (in.field == nullptr) throw input_error(origin_, outer_path(": ") + "unknown field " + in_quotes(name));
    if (value().given) throw input_error(origin_, path() + ": given twice");
    value().given = true;
    return true;
  }

  bool end_object() {
    if (level_ == 0) return true;
    Record& item = frame().record;
    Frame& outer = frames_[level_ - 1];
    if (outer.field->type == FieldType::kObjects) {
      events_.item(outer.field->name, outer_path("."), item);
      --level_;
      ++outer.items;
    } else {
      --level_;
      value().object.push_back(std::exchange(item, Record()));
      complete_field();
    }
    return true;
  }

  bool start_array(std::size_t) {
    Frame& in = frame();
    if (in.field == nullptr || in.depth >= array_depth(in.field->type)) wrong_type("a list");
    ++in.depth;
    return true;
  }

  bool end_array() {
    Frame& in = frame();
    --in.depth;
    const int lists = array_depth(in.field->type);
    if (lists >= 2 && in.depth == lists - 1) {
      count_towards_limit();
      value().table.row_ends.push_back(value().table.numbers.size());
    }
    if (lists == 3 && in.depth == 1) {
      count_towards_limit();
      value().table.block_ends.push_back(value().table.row_ends.size());
    }
    if (in.depth == 0) {
      in.items = 0;
      complete_field();
    }
    return true;
  }

  bool parse_error(std::size_t after, const std::string& token, const nlohmann::detail::exception& error) {
    constexpr int kNumberOverflow = 406;
    const Field* field = frame().field;
    if (error.id == kNumberOverflow) {
      if (field == nullptr) wrong_type("a number");
      throw input_error(origin_, where() + ": " + in_quotes(token) + " is beyond the range of double");
    }
    const std::string inside = field == nullptr ? "" : " (in " + where() + ")";
    if (text_.empty()) throw input_error(origin_, "empty file");
    if (after > text_.size()) {
      throw input_error(origin_, std::string("truncated: the ") + (events_.one_line ? "line" : "file") + " ends at " +
                                     position(text_, text_.size(), events_.one_line) + inside);
    }
    const std::size_t last = after == 0 ? 0 : after - 1;
    throw input_error(origin_,
                      position(text_, last, events_.one_line) + ": not valid JSON" + describe(text_[last]) + inside);
  }

 private:
  /// An object that is being read: the outermost one, or one inside the field of the frame before.
  struct Frame {
    Record record;
    const Field* field = nullptr;  ///< whose value is being read
    int depth = 0;                 ///< open lists of the field
    std::size_t items = 0;         ///< complete objects of the kObjects field
  };

  static int array_depth(FieldType type) {
    switch (type) {
      case FieldType::kNumbers:
      case FieldType::kTexts:
      case FieldType::kObjects: return 1;
      case FieldType::kRows: return 2;
      case FieldType::kBlocks: return 3;
      default: return 0;
    }
  }

  static bool holds_numbers(FieldType type) {
    return type == FieldType::kNumber || type == FieldType::kNumbers || type == FieldType::kRows ||
           type == FieldType::kBlocks;
  }

  static std::string describe(char c) {
    if (static_cast<unsigned char>(c) >= 0x80) return ", or not UTF-8";
    if (static_cast<unsigned char>(c) <= 0x20 || c == 0x7F) return "";
    return std::string(": unexpected '") + c + "'";
  }

  bool object_expected() const {
    const Frame& in = frames_[level_];
    if (in.field == nullptr) return false;
    if (in.field->type == FieldType::kObjects) return in.depth == 1;
    return in.depth == 0 && !in.field->inside.empty();
  }

  bool add_number(double number) {
    const Frame& in = frame();
    const bool expected =
        in.field != nullptr && in.depth == array_depth(in.field->type) && holds_numbers(in.field->type);
    if (!expected) wrong_type("a number");
    count_towards_limit();
    value().table.numbers.push_back(number);
    if (in.depth == 0) complete_field();
    return true;
  }

  void complete_field() {
    const Field& field = *frame().field;
    frame().field = nullptr;
    const bool scalar = field.type == FieldType::kText || field.type == FieldType::kNumber;
    if (level_ == 0 && scalar && events_.scalar) events_.scalar(field.name, frame().record.value_of(field));
  }

  void count_towards_limit() {
    if (++count_ > kMaxNumbers) {
      throw input_error(origin_, path() + ": more than " + std::to_string(kMaxNumbers) + " numbers in the file");
    }
  }

  Frame& frame() { return frames_[level_]; }
  Record::Value& value() { return frame().record.value_of(*frame().field); }

  /// "bodies[3]" inside an item, "G_factors" inside an object, with `separator` behind; "" outside.
  std::string outer_path(const char* separator) const {
    std::string result;
    for (std::size_t level = 0; level < level_; ++level) {
      const Frame& outer = frames_[level];
      result += outer.field->name;
      if (outer.field->type == FieldType::kObjects) result += "[" + std::to_string(outer.items) + "]";
      result += level + 1 == level_ ? separator : ".";
    }
    return result;
  }

  std::string path() { return outer_path(".") + std::string(frame().field->name); }

  /// The path with row and entry: what is being read now.
  std::string where() {
    std::string result = path();
    const Frame& in = frame();
    const NumberTable& table = value().table;
    const int lists = array_depth(in.field->type);
    if (in.depth == 0) return result;
    if (lists == 1) {
      const std::size_t entry = in.field->type == FieldType::kObjects ? in.items
                                : in.field->type == FieldType::kTexts ? value().texts.size()
                                                                      : table.numbers.size();
      return result + "[" + std::to_string(entry) + "]";
    }
    std::size_t first_row = 0;
    if (lists == 3) {
      result += "[" + std::to_string(table.block_ends.size()) + "]";
      first_row = table.block_ends.empty() ? 0 : table.block_ends.back();
      if (in.depth == 1) return result;
    }
    result += ": row " + std::to_string(table.row_ends.size() - first_row);
    const std::size_t row_begin = table.row_ends.empty() ? 0 : table.row_ends.back();
    return in.depth < lists ? result : result + ", entry " + std::to_string(table.numbers.size() - row_begin);
  }

  std::string expected_here() {
    const Field& field = *frame().field;
    const int left = array_depth(field.type) - frame().depth;
    if (frame().depth == 0)
      return type_name(field.type) + std::string(left == 2 && !field.inside.empty() ? " or an object" : "");
    if (left == 2) return "a list of rows of numbers";
    if (left == 1) return "a list of numbers";
    if (field.type == FieldType::kObjects) return "an object";
    return field.type == FieldType::kTexts ? "a text" : "a finite number";
  }

  [[noreturn]] void wrong_type(const std::string& found) {
    if (frame().field == nullptr) throw input_error(origin_, "expected an object, found " + found);
    throw input_error(origin_, where() + ": expected " + expected_here() + ", found " + found);
  }

  std::string_view text_;
  const std::string& origin_;
  const DocumentEvents& events_;
  std::vector<Frame> frames_;  ///< from the outermost object inward; those behind level_ keep their memory
  std::size_t level_ = 0;
  bool started_ = false;
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
    value.table.block_ends.clear();
    value.texts.clear();
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
  check_tokens(text, origin, events.one_line);
  DocumentHandler handler(text, origin, fields, events);
  nlohmann::json::sax_parse(text.data(), text.data() + text.size(), &handler);
  return handler.take();
}

}  // namespace lcpbench
