#include "study/paper/claims.h"

#include <algorithm>
#include <cmath>

namespace lcpbench::paper {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kFamilyWiseError = 0.05;

bool is_tested(const Comparison& comparison) { return static_cast<bool>(comparison.interval); }

/// @param level  error of this one comparison
Stance stance_of(const Comparison& comparison, double level) {
  if (!is_tested(comparison)) return Stance::kShown;
  if (comparison.p_value && !(*comparison.p_value <= level)) return Stance::kUndecided;
  const Interval interval = comparison.interval(normal_quantile(level));
  const bool is_above = interval.low > comparison.bound;
  const bool is_below = interval.high < comparison.bound;
  if (comparison.within) {
    if (is_below || interval.low > *comparison.within) return Stance::kOpposes;
    return is_above && interval.high < *comparison.within ? Stance::kSupports : Stance::kUndecided;
  }
  if (is_above) return comparison.above ? Stance::kSupports : Stance::kOpposes;
  if (is_below) return comparison.above ? Stance::kOpposes : Stance::kSupports;
  return Stance::kUndecided;
}

void decide(std::vector<Comparison>& comparisons) {
  std::erase_if(comparisons, [](const Comparison& comparison) { return std::isnan(comparison.value); });
  const auto tested = std::count_if(comparisons.begin(), comparisons.end(), is_tested);
  for (Comparison& comparison : comparisons) {
    comparison.stance =
        stance_of(comparison, kFamilyWiseError / static_cast<double>(std::max<std::ptrdiff_t>(tested, 1)));
  }
}

std::ptrdiff_t count(const std::vector<Comparison>& comparisons, Stance stance) {
  return std::count_if(comparisons.begin(), comparisons.end(),
                       [stance](const Comparison& comparison) { return comparison.stance == stance; });
}

/// Every comparison that tests the cause supports it, and there is one.
bool is_explained(const Claim& claim) {
  return !claim.explanation.empty() &&
         count(claim.explanation, Stance::kSupports) == static_cast<std::ptrdiff_t>(claim.explanation.size());
}

Word word_of(const Claim& claim) {
  const std::ptrdiff_t supporting = count(claim.comparisons, Stance::kSupports);
  const std::ptrdiff_t opposing = count(claim.comparisons, Stance::kOpposes);
  const std::ptrdiff_t undecided = count(claim.comparisons, Stance::kUndecided);
  if (supporting + opposing + undecided == 0) return Word::kNotTested;
  if (opposing > 0) return supporting > 0 ? Word::kInPart : Word::kContradicted;
  if (supporting == 0) return Word::kUndecided;
  if (claim.on_every_set && undecided > 0) return supporting >= undecided ? Word::kInPart : Word::kUndecided;
  return is_explained(claim) ? Word::kExplained : Word::kConfirmed;
}

/// @param comparison  nullptr for a claim without any
Json record(const Claim& claim, const char* part, const Comparison* comparison) {
  const double none = Proportion{}.value();
  const bool tested = comparison != nullptr && is_tested(*comparison);
  const Interval interval = tested ? comparison->interval(kZ95) : Interval{none, none};
  Comparison absent{.what = "needs " + claim.needs, .value = none, .bound = none};
  const Comparison& shown = comparison == nullptr ? absent : *comparison;
  return {{"claim", claim.id},
          {"statement", claim.statement},
          {"test", claim.rule},
          {"needs", claim.needs},
          {"cause", claim.cause},
          {"word", name_of(claim.word)},
          {"part", part},
          {"quantity", shown.what},
          {"scope", shown.scope},
          {"value", shown.value},
          {"low", interval.low},
          {"high", interval.high},
          {"claimed", comparison == nullptr ? ""
                      : shown.within        ? "between"
                      : shown.above         ? "above"
                                            : "below"},
          {"bound", shown.bound},
          {"upper_bound", shown.within.value_or(none)},
          {"stance", comparison == nullptr ? "" : name_of(shown.stance)},
          {"detail", shown.detail}};
}

}  // namespace

const char* name_of(Stance stance) {
  switch (stance) {
    case Stance::kSupports: return "supports";
    case Stance::kOpposes: return "opposes";
    case Stance::kUndecided: return "undecided";
    case Stance::kShown: return "not tested";
  }
  return "";
}

const char* name_of(Word word) {
  switch (word) {
    case Word::kConfirmed: return "confirmed";
    case Word::kInPart: return "confirmed in part";
    case Word::kContradicted: return "contradicted";
    case Word::kExplained: return "explained";
    case Word::kUndecided: return "undecided";
    case Word::kNotTested: return "not tested";
  }
  return "";
}

void judge(Claim& claim) {
  decide(claim.comparisons);
  decide(claim.explanation);
  decide(claim.beyond);
  claim.word = word_of(claim);
}

std::vector<Claim> test_claims(const Summary& summary, const std::vector<Grid>& grids) {
  std::vector<Grid> whole = grids;
  std::erase_if(whole, [](const Grid& grid) { return grid.refused() > 0 || follows_rules_2012(grid.solver); });
  std::vector<std::int64_t> most(summary.sets.size(), 0);
  for (const Grid& grid : whole) most[grid.set] = std::max(most[grid.set], grid.trials());
  std::erase_if(whole, [&most](const Grid& grid) { return 2 * grid.trials() < most[grid.set]; });
  std::vector<Claim> claims = paper_claims(summary, whole);
  for (Claim& claim : claims) judge(claim);
  return claims;
}

Json claims_json(const std::vector<Claim>& claims) {
  Json records = Json::array();
  for (const Claim& claim : claims) {
    if (claim.comparisons.empty()) records.push_back(record(claim, "claim", nullptr));
    for (const Comparison& comparison : claim.comparisons) records.push_back(record(claim, "claim", &comparison));
    for (const Comparison& comparison : claim.explanation) records.push_back(record(claim, "explanation", &comparison));
    for (const Comparison& comparison : claim.beyond) records.push_back(record(claim, "beyond", &comparison));
  }
  return records;
}

}  // namespace lcpbench::paper
