#include "study/validate/validate.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "study/run/open_solver.h"
#include "study/validate/velocity_agreement.h"

namespace lcpbench {
namespace {

/// Our interior point over CHOLMOD: the library factorizes, the method is ours.
constexpr const char* kOursInAWorker = "velocity_ipm_cholmod";

constexpr double kTimeLimitS = 2.0;

struct DefaultSet {
  const char* pattern;
  double share;  ///< of the trials: frictional problems take a hundred times as long
};

/// The first takes every solver there is: scenes with small n and their inertia given. So each pair has its thousand.
constexpr DefaultSet kDefaultSets[]{{"rigid/exp1{nc_max=8}", 1},    {"planted/definite", 1},
                                    {"paper/monotone/exp1", 1},     {"paper/monotone/exp2", 1},
                                    {"paper/monotone/exp5-1e8", 1}, {"paper/copositive/exp1", 0.1},
                                    {"rigid/frictional/exp1", 0.1}};

/// A reference that takes more than 10 ms on most problems: it runs on trials 0, every, 2 every, ..., and on all of the
/// sets on which it is quick.
struct SlowReference {
  const char* name;
  std::int64_t every;
  std::vector<std::string> quick_on;
};

/// A slow reference gets at least this number of problems of each set, or all problems of a smaller set.
constexpr std::int64_t kFewest = 20;

const std::vector<SlowReference>& slow_references() {
  static const std::vector<std::string> small{"rigid/exp1*", "file:*"};
  static const std::vector<std::string> frictionless{"rigid/exp*", "planted/*", "paper/monotone/*", "file:*"};
  static const std::vector<SlowReference> slow{{"ipopt_qp", 10, small},
                                               {"ipopt_mpcc", 20, small},
                                               {"ipopt_scholtes", 50, small},
                                               {"bullet_lemke", 5, frictionless},
                                               {"siconos_avi", 5, frictionless},
                                               {"siconos_lemke", 5, frictionless},
                                               {"siconos_newton_fb", 5, frictionless},
                                               {"dart_lemke", 5, frictionless}};
  return slow;
}

void add_unasked(const std::string& name, std::int64_t trials, std::vector<PlannedSolver>& solvers) {
  PlannedSolver solver{.spec = {name, {}}};
  for (const SlowReference& slow : slow_references()) {
    if (name != slow.name) continue;
    PlannedSolver sampled = solver;
    sampled.every = std::clamp<std::int64_t>(trials / kFewest, 1, slow.every);
    solvers.push_back(std::move(sampled));
    solver.sets = slow.quick_on;  // entries of one solver add up
  }
  solvers.push_back(std::move(solver));
}

std::vector<PlannedSolver> validation_solvers(const std::vector<Spec>& asked, std::int64_t trials) {
  std::vector<PlannedSolver> solvers;
  bool ours_asked = false;
  bool reference_asked = false;
  for (const Spec& spec : asked) {
    solvers.push_back({.spec = canonical_solver_spec(spec)});
    (is_ours(find_solver(spec.name)) ? ours_asked : reference_asked) = true;
  }
  for (const RegisteredSolver& solver : registered_solvers()) {
    const bool wanted = is_ours(solver) ? !ours_asked : !reference_asked;
    if (wanted && runs_unasked(solver)) add_unasked(solver.definition.name, trials, solvers);
  }
  return solvers;
}

std::vector<PlannedSet> default_sets() {
  std::vector<PlannedSet> sets;
  for (const DefaultSet& set : kDefaultSets) {
    sets.push_back({.pattern = set.pattern});
    if (set.share < 1) sets.back().share = set.share;
  }
  return sets;
}

struct Contender {
  std::string text;
  bool ours = false;
};

/// One answer to the problem at hand.
struct Entry {
  std::size_t solver = 0;  ///< of the study
  StoredAnswer answer;
  Standing standing = Standing::kSilent;
};

/// Problems whose truth does not hang on a solver's answer.
std::unordered_set<std::int64_t> problems_of_known_truth(Store& store) {
  std::unordered_set<std::int64_t> known;
  sqlite::Statement query(store.database(),
                          "SELECT id FROM problems WHERE theory = 'solvable' UNION "
                          "SELECT problem_id FROM certificates WHERE certificate <> 'open' UNION "
                          "SELECT problem_id FROM verdicts WHERE farkas_checked = 1");
  while (query.step()) known.insert(query.integer(0));
  return known;
}

std::unordered_set<std::int64_t> problems_solvable_by_theory(Store& store) {
  std::unordered_set<std::int64_t> solvable;
  store.for_each_problem([&](const ProblemRow& row) {
    if (row.theory == "solvable") solvable.insert(row.id);
  });
  return solvable;
}

/// Goes through a store problem by problem.
class Comparer {
 public:
  Comparer(const Study& study, Store& store)
      : study_(study),
        store_(store),
        truth_known_(problems_of_known_truth(store)),
        definite_(problems_solvable_by_theory(store)) {
    for (std::size_t i = 0; i < study.solvers.size(); ++i) {
      const SolverRow& row = study.solvers[i].row;
      contenders_.push_back({row.text(), is_ours(find_solver(row.name))});
      solver_of_.emplace(row.id(), i);
    }
    for (std::size_t set = 0; set < study.sets.size(); ++set) {
      for (std::int64_t trial = 0; trial < study.sets[set].trials; ++trial) {
        problems_.emplace(problem_id(study.sets[set].set->name(), study.seed, trial), std::pair(set, trial));
      }
    }
    counts_.resize(study.sets.size() * contenders_.size() * (contenders_.size() + 1));
  }

