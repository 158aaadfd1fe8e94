#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <new>
#include <utility>

#include <zstd.h>

#include "core/io/json_document.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/scenes_file.h"
#include "core/settings.h"
#include "core/utf8.h"

namespace lcpbench {
namespace {

/// A compressed frame ends with the line that takes its text beyond this size [bytes]. A reader that goes to a step
/// decompresses no other frame.
constexpr std::size_t kFrameBytes = std::size_t{1} << 22;

/// JSON writes null for a number that is not finite, and the reader refuses it.
void check_finite(const std::string& origin, const std::string& field, const std::vector<double>& values) {
  for (const double value : values) {
    if (std::isfinite(value)) continue;
    throw input_error(origin, field + " has " + format_real(value) + ", expected finite numbers");
  }
}

/// Refuses a header that the reader would refuse. @param origin  names the file in errors
void check_header(const ScenesHeader& header, const std::string& origin) {
  check_finite(origin, "step_length", {header.step_length.value_or(0)});
  check_finite(origin, "gravity", header.gravity);
  if (const std::size_t entries = header.gravity.size(); entries != 0 && entries != 3) {
    throw input_error(origin, "gravity: " + count_of(static_cast<Index>(entries), "entry") + ", expected 3");
  }
  const auto check_text = [&](const char* field, const std::string& text) {
    if (!is_utf8(text)) throw input_error(origin, std::string(field) + ": not UTF-8");
  };
  check_text("scene", header.scene);
  check_text("engine", header.engine);
  check_text("engine_version", header.engine_version);
  check_text("loop", header.loop);
  for (const SceneShape& shape : header.shapes) {
    check_text("shapes: type", shape.type);
    check_finite(origin, "shapes: size", shape.size);
    if (const std::string fault = shape.fault(); !fault.empty()) throw input_error(origin, "shapes: size: " + fault);
  }
}

std::string header_line(const ScenesHeader& header) {
  Json json = {{"format", "lcpbench-scenes"}, {"version", 1}, {"scene", header.scene}};
  if (!header.engine.empty()) json["engine"] = header.engine;
  if (!header.engine_version.empty()) json["engine_version"] = header.engine_version;
  if (header.step_length) json["step_length"] = *header.step_length;
  if (!header.loop.empty()) json["loop"] = header.loop;
  if (!header.gravity.empty()) json["gravity"] = header.gravity;
  for (const SceneShape& shape : header.shapes) {
    json["shapes"].push_back({{"body", shape.body}, {"type", shape.type}, {"size", shape.size}});
  }
  return json.dump();
}

std::vector<double> numbers(const Vector& vector) { return {vector.begin(), vector.end()}; }

/// Refuses what the reader would refuse of a step, except for its problem, which problem_json_line() checks.
void check_extras(const SceneStep& step) {
  const std::string origin = "step " + std::to_string(step.step);
  if (step.step < 0 || step.step > kLargestStep) throw input_error(origin, "numbers are from 0 to 2^53");
  const ContactProblem* const contact = step.problem.contact();
  if (contact == nullptr) throw input_error(origin, "problem: is a bare LCP, expected one with contacts");
  const auto check_count = [&](const char* field, Index found, Index expected) {
    if (found == 0 || found == expected) return;
    throw input_error(origin, std::string(field) + ": " + count_of(found, "entry") + ", expected " +
                                  std::to_string(expected));
  };
  const auto check = [&](const char* field, const std::vector<double>& values, Index expected) {
    check_count(field, static_cast<Index>(values.size()), expected);
    check_finite(origin, field, values);
  };
  check("time", {step.time.value_or(0)}, 1);
  check("engine.solve_s", {step.engine_solve_s.value_or(0)}, 1);
  check("gap", step.gap, contact->nc());
  for (const std::vector<double>& pose : step.poses) check("poses", pose, 7);
  check_count("contact_frames", static_cast<Index>(step.contact_frames.size()), contact->nc());
  for (const std::vector<double>& frame : step.contact_frames) check("contact_frames", frame, 9);
  check("engine.impulses", numbers(step.engine_impulses), contact->nc() + cols(contact->D) + contact->rows.size());
  check("engine.velocity", numbers(step.engine_velocity), contact->ngc());
  check_count("contact_ids", static_cast<Index>(step.contact_ids.size()), contact->nc());
  for (const auto& [field, texts] : {std::pair{"contact_ids", &step.contact_ids}, std::pair{"notes", &step.notes}}) {
    if (!std::ranges::all_of(*texts, is_utf8)) throw input_error(origin, std::string(field) + ": not UTF-8");
  }
}

/// The line itself; refuses one that is too long for the reader. @param origin  names it in errors
std::string within_limit(std::string line, const std::string& origin) {
  if (line.size() <= LineStream::kMaxLineBytes) return line;
  throw input_error(origin, "a line of " + std::to_string(line.size()) + " bytes, at most " +
                                std::to_string(LineStream::kMaxLineBytes) + " are allowed");
}

}  // namespace

std::string scenes_line(const SceneStep& step) {
  check_extras(step);
  std::string line = "{\"step\":" + std::to_string(step.step);
  const auto add = [&](const char* field, const Json& value) {
    line += std::string(",\"") + field + "\":" + value.dump();
  };
  if (step.time) add("time", *step.time);
  line += ",\"problem\":" + problem_json_line(step.problem);
  if (!step.gap.empty()) add("gap", step.gap);
  if (!step.contact_ids.empty()) add("contact_ids", step.contact_ids);
  if (!step.contact_frames.empty()) add("contact_frames", step.contact_frames);
  if (!step.poses.empty()) add("poses", step.poses);
  if (!step.notes.empty()) add("notes", step.notes);
  Json engine;
  if (step.engine_impulses.size() > 0) engine["impulses"] = numbers(step.engine_impulses);
  if (step.engine_velocity.size() > 0) engine["velocity"] = numbers(step.engine_velocity);
  if (step.engine_solve_s) engine["solve_s"] = *step.engine_solve_s;
  if (!engine.is_null()) add("engine", engine);
  return within_limit(line + "}", "step " + std::to_string(step.step));
}

struct ScenesWriter::Data {
  std::string name;
  std::ofstream file;
  std::unique_ptr<ZSTD_CCtx, std::size_t (*)(ZSTD_CCtx*)> context{ZSTD_createCCtx(), ZSTD_freeCCtx};
  std::size_t in_frame = 0;
  std::int64_t last_step = -1;
  std::size_t steps = 0;

