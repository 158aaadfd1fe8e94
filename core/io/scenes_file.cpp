#include "core/io/scenes_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <mutex>
#include <utility>

#include "core/io/json_document.h"
#include "core/io/line_stream.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_record.h"
#include "core/io/record_reader.h"

namespace lcpbench {
namespace {

constexpr std::string_view kFormat = "lcpbench-scenes";
constexpr std::string_view kExtension = ".scenes";

/// Most steps of a file: their index takes 40 bytes each.
constexpr std::size_t kMaxSteps = std::size_t{1} << 22;

constexpr std::size_t kMaxBlankLines = 1000;

/// A step's number stands among the first bytes of its line.
constexpr std::uint64_t kNumberBytes = 64;

constexpr std::array<Field, 3> kShapeFields{
    {{"body", FieldType::kNumber}, {"type", FieldType::kText}, {"size", FieldType::kNumbers}}};

constexpr std::array<Field, 9> kHeaderFields{{{"format", FieldType::kText},
                                              {"version", FieldType::kNumber},
                                              {"scene", FieldType::kText},
                                              {"engine", FieldType::kText},
                                              {"engine_version", FieldType::kText},
                                              {"loop", FieldType::kText},
                                              {"step_length", FieldType::kNumber},
                                              {"gravity", FieldType::kNumbers},
                                              {"shapes", FieldType::kObjects, kShapeFields}}};

constexpr std::array<Field, 2> kEngineFields{{{"impulses", FieldType::kNumbers}, {"velocity", FieldType::kNumbers}}};

const std::array<Field, 7>& step_fields() {
  static const std::array<Field, 7> fields{{{"step", FieldType::kNumber},
                                            {"time", FieldType::kNumber},
                                            {"problem", FieldType::kObject, problem_fields()},
                                            {"gap", FieldType::kNumbers},
                                            {"contact_ids", FieldType::kTexts},
                                            {"poses", FieldType::kRows},
                                            {"engine", FieldType::kObject, kEngineFields}}};
  return fields;
}

std::string line_of(const std::string& origin, std::size_t number) {
  return origin + ": line " + std::to_string(number);
}

std::string text_or_empty(const RecordReader& reader, std::string_view field) {
  return reader.given(field) ? reader.text(field) : "";
}

ScenesHeader parse_header(const std::string& text, const std::string& origin) {
  ScenesHeader header;
  DocumentEvents events;
  events.one_line = true;
  events.item = [&](std::string_view, const std::string& path, const Record& item) {
    const RecordReader reader(item, origin, path);
    header.shapes.push_back({reader.integer("body"), reader.text("type"), reader.table("size").numbers});
  };
  const Record record = parse_json_document(text, origin, kHeaderFields, events);
  const RecordReader reader(record, origin);
  if (reader.text("format") != kFormat) {
    reader.fail("format", ": " + in_quotes(reader.text("format")) + ", expected '" + std::string(kFormat) + "'");
  }
  if (reader.number("version") != 1) {
    reader.fail("version",
                ": " + format_real(reader.number("version")) + " is not known; this program reads version 1");
  }
  header.scene = reader.text("scene");
  header.engine = text_or_empty(reader, "engine");
  header.engine_version = text_or_empty(reader, "engine_version");
  header.loop = text_or_empty(reader, "loop");
  if (reader.given("step_length")) header.step_length = reader.number("step_length");
  if (reader.given("gravity")) {
    const Eigen::Vector3d gravity = reader.vector3("gravity");
    header.gravity.assign(gravity.begin(), gravity.end());
  }
  return header;
}

/// {"step": NUMBER at the beginning of a line, so that steps are found without parsing the lines.
std::optional<std::int64_t> leading_step(std::string_view line) {
  const auto skip = [&](std::string_view word) {
    line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
    if (!line.starts_with(word)) return false;
    line.remove_prefix(word.size());
    return true;
  };
  if (!skip("{") || !skip("\"step\"") || !skip(":") || !skip("")) return std::nullopt;
  std::int64_t step = 0;
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), step);
  const bool ended =
      end != line.data() + line.size() && std::string_view(", \t\r}").find(*end) != std::string_view::npos;
  constexpr std::int64_t kLargest = std::int64_t{1} << 53;
  if (error != std::errc{} || !ended || step < 0 || step > kLargest) return std::nullopt;
  return step;
}

