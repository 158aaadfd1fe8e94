#include "adapters/external/external_json.h"

#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/io/problem_io.h"

namespace lcpbench::external {
namespace {

using Json = nlohmann::ordered_json;
using worker::BadMessage;

/// A number, its separator and some white space.
constexpr std::size_t kBytesPerNumber = 64;
constexpr std::size_t kBytesBesides = 1 << 16;

Json parse_object(const std::string& text) {
  std::set<std::string> fields;
  std::string twice;
  const auto look = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (event != Json::parse_event_t::key || depth != 1) return true;
    const auto field = parsed.get<std::string>();
    if (!fields.insert(field).second && twice.empty()) twice = field;
    return true;
  };
  const Json json = Json::parse(text, look, false);
  if (!twice.empty()) throw BadMessage(twice.substr(0, 40) + ": given twice");
  if (json.is_discarded()) throw BadMessage("not JSON (NaN and Infinity are none)");
  if (!json.is_object()) throw BadMessage(std::string("expected an object, found ") + json.type_name());
  return json;
}

Vector parse_vector(const Json& json, const char* field, Index expected) {
  if (!json.is_array()) throw BadMessage(std::string(field) + ": expected a list, found " + json.type_name());
  if (static_cast<Index>(json.size()) != expected) {
    throw BadMessage(std::string(field) + ": has " + std::to_string(json.size()) + " entries, expected " +
                    std::to_string(expected));
  }
  Vector values(expected);
  for (Index i = 0; i < expected; ++i) {
    const Json& entry = json[static_cast<std::size_t>(i)];
    const double value = entry.is_number() ? entry.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(value)) throw BadMessage(std::string(field) + "[" + std::to_string(i) + "]: not a number");
    values(i) = value;
  }
  return values;
}

std::string parse_text(const Json& json, const char* field) {
  if (!json.is_string()) throw BadMessage(std::string(field) + ": expected a text, found " + json.type_name());
  return json.get<std::string>();
}

std::int64_t parse_counter(const Json& json, const char* field) {
  const bool fits = json.is_number_unsigned() && json.get<std::uint64_t>() <= std::uint64_t{1} << 53;
  if (!fits) throw BadMessage(std::string(field) + ": expected an integer in [0, 2^53]");
  return json.get<std::int64_t>();
}

/// The line may be late, or sent twice: then it answers another question. @throws BadMessage
void check_sequence(const Json& json, const Expected& expected) {
  const auto found = json.find("sequence");
  if (found == json.end()) return;
  if (!found->is_number()) throw BadMessage(std::string("sequence: expected a number, found ") + found->type_name());
  if (found->get<double>() == static_cast<double>(expected.sequence)) return;
  throw BadMessage("sequence is " + found->dump() + ", but the question has " + std::to_string(expected.sequence) +
                  ": a line that came late or twice");
}

/// Apart from check_sequence(), so that an answer without a number is told first what else is wrong with it.
void require_sequence(const Json& json, const Expected& expected) {
  if (!expected.required || json.contains("sequence")) return;
  throw BadMessage("sequence is missing: a program that repeats the number of \"start\" repeats every one");
}

/// The claim of a program. A program may not claim that it crashed.
Claim parse_program_claim(const Json& json) {
  const std::string text = parse_text(json, "claim");
  try {
    const Claim claim = parse_claim(text);
    if (claim != Claim::kCrashed) return claim;
  } catch (const InputError&) {
    // the error below is the same for both cases
  }
  throw BadMessage("claim: unknown: " + text.substr(0, 40));
}

}  // namespace

std::vector<std::string> command_words(std::string_view command) {
  std::vector<std::string> words;
  bool in_word = false;
  char quote = 0;
  for (const char c : command) {
    if (quote == 0 && c == ' ') {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (quote == 0 && (c == '\'' || c == '"')) {
      quote = c;
    } else if (c == quote) {
      quote = 0;
    } else {
      words.back() += c;
    }
  }
  if (quote != 0) throw InputError("external: command: an open quote in " + std::string(command));
  if (words.empty() || words.front().empty()) {
    throw InputError("external: command names no program: external{command=./mine.py}");
  }
  return words;
}

std::string start_message(int version) {
  return Json{{"verb", "start"}, {"format", "lcpbench-external"}, {"version", version}}.dump();
}

std::string problem_message(const Problem& problem) {
  return R"({"verb":"problem","problem":)" + problem_json_line(problem, true) + "}";
}

std::string setup_message() { return Json{{"verb", "setup"}}.dump(); }

std::string solve_message(double time_limit_s, const Vector* start) {
  Json json{{"verb", "solve"}, {"time_limit_s", time_limit_s}};
  if (start != nullptr) json["start"] = std::vector<double>(start->begin(), start->end());
  return json.dump();
}

std::string numbered(const std::string& message, std::uint64_t sequence) {
  return "{\"sequence\":" + std::to_string(sequence) + "," + message.substr(1);
}

int parse_start(const std::string& text, std::uint64_t sequence) {
  const Json json = parse_object(text);
  const Expected expected{sequence, false};
  check_sequence(json, expected);
  const int version = json.contains("sequence") ? 2 : 1;
  for (const auto& [field, value] : json.items()) {
    if (field == "version" && value == Json(version)) continue;
    if (field == "version" && value == Json(kVersion)) throw BadMessage("version is 2, but sequence is missing");
    if (field != "sequence") throw BadMessage("expected {}, found " + text.substr(0, 60));
  }
  return version;
}

void parse_acknowledgement(const std::string& text, const Expected& expected) {
  const Json json = parse_object(text);
  check_sequence(json, expected);
  if (json.size() > (json.contains("sequence") ? 1U : 0U)) throw BadMessage("expected {}, found " + text.substr(0, 60));
  require_sequence(json, expected);
}

Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes, const Expected& expected) {
  const Json json = parse_object(text);
  check_sequence(json, expected);
  Answer answer;
  bool claimed = false;
  for (const auto& [field, value] : json.items()) {
    if (field == "claim") {
      answer.claim = parse_program_claim(value);
      claimed = true;
    } else if (field == "z") {
      answer.z = parse_vector(value, "z", sizes.z);
    } else if (field == "velocity") {
      answer.velocity = parse_vector(value, "velocity", sizes.velocity);
    } else if (field == "farkas") {
      answer.farkas = parse_vector(value, "farkas", sizes.farkas);
    } else if (field == "detail") {
      answer.detail = worker::printable(parse_text(value, "detail"), worker::kMaxDetailBytes);
    } else if (field == "iterations") {
      answer.counters.iterations = parse_counter(value, "iterations");
    } else if (field == "pivots") {
      answer.counters.pivots = parse_counter(value, "pivots");
    } else if (field == "factorizations") {
      answer.counters.factorizations = parse_counter(value, "factorizations");
    } else if (field != "sequence") {
      throw BadMessage("unknown field: " + field.substr(0, 40));
    }
  }
  require_sequence(json, expected);
  if (!claimed) throw BadMessage("claim is missing");
  if (answer.claim == Claim::kSolved && answer.z.size() != sizes.z) throw BadMessage("solved, but z is missing");
  return answer;
}

std::size_t longest_answer(const worker::AnswerSizes& sizes) {
  return static_cast<std::size_t>(sizes.z + sizes.velocity + sizes.farkas) * kBytesPerNumber + kBytesBesides;
}

}  // namespace lcpbench::external
