#include "native/lemke/lemke_sweep.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <utility>

#include "core/compliance.h"
#include "core/swept_answers.h"

namespace lcpbench {
namespace {

/// All settings but the tolerances.
Options others(LemkeSettings settings) {
  settings.pivot_tolerance = settings.zero_tolerance = 0;
  return all_settings(settings);
}

class SweptLemke final : public SweptSolver {
 public:
  explicit SweptLemke(std::span<const LemkeSettings> cells) : sweep_(cells), tries_(cells.size()) {
    for (std::uint32_t cell = 0; cell < tries_.size(); ++cell) tries_[cell].cell = cell;
  }

  void run(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) override {
    try {
      solve(problem, request, answers);
    } catch (const std::exception& error) {
      answer_all_with_failure(tries_.size(), error.what(), answers);
    }
  }

 private:
  void solve(const Problem& problem, const TimedRequest& request, std::vector<SweptAnswer>& answers) {
    SolveTimes times;
    const double wall_s = wall_clock_s();
    const double cpu_s = thread_cpu_clock_s();
    sweep_.load(problem);
    times.setup_cpu_s = thread_cpu_clock_s() - cpu_s;
    times.setup_wall_s = wall_clock_s() - wall_s;
    for (LemkeTry& each : tries_) each.time_limit_s = request.time_limit_s;
    sweep_.walk(tries_, leaves_);
    SweptAnswers gathered(answers);
    for (LemkeLeaf& leaf : leaves_) {
      times.solve_wall_s = leaf.wall_s;
      times.solve_cpu_s = leaf.cpu_s;
      gathered.add(leaf.cells, {std::move(leaf.answer), times});
    }
    gathered.finish();
  }

  LemkeSweep sweep_;
  std::vector<LemkeTry> tries_;
  std::vector<LemkeLeaf> leaves_;
};

}  // namespace

Problem without_compliance(const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr || !contact->is_soft()) return problem;
  return {problem.name(), rigid_equivalent(*contact), problem.formation()};
}

void return_to_given(const Problem& given, const Problem& rigid, Answer& answer) {
  const ContactProblem* contact = given.contact();
  if (answer.claim != Claim::kSolved || contact == nullptr || !contact->is_soft()) return;
  if (creeps_as_given(*contact, *rigid.contact(), answer.z)) return;
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "impulses beyond what the equivalent rigid problem stands for";
}

LemkeSweep::LemkeSweep(std::span<const LemkeSettings> cells, IsaLevel level)
    : common_(cells.front()),
      capabilities_(lemke_capabilities(common_)),
      engine_(lemke::make_engine(lemke_engine_of(common_), level)) {
  for (const LemkeSettings& cell : cells) cells_.push_back({cell.pivot_tolerance, cell.zero_tolerance, 0});
  read_idle_clocks();
}

void LemkeSweep::read_idle_clocks() {
  idle_wall_s_ = idle_cpu_s_ = std::numeric_limits<double>::infinity();
  for (int reading = 0; reading < 100; ++reading) {
    const double wall_s = wall_clock_s();
    const double cpu_s = thread_cpu_clock_s();
    idle_cpu_s_ = std::min(idle_cpu_s_, thread_cpu_clock_s() - cpu_s);
    idle_wall_s_ = std::min(idle_wall_s_, wall_clock_s() - wall_s);
  }
}

std::optional<std::vector<LemkeSettings>> LemkeSweep::readable(std::span<const Options> cells) {
  std::vector<LemkeSettings> settings;
  for (const Options& cell : cells) settings.push_back(parse_settings<LemkeSettings>("lemke", cell));
  if (settings.empty() || lemke_engine_of(settings.front()) == LemkeEngine::kDense) return std::nullopt;
  if (settings.front().test != LemkeAnswerTest::kNone) return std::nullopt;
  const Options common = others(settings.front());
  for (const LemkeSettings& cell : settings) {
    if (others(cell) != common) return std::nullopt;
  }
  return settings;
}

void LemkeSweep::load(const Problem& problem) {
  refusal_ = why_not(capabilities_, problem);
  n_ = problem.size();
  if (!refusal_.empty()) return;
  given_ = problem;
  rigid_ = without_compliance(problem);
  lemke::load(rigid_, *engine_);
}

struct LemkeSweep::Collector {
  std::span<const LemkeTry> tries;
  const Vector& z;
  bool clips;
  const Problem& given;
  const Problem& rigid;
  std::vector<LemkeLeaf>& leaves;
};

void LemkeSweep::collect(void* collector, const lemke::Leaf& leaf) {
  const auto& [tries, z, clips, given, rigid, leaves] = *static_cast<Collector*>(collector);
  LemkeLeaf& copy = leaves.emplace_back();
  for (std::ptrdiff_t i = 0; i < leaf.count; ++i) {
    copy.cells.push_back(tries[static_cast<std::size_t>(leaf.cells[i])].cell);
  }
  std::sort(copy.cells.begin(), copy.cells.end());
  copy.answer.z = z;
  report_lemke(leaf.outcome, clips, copy.answer);
  return_to_given(given, rigid, copy.answer);
  copy.wall_s = leaf.wall_s;
  copy.cpu_s = leaf.cpu_s;
}

std::int64_t LemkeSweep::walk(std::span<const LemkeTry> tries, std::vector<LemkeLeaf>& leaves) {
  leaves.clear();
  if (tries.empty()) return 0;
  if (!refusal_.empty()) {
    LemkeLeaf& refused = leaves.emplace_back();
    for (const LemkeTry& each : tries) refused.cells.push_back(each.cell);
    std::sort(refused.cells.begin(), refused.cells.end());
    refused.answer.claim = Claim::kUnsupported;
    refused.answer.detail = refusal_;
    return 0;
  }
  tried_.clear();
  for (const LemkeTry& each : tries) {
    tried_.push_back(cells_[each.cell]);
    tried_.back().time_limit_s = each.time_limit_s;
  }
  z_.resize(n_);
  lemke::WalkRules rules;
  rules.resolve = common_.update == LemkeUpdate::kResolve;
  Collector collector{tries, z_, common_.rules == LemkeRules::kStandard, given_, rigid_, leaves};
  rules.max_pivots = lemke_pivot_limit(common_, n_);
  rules.wall_s = wall_clock_s;
  rules.cpu_s = thread_cpu_clock_s;
  rules.idle_wall_s = idle_wall_s_;
  rules.idle_cpu_s = idle_cpu_s_;
  rules.on_leaf = collect;
  rules.context = &collector;
  return engine_->walk(tried_.data(), static_cast<std::ptrdiff_t>(tried_.size()), rules, z_.data());
}

std::unique_ptr<SweptSolver> make_swept_lemke(const std::vector<Options>& cells) {
  const auto settings = LemkeSweep::readable(cells);
  return settings ? std::make_unique<SweptLemke>(*settings) : nullptr;
}

}  // namespace lcpbench
