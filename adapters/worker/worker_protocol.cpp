#include "adapters/worker/worker_protocol.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "adapters/worker/byte_stream.h"
#include "adapters/worker/problem_codec.h"

namespace lcpbench::worker {
namespace {

constexpr std::size_t kFrameBytes = 5 * sizeof(std::uint64_t);
constexpr std::size_t kMaxSolverBytes = 65536;

enum class Verb : std::uint64_t { kGreet = 1, kSolve = 2, kAnswer = 3 };

// ---- frames -------------------------------------------------------------------------------------------------------

template <class WritePayload>
std::size_t write_frame(Verb verb, std::uint64_t sequence, std::span<std::byte> out, WritePayload&& write_payload) {
  ByteWriter writer(out);
  writer.word(kMagic);
  writer.word(kVersion);
  writer.word(static_cast<std::uint64_t>(verb));
  writer.word(sequence);
  const std::size_t size_at = writer.size();
  writer.word(0);
  write_payload(writer);
  writer.overwrite_word(size_at, writer.size() - kFrameBytes);
  return writer.size();
}

struct Frame {
  std::uint64_t sequence = 0;
  std::size_t payload_bytes = 0;
};

Frame read_frame(ByteReader& reader, Verb expected) {
  Frame frame;
  reader.require(reader.word() == kMagic, "no message: wrong magic number");
  const std::uint64_t version = reader.word();
  reader.require(version == kVersion, "protocol version " + std::to_string(version) + ", this program speaks " +
                                          std::to_string(kVersion) + ": rebuild the workers");
  reader.require(reader.word() == static_cast<std::uint64_t>(expected), "unexpected verb");
  frame.sequence = reader.word();
  frame.payload_bytes = reader.count(1, "payload");
  return frame;
}

template <class T>
Parsed<T> finish(T value, const ByteReader& reader) {
  return {std::move(value), reader.error()};
}

// ---- answers ------------------------------------------------------------------------------------------------------

constexpr int kClaims = static_cast<int>(Claim::kCrashed) + 1;

Claim read_claim(ByteReader& reader) {
  const std::uint64_t claim = reader.word();
  reader.require(claim < kClaims, "claim: unknown");
  return reader.ok() ? static_cast<Claim>(claim) : Claim::kCrashed;
}

void write_times(const SolveTimes& times, ByteWriter& writer) {
  for (const double seconds : {times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s, times.solve_cpu_s}) {
    writer.real(seconds);
  }
  writer.integer(times.repeats);
}

double read_seconds(ByteReader& reader) {
  const double seconds = reader.real();
  reader.require(std::isfinite(seconds) && seconds >= 0, "a time is negative or not finite");
  return seconds;
}

SolveTimes read_times(ByteReader& reader) {
  SolveTimes times;
  for (double* seconds : {&times.setup_wall_s, &times.setup_cpu_s, &times.solve_wall_s, &times.solve_cpu_s}) {
    *seconds = read_seconds(reader);
  }
  const std::int64_t repeats = reader.integer();
  reader.require(repeats >= 1 && repeats <= std::numeric_limits<int>::max(), "repeats: out of range");
  times.repeats = reader.ok() ? static_cast<int>(repeats) : 1;
  return times;
}

std::int64_t read_counter(ByteReader& reader) {
  const std::int64_t counter = reader.integer();
  reader.require(counter >= -1, "a counter is below -1");
  return counter;
}

std::string wrong_length(const char* field, Index found, Index expected) {
  if (found == 0 || found == expected) return {};
  return std::string(field) + " has " + std::to_string(found) + " entries, expected " +
         (expected == 0 ? "none" : std::to_string(expected) + " or none");
}

}  // namespace

AnswerSizes answer_sizes(const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr) return {problem.size(), 0, problem.size()};
  return {problem.size(), contact->ngc(), contact->nc()};
}

std::string wrong_lengths(const Answer& answer, const AnswerSizes& sizes) {
  for (std::string error :
       {wrong_length("z", answer.z.size(), sizes.z), wrong_length("velocity", answer.velocity.size(), sizes.velocity),
        wrong_length("farkas", answer.farkas.size(), sizes.farkas)}) {
    if (!error.empty()) return error;
  }
  return {};
}

std::string printable(std::string_view text, std::size_t max_bytes) {
  std::string result(text.substr(0, max_bytes));
  for (char& c : result) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) c = ' ';
    if (code >= 0x80) c = '?';
  }
  return result;
}

std::size_t write_request(const Request& request, std::span<std::byte> out) {
  return write_frame(Verb::kSolve, request.sequence, out, [&](ByteWriter& writer) {
    writer.text(request.solver);
    writer.real(request.timing.time_limit_s);
    writer.real(request.timing.repeat_until_s);
    writer.integer(request.timing.max_repeats);
    write_problem(request.problem, writer);
  });
}

