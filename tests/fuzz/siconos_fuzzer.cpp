#include "tests/fuzz/problem_round_trip.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const auto problem =
      fuzz::parsed_or_refused([&] { return parse_siconos_lcp(fuzz::text_of(data, size), "fuzz.dat"); });
  if (problem) fuzz::require_round_trip(*problem);
  return 0;
}
