#include "study/report/reliability.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "study/report/coverage_text.h"
#include "study/report/figures.h"
#include "study/report/solver_comparison.h"
#include "study/report/text.h"

namespace lcpbench::report {

namespace {

std::vector<Record> records_of(const Summary& summary, const std::vector<std::size_t>& sets) {
  std::map<std::size_t, Record> by_solver;
  std::map<std::size_t, std::size_t> sets_met;
  for (const std::size_t set : sets) {
    for (const Cell* cell : drawn_cells(summary, set)) {
      Record& record = by_solver[cell->solver];
      record.solver = cell->solver;
      record.crashed += cell->count(lcpbench::Claim::kCrashed);
      ++sets_met[cell->solver];
      for (const Outcome& outcome : cell->outcomes) record.outcomes.emplace_back(set, &outcome);
    }
  }
  std::vector<Record> records;
  for (auto& [solver, record] : by_solver) {
    Evidence& evidence = record.evidence;
    evidence.met_all_sets = sets_met[solver] == sets.size();
    evidence.other_model = std::any_of(sets.begin(), sets.end(), [&](std::size_t set) {
      return solves_other_model(summary.sets[set], summary.solvers[record.solver]);
    });
    evidence.no_time = std::all_of(record.outcomes.begin(), record.outcomes.end(),
                                   [](const auto& entry) { return std::isnan(entry.second->time_s); });
    for (const auto& [set, outcome] : record.outcomes) {
      ++evidence.refused.whole;
      if (!outcome->unsolvable) ++evidence.solved_of_met.whole;
      if (outcome->refused) {
        ++evidence.refused.part;
        continue;
      }
      ++evidence.false_claims.whole;
      if (outcome->false_claim) ++evidence.false_claims.part;
      if (outcome->unsolvable) continue;
      ++evidence.solved.whole;
      if (outcome->solved) ++evidence.solved.part, ++evidence.solved_of_met.part;
    }
    records.push_back(std::move(record));
  }
  return records;
}

bool has_half_of_most(const Evidence& evidence) { return 2 * evidence.false_claims.whole >= evidence.most_taken; }

/// The solver whose share solved is the surest to be high; nullptr where none solved anything.
const Record* best_of(const std::vector<Record>& records) {
  const Record* best = nullptr;
  for (const Record& record : records) {
    const Evidence& evidence = record.evidence;
    if (evidence.other_model || evidence.no_time || !evidence.met_all_sets) continue;
    if (!has_half_of_most(evidence) || evidence.solved.part == 0) continue;
    if (best == nullptr || evidence.solved.interval().low > best->evidence.solved.interval().low) best = &record;
  }
  return best;
}

/// Does `a` show `property` on significantly more than `b` of the problems that both took?
bool significantly_more(const Record& a, const Record& b, bool Outcome::*property) {
  PairedCounts counts;
  for_each_pair(a, b, [&](const Outcome& left, const Outcome& right) {
    if (left.refused || right.refused || left.unsolvable != right.unsolvable) return;
    counts.add(left.*property, right.*property);
  });
  return counts.only_first > counts.only_second && counts.p_value() < kSignificance;
}

/// A bound of the rule: "90 %".
std::string bound(double share) { return fmt::format("{:g} %", 100 * share); }

}  // namespace

double Share::value() const {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : std::numeric_limits<double>::quiet_NaN();
}

Interval Share::interval() const { return wilson(part, whole); }

std::string TimeFactor::text() const {
  if (!shown()) return fmt::format("- ({} of {})", problems, of);
  return fmt::format("{}x ({}–{}) n={}", factor(ratio.value), factor(ratio.low), factor(ratio.high), problems);
}

TimeFactor over_reference(const Cell& cell) {
  return {cell.time_ratio, cell.paired, cell.trials - cell.count(lcpbench::Claim::kUnsupported)};
}

std::int64_t least_problems() {
  static const std::int64_t least = [] {
    std::int64_t n = 1;
    while (wilson(n, n).low < kReliableShare) ++n;
    return n;
  }();
  return least;
}

std::int64_t ample_problems() {
  static const std::int64_t ample = [] {
    std::int64_t n = 1;
    while (wilson(0, n).high > kFalseClaimBound) ++n;
    return n;
  }();
  return ample;
}

double plan_share(const Summary& summary, const std::vector<std::size_t>& sets) {
  std::vector<std::string> names;
  for (const std::size_t set : sets) names.push_back(summary.sets[set].name);
  const double share = summary.coverage.part(names).share();
  return std::isnan(share) ? 1 : share;
}

bool too_few(std::int64_t problems, double plan_share) {
  return problems < least_problems() || (plan_share < kPlanShare && problems < ample_problems());
}

Reliability judge_reliability(const Evidence& evidence) {
  const Share& solved = evidence.solved;
  const Share& false_claims = evidence.false_claims;
  const bool caught = false_claims.part > 0;
  if (caught && (evidence.more_false_claims || !(false_claims.interval().high <= kFalseClaimBound)))
    return {Standing::kUnreliable, Ground::kFalseClaims};
  if (evidence.other_model) return {Standing::kPartly, Ground::kOtherModel};
  if (!evidence.met_all_sets) return {Standing::kPartly, Ground::kSomeSets};
  if (!(evidence.refused.value() <= kRefusedBound)) return {Standing::kPartly, Ground::kRefuses};
  if (evidence.no_time) return {Standing::kPartly, Ground::kNoTime};
  if (solved.whole < least_problems()) return {Standing::kTooFew, Ground::kFewProblems};
  if (!(solved.interval().high >= kReliableShare)) return {Standing::kUnreliable, Ground::kUnsolved};
  if (evidence.solves_fewer) return {Standing::kUnreliable, Ground::kBehindTheBest};
  if (!has_half_of_most(evidence)) return {Standing::kTooFew, Ground::kSmallSample};
  if (too_few(solved.whole, evidence.plan_share)) return {Standing::kTooFew, Ground::kShortOfPlan};
  if (!(solved.interval().low >= kReliableShare)) return {Standing::kTooFew, Ground::kWideInterval};
  return {Standing::kReliable, Ground::kNone};
}

const char* to_string(Ground ground) {
  switch (ground) {
    case Ground::kNone: return "reliable";
    case Ground::kFalseClaims: return "false_claims";
    case Ground::kUnsolved: return "unsolved";
    case Ground::kBehindTheBest: return "behind_the_best";
    case Ground::kFewProblems: return "few_problems";
    case Ground::kSmallSample: return "small_sample";
    case Ground::kShortOfPlan: return "short_of_plan";
    case Ground::kWideInterval: return "wide_interval";
    case Ground::kOtherModel: return "other_model";
    case Ground::kNoTime: return "no_time";
    case Ground::kSomeSets: return "some_sets";
    case Ground::kRefuses: return "refuses";
  }
  return "";
}

std::vector<Record> judged_records(const Summary& summary, const std::vector<std::size_t>& sets) {
  std::vector<Record> records = records_of(summary, sets);
  std::int64_t most_taken = 0;
  for (const Record& record : records) most_taken = std::max(most_taken, record.evidence.false_claims.whole);
  const double done = plan_share(summary, sets);
  for (Record& record : records) {
    record.evidence.most_taken = most_taken;
    record.evidence.plan_share = done;
  }
  const Record* best = best_of(records);
  for (Record& record : records) {
    if (best != nullptr && &record != best) {
      record.evidence.solves_fewer = significantly_more(*best, record, &Outcome::solved);
      record.evidence.more_false_claims = significantly_more(record, *best, &Outcome::false_claim);
    }
    record.reliability = judge_reliability(record.evidence);
  }
  return records;
}

nlohmann::ordered_json reliable_json(const Reliability& reliability) {
  switch (reliability.standing) {
    case Standing::kReliable: return true;
    case Standing::kUnreliable: return false;
    case Standing::kTooFew:
    case Standing::kPartly: break;
  }
  return nullptr;
}

nlohmann::ordered_json reliability_rule_json() {
  return {{"least_problems", least_problems()},
          {"solved_low_at_least", kReliableShare},
          {"false_claims_high_at_most", kFalseClaimBound},
          {"refused_at_most", kRefusedBound},
          {"sample_at_least", 0.5},
          {"plan_at_least", kPlanShare},
          {"ample_problems", ample_problems()},
          {"interval", 0.95},
          {"paired_test_level", kSignificance}};
}

std::string reliability_rule_html() {
  return fmt::format(
      "<strong>Reliable</strong> is a solver of which these problems show, at 95 %, that it solves at least {} of what "
      "it takes (the lower end of Wilson’s interval), and which on the same problems neither solves significantly "
      "fewer nor makes significantly more false claims than the best (exact paired tests at {}; the best has the "
      "highest lower end). That takes {} problems, all of them solved, or more with failures; with fewer, or where the "
      "interval contains {}, or with less than half as many problems as another solver, or where less than {} of the "
      "plan is done and they are fewer than {}, the report says <em>too few to say</em>. A solver that was seen to say "
      "solved and be wrong is reliable only where the upper end of that "
      "share’s interval is at most {}, and it is named wherever it is called reliable. Where no false claim was seen, "
      "the interval says how many there may still be: up to {} after {} problems. Refused problems are not counted as "
      "failures; a solver that refuses more than {} of the problems is not ranked.",
      bound(kReliableShare), bound(kSignificance), least_problems(), bound(kReliableShare), bound(kPlanShare),
      ample_problems(), bound(kFalseClaimBound), percent(wilson(0, least_problems()).high), least_problems(),
      bound(kRefusedBound));
}

std::string too_few_text(std::int64_t problems, double plan_share) {
  if (problems < least_problems()) {
    return fmt::format("too few to say: {}; the report needs {}", counted(problems, "problem"), least_problems());
  }
  return fmt::format("too few to say: {}, {} of the plan; the report needs {} of it, or {} problems",
                     counted(problems, "problem"), escape(plan_share_text(plan_share)), bound(kPlanShare),
                     ample_problems());
}

}  // namespace lcpbench::report