  Validation run() {
    store_.for_each_answer([this](const StoredAnswer& answer) {
      if (answer.problem_id != problem_) compare_entries();
      problem_ = answer.problem_id;
      const auto solver = solver_of_.find(answer.solver_id);
      if (solver == solver_of_.end() || answer.claim == Claim::kUnsupported) return;
      if (!planned(solver->second)) return;
      entries_.push_back({solver->second, answer, standing(answer.claim, answer.verdict)});
    });
    compare_entries();
    return result();
  }

 private:
  std::size_t truth_column() const { return contenders_.size(); }

  std::size_t place(std::size_t set, std::size_t native, std::size_t reference) const {
    return (set * contenders_.size() + native) * (contenders_.size() + 1) + reference;
  }

  const std::string& reference_text(std::size_t reference) const {
    static const std::string truth = kTruthReference;
    return reference == truth_column() ? truth : contenders_[reference].text;
  }

  /// A store may hold more than this study.
  bool planned(std::size_t solver) const {
    const auto problem = problems_.find(problem_);
    return problem != problems_.end() && study_.solvers[solver].takes(problem->second.first, problem->second.second);
  }

  void add(std::size_t native, std::size_t reference, PairOutcome outcome, bool silent) {
    const auto [set, trial] = problems_.at(problem_);
    counts_[place(set, native, reference)].add(outcome);
    if (outcome == PairOutcome::kAgree || silent) return;
    disagreements_.push_back({set, trial, contenders_[native].text, reference_text(reference), outcome});
  }

  void compare_entries() {
    const std::vector<Entry> entries = std::exchange(entries_, {});
    if (problems_.count(problem_) == 0) return;
    const std::vector<std::optional<VelocityAgreement::Side>> sides = velocities(entries);
    for (std::size_t n = 0; n < entries.size(); ++n) {
      const Entry& native = entries[n];
      if (!contenders_[native.solver].ours) continue;
      if (truth_known_.count(problem_) > 0) {
        add(native.solver, truth_column(), compare_standings(native.standing, Standing::kRight, true),
            native.standing == Standing::kSilent);
      }
      for (std::size_t r = 0; r < entries.size(); ++r) {
        const Entry& reference = entries[r];
        if (contenders_[reference.solver].ours) continue;
        const bool same = !sides[n] || !sides[r] || agreement_->agree(*sides[n], *sides[r]);
        const PairOutcome outcome = compare_standings(native.standing, reference.standing, same);
        add(native.solver, reference.solver, outcome, outcome == PairOutcome::kUndecided && same);
      }
    }
  }

  /// Of the solved answers, where the problem has one velocity only.
  std::vector<std::optional<VelocityAgreement::Side>> velocities(const std::vector<Entry>& entries) {
    std::vector<std::optional<VelocityAgreement::Side>> sides(entries.size());
    const auto [set, trial] = problems_.at(problem_);
    const Problem problem = study_.sets[set].set->generate(study_.seed, trial);
    if (!VelocityAgreement::applies(problem, definite_.count(problem_) > 0)) return sides;
    agreement_ = std::make_unique<VelocityAgreement>(problem);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const StoredAnswer& stored = entries[i].answer;
      if (stored.verdict != Verdict::kSolved) continue;
      const std::optional<Answer> answer = store_.answer(stored.problem_id, stored.solver_id);
      if (answer) sides[i] = agreement_->side(*answer, stored.errors);
    }
    return sides;
  }

