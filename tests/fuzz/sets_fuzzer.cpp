#include <string>

#include "generators/sets.h"
#include "tests/fuzz/harness.h"

/// Set names and globs. Sets of files are left out: their names are paths, and this must not depend on the disk.
///
/// A glob matches up to all sets. One of them is examined, another for inputs of another length: to draw a problem of
/// each would leave time for little else.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcpbench;
  const std::string text(fuzz::text_of(data, size));
  if (text.find("file:") != std::string::npos) return 0;
  const auto names = fuzz::parsed_or_refused([&] { return expand_sets(text); });
  if (!names) return 0;
  fuzz::require(!names->empty(), "a pattern that is accepted matches a set");
  const std::string& name = (*names)[size % names->size()];
  const auto set = open_set(name);
  fuzz::require(set->name() == name, "expansion gives canonical names");
  fuzz::require(expand_sets(name) == std::vector<std::string>{name}, "a canonical name expands to itself");
  fuzz::require(set->generate(1, 0).size() > 0, "a set that is accepted gives problems");
  return 0;
}