/// Whether a line without an end is a whole object nevertheless.
bool closed_object(std::string_view line) {
  std::int64_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') in_string = !in_string;
    if (in_string && line[i] == '\\') ++i;
    if (in_string) continue;
    if (line[i] == '{') ++depth;
    if (line[i] == '}' && --depth == 0) return true;
  }
  return false;
}

void check_entries(std::size_t size, Index expected, const char* field, const std::string& origin) {
  if (static_cast<Index>(size) == expected) return;
  throw input_error(origin, std::string(field) + ": " + count_of(static_cast<Index>(size), "entry") + ", expected " +
                                std::to_string(expected));
}

void read_extras(const RecordReader& reader, const std::string& origin, SceneStep& step) {
  const ContactProblem& contact = *step.problem.contact();
  if (reader.given("gap")) {
    step.gap = reader.table("gap").numbers;
    check_entries(step.gap.size(), contact.nc(), "gap", origin);
  }
  if (reader.given("contact_ids")) {
    step.contact_ids = reader.texts("contact_ids");
    check_entries(step.contact_ids.size(), contact.nc(), "contact_ids", origin);
  }
  if (reader.given("poses")) {
    const NumberTable& table = reader.table("poses");
    for (std::size_t row = 0; row < table.row_ends.size(); ++row) {
      const std::size_t length = table.row_length(row);
      if (length != 0) check_entries(length, 7, ("poses[" + std::to_string(row) + "]").c_str(), origin);
      const double* end = table.numbers.data() + table.row_ends[row];
      step.poses.emplace_back(end - length, end);
    }
  }
  if (!reader.given("engine")) return;
  const RecordReader engine = reader.inside("engine");
  if (engine.given("impulses")) {
    step.engine_impulses = engine.vector("impulses");
    check_entries(static_cast<std::size_t>(step.engine_impulses.size()), contact.nc() + cols(contact.D),
                  "engine.impulses", origin);
    step.problem = step.problem.with_engine_impulses(step.engine_impulses);
  }
  if (engine.given("velocity")) {
    step.engine_velocity = engine.vector("velocity");
    check_entries(static_cast<std::size_t>(step.engine_velocity.size()), contact.ngc(), "engine.velocity", origin);
  }
}

SceneStep parse_step(std::string_view text, const std::string& origin) {
  ProblemParts parts;
  DocumentEvents events;
  events.one_line = true;
  events.item = [&](std::string_view list, const std::string& path, const Record& item) {
    parts.add(list, path, item, origin);
  };
  const Record record = parse_json_document(text, origin, step_fields(), events);
  const RecordReader reader(record, origin);
  SceneStep step;
  step.step = static_cast<std::int64_t>(reader.number("step"));
  if (reader.given("time")) step.time = reader.number("time");
  if (!reader.given("problem")) reader.fail("problem", ": missing");
  step.problem = parts.finish(record.value("problem").object.front(), origin + ": problem");
  if (step.problem.contact() == nullptr) {
    throw input_error(origin, "problem: kind: 'lcp', expected 'contact' or 'scene': a step has contacts");
  }
  read_extras(reader, origin, step);
  return step;
}

}  // namespace

struct ScenesFile::Data {
  struct Entry {
    std::int64_t step;
    LinePlace place;
  };

  Data(LineStream opened, std::string name) : stream(std::move(opened)), origin(std::move(name)) {
    LineStream::Line line;
    if (!stream.next(line)) throw input_error(origin, "empty file");
    if (!line.ended && !closed_object(stream.text())) {
      throw input_error(origin, stream.text().starts_with('{') ? "truncated in its first line" : "not a scenes file");
    }
    header = parse_header(stream.text(), line_of(origin, 1));
    std::size_t blank = 0;  // lines at the end, as editors leave them
    while (stream.next(line, kNumberBytes)) {
      if (line.size <= kNumberBytes && stream.text().find_first_not_of(" \t\r") == std::string::npos) {
        if (++blank > kMaxBlankLines) {
          throw input_error(origin, "more than " + std::to_string(kMaxBlankLines) + " blank lines at its end");
        }
        continue;
      }
      if (blank > 0) throw input_error(line_of(origin, steps.size() + 2), "blank, and behind it comes another line");
      if (!line.ended && !whole(line)) {
        truncate("the line of the next step is incomplete");
        return;
      }
      add(line);
    }
    if (stream.cut_off()) truncate("the compressed data have no end");
  }

