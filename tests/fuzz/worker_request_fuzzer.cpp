#include "adapters/worker/worker_protocol.h"
#include "tests/fuzz/worker_bytes.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const worker::Parsed<worker::Request> request = worker::parse_request(fuzz::bytes_of(data, size));
  if (!request.ok()) return 0;
  const auto write = [](const worker::Request& message) {
    return fuzz::written([&](std::span<std::byte> out) { return worker::write_request(message, out); });
  };
  const std::vector<std::byte> bytes = write(request.value);
  const worker::Parsed<worker::Request> again = worker::parse_request(bytes);
  fuzz::require(again.ok(), "a written request is accepted");
  fuzz::require(write(again.value) == bytes, "a request comes back from its message");
  return 0;
}