  Validation result() {
    Validation validation;
    for (std::size_t set = 0; set < study_.sets.size(); ++set) {
      for (std::size_t native = 0; native < contenders_.size(); ++native) {
        for (std::size_t reference = 0; reference <= truth_column(); ++reference) {
          PairCounts& pair = counts_[place(set, native, reference)];
          if (pair.compared() == 0) continue;
          pair.set = study_.sets[set].set->name();
          pair.native = contenders_[native].text;
          pair.reference = reference_text(reference);
          validation.pairs.push_back(std::move(pair));
        }
      }
    }
    validation.disagreements = std::move(disagreements_);
    const auto key = [](const Disagreement& d) { return std::tie(d.set, d.trial, d.native, d.reference); };
    std::sort(validation.disagreements.begin(), validation.disagreements.end(),
              [&](const Disagreement& a, const Disagreement& b) { return key(a) < key(b); });
    return validation;
  }

  const Study& study_;
  Store& store_;
  std::unordered_set<std::int64_t> truth_known_;
  std::unordered_set<std::int64_t> definite_;
  std::vector<Contender> contenders_;
  std::unordered_map<std::int64_t, std::size_t> solver_of_;
  std::unordered_map<std::int64_t, std::pair<std::size_t, std::int64_t>> problems_;
  std::vector<PairCounts> counts_;  ///< by set, native, reference; the truth is the last reference
  std::vector<Disagreement> disagreements_;
  std::int64_t problem_ = -1;
  std::vector<Entry> entries_;
  std::unique_ptr<VelocityAgreement> agreement_;
};

}  // namespace

Standing standing(Claim claim, Verdict verdict) {
  if (verdict == Verdict::kWrong) return Standing::kWrong;
  const bool proven_unsolvable = claim == Claim::kUnsolvable && verdict == Verdict::kUnsolvable;
  return verdict == Verdict::kSolved || proven_unsolvable ? Standing::kRight : Standing::kSilent;
}

const char* to_string(PairOutcome outcome) {
  switch (outcome) {
    case PairOutcome::kAgree: return "agree";
    case PairOutcome::kNativeWrong: return "native_wrong";
    case PairOutcome::kReferenceWrong: return "reference_wrong";
    case PairOutcome::kBothWrong: return "both_wrong";
    case PairOutcome::kUndecided: break;
  }
  return "undecided";
}

PairOutcome compare_standings(Standing native, Standing reference, bool same_velocity) {
  const bool native_wrong = native == Standing::kWrong;
  const bool reference_wrong = reference == Standing::kWrong;
  if (native_wrong && reference_wrong) return PairOutcome::kBothWrong;
  if (native_wrong) return PairOutcome::kNativeWrong;
  if (reference_wrong) return PairOutcome::kReferenceWrong;
  const bool both_right = native == Standing::kRight && reference == Standing::kRight;
  return both_right && same_velocity ? PairOutcome::kAgree : PairOutcome::kUndecided;
}

std::int64_t PairCounts::compared() const { return std::accumulate(counts.begin(), counts.end(), std::int64_t{0}); }

bool PairCounts::ours_wrong() const { return count(PairOutcome::kNativeWrong) + count(PairOutcome::kBothWrong) > 0; }

bool Validation::ours_wrong() const {
  return std::any_of(pairs.begin(), pairs.end(), [](const PairCounts& pair) { return pair.ours_wrong(); });
}

std::vector<PairCounts> summed(const std::vector<PairCounts>& pairs,
                               const std::function<bool(const PairCounts&, const PairCounts&)>& same) {
  std::vector<PairCounts> sums;
  for (const PairCounts& pair : pairs) {
    auto known = std::find_if(sums.begin(), sums.end(), [&](const PairCounts& sum) { return same(sum, pair); });
    if (known == sums.end()) {
      known = sums.insert(sums.end(), PairCounts{.set = "", .native = pair.native, .reference = pair.reference});
    }
    for (std::size_t i = 0; i < pair.counts.size(); ++i) known->counts[i] += pair.counts[i];
  }
  return sums;
}

std::vector<PairCounts> over_all_sets(const std::vector<PairCounts>& pairs) {
  return summed(pairs, [](const PairCounts& a, const PairCounts& b) {
    return a.native == b.native && a.reference == b.reference;
  });
}

bool is_ours(const RegisteredSolver& solver) { return solver.native() || solver.definition.name == kOursInAWorker; }

Plan validation_plan(const std::vector<Spec>& asked, const std::vector<std::string>& sets, std::int64_t trials) {
  Plan plan;
  plan.name = "validate";
  plan.trials = trials;
  plan.time_limit_s = kTimeLimitS;
  plan.repeat_until_s = 0;
  plan.solvers = validation_solvers(asked, trials);
  plan.other_sets = true;  // that a slow reference is quick on a set says nothing about what is asked for
  if (sets.empty()) plan.sets = default_sets();
  for (const std::string& set : sets) plan.sets.push_back({.pattern = set});
  return plan;
}

Validation validate(const Study& study, Store& store) { return Comparer(study, store).run(); }

}  // namespace lcpbench
