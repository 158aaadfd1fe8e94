#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lcpbench {

/// The required content of one field of a JSON object.
enum class FieldType {
  kText,
  kNumber,
  kNumbers,  ///< [1, 2]
  kRows,     ///< [[1, 2], [3]]; equal lengths are the reader's concern
  kBlocks,   ///< [[[1, 2], [3, 4]], [[5]]]: a list of kRows
  kTexts,    ///< ["a", "b"]
  kObject,
  kObjects,  ///< [{...}, {...}]
};

/// One known field. A document type is a list of these, written down once.
struct Field {
  std::string_view name;
  FieldType type = FieldType::kText;
  std::span<const Field> inside = {};  ///< of kObject and kObjects; of kRows, an object that may stand in their place
};

/// The numbers of a kNumber (one), kNumbers, kRows or kBlocks field, row after row.
struct NumberTable {
  std::vector<double> numbers;
  std::vector<std::size_t> row_ends;    ///< kRows, kBlocks: where in `numbers` each row ends
  std::vector<std::size_t> block_ends;  ///< kBlocks: where in `row_ends` each block ends

  std::size_t row_length(std::size_t row) const { return row_ends[row] - (row == 0 ? 0 : row_ends[row - 1]); }
};

/// One JSON object, its fields by name. Asking for a name that is not among its fields is a defect.
class Record {
 public:
  Record() = default;
  explicit Record(std::span<const Field> fields) : fields_(fields), values_(fields.size()) {}

  struct Value {
    bool given = false;
    std::string text;
    NumberTable table;
    std::vector<std::string> texts;  ///< kTexts
    std::vector<Record> object;      ///< kObject, and kRows given as an object: one record
  };

  std::span<const Field> fields() const { return fields_; }
  bool given(std::string_view name) const { return value(name).given; }
  const Value& value(std::string_view name) const { return values_[index_of(name)]; }
  /// nullptr when the object has no such field.
  const Field* find(std::string_view name) const;
  Value& value_of(const Field& field) { return values_[static_cast<std::size_t>(&field - fields_.data())]; }
  /// Forgets the values, keeps their memory.
  void clear();

 private:
  std::size_t index_of(std::string_view name) const;
  std::span<const Field> fields_;
  std::vector<Value> values_;
};

/// Callbacks to the reader of a document while it is parsed. Each may throw InputError.
struct DocumentEvents {
  /// A kText or kNumber field of the outermost object is complete.
  std::function<void(std::string_view field, const Record::Value& value)> scalar;
  /// An object of the kObjects field `list` is complete; its place is `path` ("bodies[3]."). Items are not kept.
  std::function<void(std::string_view list, const std::string& path, const Record& item)> item;
  bool one_line = false;  ///< the text is one line of a file; the origin names it, and errors name columns
};

/// Parses a JSON document that is one object with the given fields.
///
/// Memory is bounded by the text's size and by kMaxNumbers numbers, rows and items; nesting beyond what the fields ask
/// for, and tokens above 4 KiB, are refused as they appear. Numbers are correctly rounded; -0 keeps its sign.
/// @throws InputError naming the field, entry, and for broken JSON line and column; an unknown or repeated field, a
///         value of the wrong type, a number that overflows.
Record parse_json_document(std::string_view text, const std::string& origin, std::span<const Field> fields,
                           const DocumentEvents& events);

/// "line 3, column 14" of a byte offset, both counted from 1, columns in bytes.
std::string line_and_column(std::string_view text, std::size_t offset);

}  // namespace lcpbench
