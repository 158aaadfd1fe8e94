#include <algorithm>

#include "tests/fuzz/problem_round_trip.h"

/// The pair of files as one input: M, a NUL byte, q.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const std::string_view text = fuzz::text_of(data, size);
  const std::size_t separator = std::min(text.find('\0'), text.size());
  const std::string_view M = text.substr(0, separator);
  const std::string_view q = text.substr(std::min(separator + 1, text.size()));
  const auto problem = fuzz::parsed_or_refused([&] { return parse_matrix_market(M, q, "fuzz.M.mtx"); });
  if (problem) fuzz::require_round_trip(*problem);
  return 0;
}
