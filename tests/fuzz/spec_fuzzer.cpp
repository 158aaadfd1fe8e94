#include "core/settings.h"
#include "core/spec.h"
#include "tests/fuzz/harness.h"

namespace lcpbench {
namespace {

/// One field of every type that a settings struct may have.
struct EveryType {
  enum class Choice { kDense, kKernel };
  double real = 1e-12;
  std::int64_t integer = 10;
  bool boolean = false;
  std::string text;
  Choice choice = Choice::kDense;

  void visit(auto&& field) {
    field("real", real, RealRange{.min = 0, .max = 1}, "");
    field("integer", integer, IntegerRange{.min = 1}, "");
    field("boolean", boolean, "");
    field("text", text, "");
    field("choice", choice, Choices<Choice>{{{"dense", Choice::kDense}, {"kernel", Choice::kKernel}}}, "");
  }
};

void require_spec_round_trip(const Spec& spec) {
  const Spec again = parse_spec(spec.text());
  fuzz::require(again.name == spec.name && again.options == spec.options, "a spec's text parses back to it");
}

void require_settings_round_trip(const EveryType& settings) {
  const Options all = all_settings(settings);
  fuzz::require(all_settings(parse_settings<EveryType>("fuzz", all)) == all, "settings come back from their text");
  const Options changed = changed_settings(settings);
  fuzz::require(all_settings(parse_settings<EveryType>("fuzz", changed)) == all, "unchanged settings are the defaults");
}

}  // namespace
}  // namespace lcpbench

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const std::string_view text = fuzz::text_of(data, size);
  fuzz::parsed_or_refused([&] { return split_top_level(text); });
  const auto spec = fuzz::parsed_or_refused([&] { return parse_spec(text); });
  if (!spec) return 0;
  require_spec_round_trip(*spec);
  const auto settings = fuzz::parsed_or_refused([&] { return parse_settings<EveryType>("fuzz", spec->options); });
  if (settings) require_settings_round_trip(*settings);
  return 0;
}