Parsed<Request> parse_request(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  Request request;
  const Frame frame = read_frame(reader, Verb::kSolve);
  reader.require(frame.payload_bytes == reader.remaining(), "payload: not the size of the message");
  request.sequence = frame.sequence;
  request.solver = reader.text(kMaxSolverBytes, "solver");
  request.timing.time_limit_s = reader.real();
  request.timing.repeat_until_s = reader.real();
  const std::int64_t max_repeats = reader.integer();
  reader.require(max_repeats >= 1 && max_repeats <= std::numeric_limits<int>::max(), "max_repeats: out of range");
  if (!reader.ok()) return finish(Request{}, reader);
  request.timing.max_repeats = static_cast<int>(max_repeats);
  request.problem = read_problem(reader);
  reader.require(reader.remaining() == 0, "the message holds more than the problem");
  return finish(std::move(request), reader);
}

std::size_t response_capacity(const AnswerSizes& sizes) {
  Response largest;
  largest.result.answer.detail.assign(kMaxDetailBytes, ' ');
  const Index entries = sizes.z + sizes.velocity + sizes.farkas;
  return write_response(largest, {}) + static_cast<std::size_t>(entries) * sizeof(double);
}

std::size_t write_response(const Response& response, std::span<std::byte> out) {
  return write_frame(Verb::kAnswer, response.sequence, out, [&](ByteWriter& writer) {
    const Answer& answer = response.result.answer;
    writer.word(static_cast<std::uint64_t>(answer.claim));
    writer.integer(answer.counters.iterations);
    writer.integer(answer.counters.pivots);
    writer.integer(answer.counters.factorizations);
    write_times(response.result.times, writer);
    writer.real(response.busy_s);
    writer.word(response.retiring ? 1 : 0);
    writer.vector(answer.z);
    writer.vector(answer.velocity);
    writer.vector(answer.farkas);
    writer.text(std::string_view(answer.detail).substr(0, kMaxDetailBytes));
  });
}

Parsed<Response> parse_response(std::span<const std::byte> bytes, std::uint64_t sequence, const AnswerSizes& sizes) {
  ByteReader frame_reader(bytes);
  const Frame frame = read_frame(frame_reader, Verb::kAnswer);
  frame_reader.require(frame.sequence == sequence,
                       "sequence number " + std::to_string(frame.sequence) + ", expected " + std::to_string(sequence));
  if (!frame_reader.ok()) return finish(Response{}, frame_reader);

  ByteReader reader(bytes.subspan(kFrameBytes, frame.payload_bytes));
  Response response;
  response.sequence = sequence;
  Answer& answer = response.result.answer;
  answer.claim = read_claim(reader);
  answer.counters.iterations = read_counter(reader);
  answer.counters.pivots = read_counter(reader);
  answer.counters.factorizations = read_counter(reader);
  response.result.times = read_times(reader);
  response.busy_s = read_seconds(reader);
  const std::uint64_t retiring = reader.word();
  reader.require(retiring <= 1, "retiring: neither 0 nor 1");
  response.retiring = retiring == 1;
  answer.z = reader.vector("z");
  answer.velocity = reader.vector("velocity");
  answer.farkas = reader.vector("farkas");
  answer.detail = printable(reader.text(kMaxDetailBytes, "detail"), kMaxDetailBytes);
  reader.require(reader.remaining() == 0, "the message holds more than the answer");
  const std::string lengths = wrong_lengths(answer, sizes);
  reader.require(lengths.empty(), lengths);
  if (!reader.ok()) return finish(Response{}, reader);
  return finish(std::move(response), reader);
}

std::size_t write_greeting(const Greeting& greeting, std::span<std::byte> out) {
  return write_frame(Verb::kGreet, 0, out, [&](ByteWriter& writer) {
    writer.word(greeting.solvers.size());
    for (const std::string& solver : greeting.solvers) writer.text(solver);
    writer.text(std::string_view(greeting.failure).substr(0, kMaxDetailBytes));
  });
}

Parsed<Greeting> parse_greeting(std::span<const std::byte> bytes) {
  ByteReader reader(bytes);
  const Frame frame = read_frame(reader, Verb::kGreet);
  reader.require(frame.sequence == 0, "a greeting has no sequence number");
  reader.require(frame.payload_bytes == reader.remaining(), "payload: not the size of the message");
  Greeting greeting;
  const std::size_t count = reader.count(sizeof(std::uint64_t), "solvers");
  for (std::size_t i = 0; i < count && reader.ok(); ++i) {
    greeting.solvers.push_back(reader.text(kMaxGreetingBytes, "solver name"));
  }
  greeting.failure = printable(reader.text(kMaxDetailBytes, "failure"), kMaxDetailBytes);
  reader.require(reader.remaining() == 0, "the message holds more than a greeting");
  return finish(std::move(greeting), reader);
}

}  // namespace lcpbench::worker
