#include "adapters/worker/worker_protocol.h"
#include "tests/fuzz/worker_bytes.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  constexpr std::uint64_t kSequence = 7;
  constexpr worker::AnswerSizes kSizes{.z = 3, .velocity = 2, .farkas = 1};
  const auto response = worker::parse_response(fuzz::bytes_of(data, size), kSequence, kSizes);
  if (!response.ok()) return 0;
  fuzz::require(worker::wrong_lengths(response.value.result.answer, kSizes).empty(), "vectors have permitted lengths");
  const auto write = [](const worker::Response& message) {
    return fuzz::written([&](std::span<std::byte> out) { return worker::write_response(message, out); });
  };
  const std::vector<std::byte> bytes = write(response.value);
  fuzz::require(bytes.size() <= worker::response_capacity(kSizes), "a valid response fits the room for it");
  const auto again = worker::parse_response(bytes, kSequence, kSizes);
  fuzz::require(again.ok(), "a written response is accepted");
  fuzz::require(write(again.value) == bytes, "a response comes back from its message");
  return 0;
}
