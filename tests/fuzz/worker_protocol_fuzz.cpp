// Whatever a worker or the program sends: parsing ends in an error or in a message that is within its bounds and is
// written again as it was read.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <vector>

#include "adapters/worker_protocol.h"

namespace lcpbench::worker {
namespace {

constexpr AnswerSizes kSizes{.z = 3, .velocity = 2, .farkas = 1};
constexpr std::size_t kSequenceAt = 24;

void require(bool condition) {
  if (!condition) std::abort();
}

bool starts_with(std::span<const std::byte> bytes, std::span<const std::byte> beginning) {
  return beginning.size() <= bytes.size() && std::equal(beginning.begin(), beginning.end(), bytes.begin());
}

void check_request(std::span<const std::byte> bytes) {
  const Parsed<Request> request = parse_request(bytes);
  if (!request.ok()) return;
  std::vector<std::byte> again(write_request(request.value, {}));
  write_request(request.value, again);
  require(again.size() == bytes.size() && starts_with(bytes, again));
}

void check_response(std::span<const std::byte> bytes) {
  std::uint64_t sequence = 0;
  if (bytes.size() >= kSequenceAt + sizeof sequence) {
    std::memcpy(&sequence, bytes.data() + kSequenceAt, sizeof sequence);
  }
  const Parsed<Response> response = parse_response(bytes, sequence, kSizes);
  if (!response.ok()) return;
  const Answer& answer = response.value.result.answer;
  require(wrong_lengths(answer, kSizes).empty());
  require(answer.claim >= Claim::kSolved && answer.claim <= Claim::kCrashed);
  require(answer.detail == printable(answer.detail, kMaxDetailBytes));
  require(response.value.busy_s >= 0 && std::isfinite(response.value.busy_s));
  std::vector<std::byte> again(write_response(response.value, {}));
  require(again.size() <= bytes.size());
  write_response(response.value, again);
  require(parse_response(again, sequence, kSizes).ok());
}

void check_greeting(std::span<const std::byte> bytes) {
  const Parsed<Greeting> greeting = parse_greeting(bytes);
  if (!greeting.ok()) return;
  std::vector<std::byte> again(write_greeting(greeting.value, {}));
  write_greeting(greeting.value, again);
  require(again.size() == bytes.size() && starts_with(bytes, again));
}

}  // namespace
}  // namespace lcpbench::worker

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  lcpbench::worker::check_request(bytes);
  lcpbench::worker::check_response(bytes);
  lcpbench::worker::check_greeting(bytes);
  return 0;
}
