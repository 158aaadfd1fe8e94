#include "core/io/scenes_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"

namespace lcpbench {
namespace {

constexpr std::string_view kExtension = ".scenes";

constexpr std::size_t kMaxBlankLines = 1000;

/// A step's number stands among the first bytes of its line.
constexpr std::uint64_t kNumberBytes = 64;

std::string line_of(const std::string& origin, std::size_t number) {
  return origin + ": line " + std::to_string(number);
}

std::vector<double> entries(const Vector& numbers) { return {numbers.begin(), numbers.end()}; }

std::string text_or_empty(const JsonObject& reader, std::string_view field) {
  return reader.given(field) ? reader.text(field) : "";
}

ScenesHeader parse_header(const std::string& text, const std::string& origin) {
  ScenesHeader header;
  const Json document = parse_json_document(text, origin, true);
  const JsonObject reader(document, origin);
  reader.check_format("lcpbench-scenes");
  reader.only({"format", "version", "scene", "engine", "engine_version", "loop", "step_length", "gravity", "shapes"});
  header.scene = reader.text("scene");
  header.engine = text_or_empty(reader, "engine");
  header.engine_version = text_or_empty(reader, "engine_version");
  header.loop = text_or_empty(reader, "loop");
  if (reader.given("step_length")) header.step_length = reader.number("step_length");
  if (reader.given("gravity")) header.gravity = entries(reader.vector("gravity", 3));
  if (!reader.given("shapes")) return header;
  for (const JsonObject& shape : reader.objects("shapes")) {
    shape.only({"body", "type", "size"});
    header.shapes.push_back({shape.integer("body"), shape.text("type"), entries(shape.vector("size"))});
    if (const std::string fault = header.shapes.back().fault(); !fault.empty()) shape.fail("size", ": " + fault);
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
  if (error != std::errc{} || !ended || step < 0 || step > kLargestStep) return std::nullopt;
  return step;
}

void read_extras(const JsonObject& reader, SceneStep& step) {
  const ContactProblem& contact = *step.problem.contact();
  if (reader.given("gap")) step.gap = entries(reader.vector("gap", contact.nc()));
  if (reader.given("contact_ids")) {
    step.contact_ids = reader.texts("contact_ids");
    const auto found = static_cast<Index>(step.contact_ids.size());
    if (found != contact.nc()) {
      reader.fail("contact_ids", ": " + count_of(found, "entry") + ", expected " + std::to_string(contact.nc()));
    }
  }
  const auto read_rows = [&](const char* field, Index size, std::vector<std::vector<double>>& rows) {
    if (!reader.given(field)) return;
    for (const Vector& row : reader.rows(field)) {
      if (row.size() != 0 && row.size() != size) {
        reader.fail(std::string(field) + "[" + std::to_string(rows.size()) + "]",
                    ": " + count_of(row.size(), "entry") + ", expected " + std::to_string(size));
      }
      rows.push_back(entries(row));
    }
  };
  read_rows("poses", 7, step.poses);
  read_rows("contact_frames", 9, step.contact_frames);
  if (const auto found = static_cast<Index>(step.contact_frames.size()); found != 0 && found != contact.nc()) {
    reader.fail("contact_frames", ": " + count_of(found, "entry") + ", expected " + std::to_string(contact.nc()));
  }
  if (reader.given("notes")) step.notes = reader.texts("notes");
  if (!reader.given("engine")) return;
  const JsonObject engine = reader.inside("engine");
  engine.only({"impulses", "velocity", "solve_s"});
  if (engine.given("impulses")) {
    step.engine_impulses = engine.vector("impulses", contact.nc() + cols(contact.D) + contact.rows.size());
  }
  if (engine.given("solve_s")) {
    step.engine_solve_s = engine.number("solve_s");
    if (!(*step.engine_solve_s >= 0)) engine.fail("solve_s", ": is negative");
  }
  if (engine.given("velocity")) step.engine_velocity = engine.vector("velocity", contact.ngc());
}

SceneStep parse_step(std::string_view text, const std::string& origin) {
  const Json document = parse_json_document(text, origin, true);
  const JsonObject reader(document, origin);
  reader.only({"step", "time", "problem", "gap", "contact_ids", "contact_frames", "poses", "engine", "notes"});
  SceneStep step;
  step.step = static_cast<std::int64_t>(reader.number("step"));
  if (reader.given("time")) step.time = reader.number("time");
  if (!reader.given("problem")) reader.fail("problem", ": missing");
  step.problem = problem_of_json(document.at("problem"), origin + ": problem");
  if (step.problem.contact() == nullptr) {
    throw input_error(origin, "problem: kind: 'lcp', expected 'contact' or 'scene': a step has contacts");
  }
  read_extras(reader, step);
  return step;
}

}  // namespace

std::string SceneShape::fault() const {
  constexpr std::size_t kMostCorners = 256;
  if (type != "hull" || (size.size() % 3 == 0 && size.size() / 3 >= 4 && size.size() / 3 <= kMostCorners)) return "";
  return count_of(static_cast<Index>(size.size()), "entry") + ", expected three for each of 4 to " +
         std::to_string(kMostCorners) + " corners of the hull";
}

ScenesFile::ScenesFile(LineStream stream, const std::string& origin) : stream_(std::move(stream)), origin_(origin) {
  LineStream::Line line;
  if (!stream_.next(line)) throw input_error(origin, "empty file");
  // An object with an error in it is left to the parser, which names the error.
  if (!line.ended && !Json::accept(stream_.text()) && !stream_.text().ends_with('}')) {
    throw input_error(origin, stream_.text().starts_with('{') ? "truncated in its first line" : "not a scenes file");
  }
  header_ = parse_header(stream_.text(), line_of(origin, 1));
  std::size_t blank = 0;  // lines at the end, as editors leave them
  while (stream_.next(line, kNumberBytes)) {
    if (line.size <= kNumberBytes && stream_.text().find_first_not_of(" \t\r") == std::string::npos) {
      if (++blank > kMaxBlankLines) {
        throw input_error(origin, "more than " + std::to_string(kMaxBlankLines) + " blank lines at its end");
      }
      continue;
    }
    if (blank > 0) throw input_error(line_of(origin, steps_.size() + 2), "blank, and behind it comes another line");
    if (!line.ended && !is_whole(line)) {
      truncate("the line of the next step is incomplete");
      return;
    }
    add(line);
  }
  if (stream_.cut_off()) truncate("the compressed data have no end");
}

/// A last line without its end: a capture that was killed, or an editor that leaves the line end out.
bool ScenesFile::is_whole(const LineStream::Line& line) {
  stream_.seek(line.place);
  LineStream::Line again;
  return stream_.next(again) && Json::accept(stream_.text());
}

void ScenesFile::add(const LineStream::Line& line) {
  const std::string where = line_of(origin_, steps_.size() + 2);
  const std::optional<std::int64_t> step = leading_step(stream_.text());
  if (!step) throw input_error(where, "does not begin with {\"step\": NUMBER");
  if (!steps_.empty() && *step <= steps_.back().step) {
    throw input_error(where, "step " + std::to_string(*step) + " behind step " + std::to_string(steps_.back().step) +
                                 ": steps ascend");
  }
  if (steps_.size() == kMostSteps) throw input_error(where, "more than " + std::to_string(kMostSteps) + " steps");
  steps_.push_back({*step, line.place});
}

void ScenesFile::truncate(const std::string& cause) {
  truncation_ = origin_ + ": truncated, as a capture that was stopped leaves it: " + cause + "; " +
                count_of(static_cast<Index>(steps_.size()), "complete step") + " can be read";
}

std::string ScenesFile::line(std::size_t index) const {
  const std::lock_guard lock(mutex_);
  stream_.seek(steps_[index].place);
  LineStream::Line found;
  if (!stream_.next(found)) throw input_error(origin_, "has changed while it was read");
  return stream_.text();
}

std::size_t ScenesFile::index_of(std::int64_t step) const {
  const auto found = std::lower_bound(steps_.begin(), steps_.end(), step,
                                      [](const Entry& entry, std::int64_t number) { return entry.step < number; });
  if (found != steps_.end() && found->step == step) return static_cast<std::size_t>(found - steps_.begin());
  std::string near;
  if (found != steps_.begin()) near += "; the one before is " + std::to_string((found - 1)->step);
  if (found != steps_.end()) near += "; the next one is " + std::to_string(found->step);
  throw input_error(origin_, "has no step " + std::to_string(step) + near);
}

SceneStep ScenesFile::read(std::size_t index) const {
  SceneStep step = parse_step(line(index), line_of(origin_, index + 2));
  if (step.engine_impulses.size() > 0) {
    step.problem = step.problem.with_engine_answer(
        {step.engine_impulses, step.engine_solve_s.value_or(std::numeric_limits<double>::quiet_NaN()),
         header_.engine_label()});
  }
  return step;
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