  /// Compresses the bytes and writes what zstd returns. @param how  ZSTD_e_continue: zstd may hold bytes back;
  ///     ZSTD_e_flush: it holds none; ZSTD_e_end: the frame ends, too
  void write(std::string_view bytes, ZSTD_EndDirective how) {
    ZSTD_inBuffer input{bytes.data(), bytes.size(), 0};
    std::array<char, 1 << 16> buffer;
    std::size_t left = 1;
    while (left != 0 || input.pos < input.size) {
      ZSTD_outBuffer output{buffer.data(), buffer.size(), 0};
      left = ZSTD_compressStream2(context.get(), &output, &input, how);
      if (ZSTD_isError(left)) throw input_error(name, std::string("cannot be compressed: ") + ZSTD_getErrorName(left));
      file.write(buffer.data(), static_cast<std::streamsize>(output.pos));
      if (how == ZSTD_e_continue) left = 0;
    }
    check();
  }

  void check() {
    if (file) return;
    throw input_error(name, std::string("cannot be written: ") + (errno != 0 ? std::strerror(errno) : "unknown cause"));
  }
};

ScenesWriter::ScenesWriter(const std::string& file, const ScenesHeader& header, int level)
    : data_(std::make_unique<Data>()) {
  check_header(header, file);
  const std::string first_line = within_limit(header_line(header), file);  // before an existing file is lost
  data_->name = file;
  if (!data_->context) throw std::bad_alloc();
  errno = 0;
  data_->file.open(file, std::ios::binary | std::ios::trunc);
  data_->check();
  ZSTD_CCtx_setParameter(data_->context.get(), ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setParameter(data_->context.get(), ZSTD_c_checksumFlag, 1);
  add_line(first_line);
}

ScenesWriter::~ScenesWriter() = default;

void ScenesWriter::add(const SceneStep& step) {
  if (step.step <= data_->last_step) {
    throw input_error(data_->name, "step " + std::to_string(step.step) + ": numbers start at 0 and ascend");
  }
  if (data_->steps == kMostSteps) {
    throw input_error(data_->name, "holds " + std::to_string(kMostSteps) + " steps, the most that a file can have");
  }
  add_line(scenes_line(step));
  data_->last_step = step.step;
  ++data_->steps;
}

void ScenesWriter::add_line(std::string_view line) {
  data_->write(line, ZSTD_e_continue);
  data_->in_frame += line.size();
  const bool ends = data_->in_frame > kFrameBytes;
  data_->write("\n", ends ? ZSTD_e_end : ZSTD_e_flush);
  if (ends) data_->in_frame = 0;
  data_->file.flush();
  data_->check();
}

void ScenesWriter::close() {
  if (data_->in_frame > 0) data_->write("", ZSTD_e_end);
  data_->file.close();
  data_->check();
}

}  // namespace lcpbench
