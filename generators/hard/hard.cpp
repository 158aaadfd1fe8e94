#include "generators/hard/hard.h"

#include <utility>

#include "generators/hard/build.h"

namespace lcpbench {
namespace {

struct HardWords {
  const char* name;
  const char* size;
  const char* summary;
  const char* hard;
  const char* source;
};

constexpr HardWords kWords[] = {
#include "generators/hard/cases.inc"
};

void put_into_words(HardSet& set) {
  for (const HardWords& words : kWords) {
    if (set.name != words.name) continue;
    set.size = words.size;
    set.summary = words.summary;
    set.hard = words.hard;
    set.source = words.source;
  }
  set.name = "hard/" + set.name;
}

}  // namespace

std::size_t HardCase::size() const {
  if (!contact) return q.size();
  std::size_t n = contact->edges.size();
  for (const int edges : contact->edges) n += static_cast<std::size_t>(edges) + (edges > 0 ? 1 : 0);
  return n;
}

std::string HardSet::family() const {
  const std::size_t begin = name.find('/') + 1;
  return name.substr(begin, name.find('/', begin) - begin);
}

const std::vector<HardSet>& hard_sets() {
  static const std::vector<HardSet> sets = [] {
    std::vector<HardSet> all;
    using namespace hard;
    for (auto* family : {edge_sets, pivoting_sets, conditioning_sets, class_sets, application_sets, particle_sets,
                         box_sets, chain_sets}) {
      for (HardSet& set : family()) put_into_words(all.emplace_back(std::move(set)));
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
