#include "adapters/worker/worker_protocol.h"
#include "tests/fuzz/harness.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  constexpr std::uint64_t kSequence = 7;
  constexpr worker::AnswerSizes kSizes{.z = 3, .velocity = 2, .farkas = 1};
  worker::Response response;
  try {
    response = worker::parse_response(std::string(data, data + size), kSequence, kSizes);
  } catch (const worker::BadMessage&) {
    return 0;
  }
  fuzz::require(worker::wrong_lengths(response.result.answer, kSizes).empty(), "vectors have permitted lengths");
  const std::string bytes = worker::write_response(response);
  fuzz::require(bytes.size() <= worker::response_capacity(kSizes), "a valid response fits the room for it");
  const worker::Response again = worker::parse_response(bytes, kSequence, kSizes);
  fuzz::require(worker::write_response(again) == bytes, "a response comes back from its message");
  return 0;
}
