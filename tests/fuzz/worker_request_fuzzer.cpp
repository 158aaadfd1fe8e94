#include "adapters/worker/worker_protocol.h"
#include "tests/fuzz/harness.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  try {
    const worker::Request request = worker::parse_request(std::string(data, data + size));
    const std::string bytes = worker::write_request(request);
    fuzz::require(worker::write_request(worker::parse_request(bytes)) == bytes, "a request comes back from its message");
  } catch (const worker::BadMessage&) {
    return 0;
  }
  return 0;
}
