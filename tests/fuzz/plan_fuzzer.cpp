#include "study/run/plan.h"
#include "tests/fuzz/harness.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const auto plan = fuzz::parsed_or_refused([&] { return parse_plan(fuzz::text_of(data, size), "fuzz.json"); });
  if (!plan) return 0;
  const std::string written = plan_json(*plan);
  fuzz::require(plan_json(parse_plan(written, "written")) == written, "a plan comes back from its text");
  return 0;
}
