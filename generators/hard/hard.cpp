#include "generators/hard/hard.h"

#include <utility>

#include "generators/hard/build.h"

namespace lcpbench {

const std::vector<HardSet>& hard_sets() {
  static const std::vector<HardSet> sets = [] {
    std::vector<HardSet> all;
    using namespace hard;
    for (auto* family : {edge_sets, pivoting_sets, conditioning_sets, class_sets, application_sets, particle_sets,
                         box_sets, chain_sets}) {
      for (HardSet& set : family()) all.push_back(std::move(set));
    }
    return all;
  }();
  return sets;
}

std::optional<HardCase> hard_case(const std::string& text) {
  const Spec spec = parse_spec(text);
  for (const HardSet& set : hard_sets()) {
    if (set.name == spec.name) return set.make(set.name, spec.options);
  }
  return std::nullopt;
}

std::string truth_text(const HardCase& problem) {
  const HardTruth& truth = problem.truth;
  if (truth.known == HardKnown::kUnsolvable) return "no solution: " + truth.reason;
  const std::string what = problem.contact ? "velocity" : "solution";
  std::string text = "solvable";
  if (truth.unique == HardUnique::kYes) text += ", one " + what;
  if (truth.unique == HardUnique::kNo) text += problem.contact ? ", several velocities" : ", several solutions";
  if (!truth.z.empty()) text += truth.exact ? ", exact answer known" : ", answer known to rounding";
  return text + ": " + truth.reason;
}

}  // namespace lcpbench