  /// A last line without its end: a capture that was killed, or an editor that leaves the line end out.
  bool whole(const LineStream::Line& line) {
    stream.seek(line.place);
    LineStream::Line again;
    return stream.next(again) && closed_object(stream.text());
  }

  void add(const LineStream::Line& line) {
    const std::string where = line_of(origin, steps.size() + 2);
    const std::optional<std::int64_t> step = leading_step(stream.text());
    if (!step) throw input_error(where, "does not begin with {\"step\": NUMBER");
    if (!steps.empty() && *step <= steps.back().step) {
      throw input_error(where, "step " + std::to_string(*step) + " behind step " + std::to_string(steps.back().step) +
                                   ": steps ascend");
    }
    if (steps.size() == kMaxSteps) throw input_error(where, "more than " + std::to_string(kMaxSteps) + " steps");
    steps.push_back({*step, line.place});
  }

  void truncate(const std::string& cause) {
    truncation = origin + ": truncated, as a capture that was stopped leaves it: " + cause + "; " +
                 count_of(static_cast<Index>(steps.size()), "complete step") + " can be read";
  }

  std::string line(std::size_t index) {
    const std::lock_guard lock(mutex);
    stream.seek(steps[index].place);
    LineStream::Line found;
    if (!stream.next(found)) throw input_error(origin, "has changed while it was read");
    return stream.text();
  }

  LineStream stream;
  std::string origin;
  std::mutex mutex;  ///< of stream
  ScenesHeader header;
  std::vector<Entry> steps;
  std::string truncation;
};

ScenesFile::ScenesFile(const std::string& file) : data_(std::make_unique<Data>(LineStream(file), file)) {}
ScenesFile::ScenesFile(std::string_view bytes, const std::string& origin)
    : data_(std::make_unique<Data>(LineStream(bytes, origin), origin)) {}
ScenesFile::~ScenesFile() = default;

const ScenesHeader& ScenesFile::header() const { return data_->header; }
std::size_t ScenesFile::count() const { return data_->steps.size(); }
std::int64_t ScenesFile::step_number(std::size_t index) const { return data_->steps[index].step; }
std::string ScenesFile::line(std::size_t index) const { return data_->line(index); }
const std::string& ScenesFile::truncation() const { return data_->truncation; }

std::size_t ScenesFile::index_of(std::int64_t step) const {
  const auto& steps = data_->steps;
  const auto found =
      std::lower_bound(steps.begin(), steps.end(), step,
                       [](const Data::Entry& entry, std::int64_t number) { return entry.step < number; });
  if (found != steps.end() && found->step == step) return static_cast<std::size_t>(found - steps.begin());
  std::string near;
  if (found != steps.begin()) near += "; the one before is " + std::to_string((found - 1)->step);
  if (found != steps.end()) near += "; the next one is " + std::to_string(found->step);
  throw input_error(data_->origin, "has no step " + std::to_string(step) + near);
}

SceneStep ScenesFile::read(std::size_t index) const {
  return parse_step(data_->line(index), line_of(data_->origin, index + 2));
}

bool is_scenes_file(std::string_view name) { return name.size() > kExtension.size() && name.ends_with(kExtension); }

std::optional<std::pair<std::string, std::int64_t>> scenes_step(const std::string& name) {
  const std::size_t mark = name.rfind('#');
  if (mark == std::string::npos || !is_scenes_file(std::string_view(name).substr(0, mark))) return std::nullopt;
  const std::string number = name.substr(mark + 1);
  std::int64_t step = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), step);
  if (error != std::errc{} || end != number.data() + number.size() || step < 0) {
    throw InputError(name + ": " + in_quotes(number) + " is not the number of a step");
  }
  return std::pair{name.substr(0, mark), step};
}

}  // namespace lcpbench
