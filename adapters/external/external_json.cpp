#include "adapters/external/external_json.h"

#include <cstdint>

#include "core/error.h"
#include "core/io/json_document.h"
#include "core/io/problem_io.h"
#include "core/settings.h"

namespace lcpbench::external {
namespace {

/// A number, its separator and some white space.
constexpr std::size_t kBytesPerNumber = 64;
constexpr std::size_t kBytesBesides = 1 << 16;

/// What `read` takes out of the object that the line is. @throws BadMessage
template <class Read>
auto read_line(const std::string& line, Read&& read) {
  static const std::string origin = "line";
  try {
    const Json json = parse_json_document(line, origin, true);
    return read(JsonObject(json, origin));
  } catch (const InputError& error) {
    throw worker::BadMessage(error.what());
  }
}

/// The line may be late, or sent twice: then it answers another question.
void check_sequence(const JsonObject& told, const Expected& expected) {
  if (!told.given("sequence")) return;
  const double found = told.number("sequence");
  if (found == static_cast<double>(expected.sequence)) return;
  told.fail("sequence", " is " + format_real(found) + ", but the question has " + std::to_string(expected.sequence) +
                            ": a line that came late or twice");
}

/// Apart from check_sequence(), so that an answer without a number is told first what else is wrong with it.
void require_sequence(const JsonObject& told, const Expected& expected) {
  if (!expected.required || told.given("sequence")) return;
  told.fail("sequence", " is missing: a program that repeats the number of \"start\" repeats every one");
}

std::string instead_of_nothing(const std::string& line) { return ": expected {}, found " + line.substr(0, 60); }

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
  return read_line(text, [&](const JsonObject& told) {
    check_sequence(told, {sequence, false});
    told.only({"sequence", "version"}, instead_of_nothing(text));
    const int version = told.given("sequence") ? 2 : 1;
    if (told.given("version") && told.integer("version") != version) {
      told.fail("version", version == 1 ? " is not 1, but sequence is missing" : " is not 2, but sequence is there");
    }
    return version;
  });
}

void parse_acknowledgement(const std::string& text, const Expected& expected) {
  read_line(text, [&](const JsonObject& told) {
    check_sequence(told, expected);
    told.only({"sequence"}, instead_of_nothing(text));
    require_sequence(told, expected);
  });
}

Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes, const Expected& expected) {
  constexpr std::int64_t kLargestCounter = (std::int64_t{1} << 53) - 1;
  return read_line(text, [&](const JsonObject& told) {
    check_sequence(told, expected);
    told.only({"sequence", "claim", "z", "velocity", "farkas", "detail", "iterations", "pivots", "factorizations"});
    Answer answer;
    answer.claim = parse_claim(told.text("claim"));
    if (answer.claim == Claim::kCrashed) told.fail("claim", ": a program cannot say that it crashed");
    if (told.given("z")) answer.z = told.vector("z", sizes.z);
    if (told.given("velocity")) answer.velocity = told.vector("velocity", sizes.velocity);
    if (told.given("farkas")) answer.farkas = told.vector("farkas", sizes.farkas);
    if (told.given("detail")) answer.detail = worker::printable(told.text("detail"), worker::kMaxDetailBytes);
    const auto counter = [&](const char* field, std::int64_t& value) {
      if (told.given(field)) value = told.integer(field, 0, kLargestCounter);
    };
    counter("iterations", answer.counters.iterations);
    counter("pivots", answer.counters.pivots);
    counter("factorizations", answer.counters.factorizations);
    require_sequence(told, expected);
    const bool has_z = answer.z.size() == sizes.z;
    if (answer.claim == Claim::kSolved && !has_z) told.fail("z", " is missing: the claim is solved");
    return answer;
  });
}

std::size_t longest_answer(const worker::AnswerSizes& sizes) {
  return static_cast<std::size_t>(sizes.z + sizes.velocity + sizes.farkas) * kBytesPerNumber + kBytesBesides;
}

}  // namespace lcpbench::external
