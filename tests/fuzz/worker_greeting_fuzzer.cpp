#include "adapters/worker/worker_protocol.h"
#include "tests/fuzz/worker_bytes.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const worker::Parsed<worker::Greeting> greeting = worker::parse_greeting(fuzz::bytes_of(data, size));
  if (!greeting.ok()) return 0;
  const std::vector<std::byte> bytes =
      fuzz::written([&](std::span<std::byte> out) { return worker::write_greeting(greeting.value, out); });
  const worker::Parsed<worker::Greeting> again = worker::parse_greeting(bytes);
  fuzz::require(again.ok() && again.value.solvers == greeting.value.solvers, "a greeting comes back from its message");
  return 0;
}
