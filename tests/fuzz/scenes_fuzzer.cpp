#include "core/io/scenes_file.h"
#include "tests/fuzz/problem_round_trip.h"

/// Plain and compressed scenes files. Of a file that opens, the first steps are read; each is refused or comes back.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const auto scenes =
      fuzz::parsed_or_refused([&] { return std::make_unique<ScenesFile>(fuzz::text_of(data, size), "fuzz.scenes"); });
  if (!scenes) return 0;
  const ScenesFile& file = **scenes;
  for (std::size_t i = 0; i < file.count() && i < 8; ++i) {
    fuzz::require(file.index_of(file.step_number(i)) == i, "a step is found by its number");
    const auto step = fuzz::parsed_or_refused([&] { return file.read(i); });
    if (!step) continue;
    fuzz::require(step->step == file.step_number(i), "the index and the step agree");
    if (const Vector* impulses = step->problem.engine_impulses()) {
      fuzz::require(complete_impulses(*step->problem.contact(), *impulses).size() == step->problem.size(),
                    "the engine's answer has the problem's size");
    }
    fuzz::require_round_trip(step->problem);
  }
  return 0;
}
