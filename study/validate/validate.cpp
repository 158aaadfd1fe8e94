#include "study/validate/validate.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "study/report/tables.h"
#include "study/run/open_solver.h"
#include "study/validate/velocity_agreement.h"

namespace lcpbench {

extern const std::string_view kValidateTables;  // validate.sql, by CMake

namespace {

using Json = nlohmann::ordered_json;

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

/// The answers of a study that a store holds, in the tables of study/validate/validate.sql.
class Comparer {
 public:
  Comparer(const Study& study, Store& store)
      : study_(study),
        store_(store),
        made_("validate", sqlite::Mode::kInMemory),
        definite_(problems_where(store, "theory = 'solvable'")) {
    made_.execute(std::string(kValidateTables));
    sqlite::Statement add(made_, "INSERT INTO solvers VALUES (?, ?, ?)");
    for (std::size_t i = 0; i < study.solvers.size(); ++i) {
      const SolverRow& row = study.solvers[i].row;
      add.run(i, std::string_view(row.text()), is_ours(find_solver(row.name)));
      solver_of_.emplace(row.id(), i);
    }
    add.run(study.solvers.size(), std::string_view(kTruthReference), false);
    for (std::size_t set = 0; set < study.sets.size(); ++set) {
      const std::string name = study.sets[set].set->name();
      sqlite::Statement(made_, "INSERT INTO sets VALUES (?, ?)").run(set, std::string_view(name));
      for (std::int64_t trial = 0; trial < study.sets[set].trials; ++trial) {
        problems_.emplace(problem_id(name, study.seed, trial), std::pair(set, trial));
      }
    }
    for (const std::int64_t problem : problems_where(
             store,
             "theory = 'solvable' OR EXISTS (SELECT 1 FROM certificates WHERE problem_id = id AND certificate <> "
             "'open') OR EXISTS (SELECT 1 FROM verdicts WHERE problem_id = id AND farkas_checked = 1)")) {
      add_answer(problem, study.solvers.size(), "right");
    }
    store.for_each_answer([this](const StoredAnswer& answer) {
      if (!solved_.empty() && solved_.front().second.problem_id != answer.problem_id) compare_velocities();
      const auto solver = solver_of_.find(answer.solver_id);
      if (solver == solver_of_.end() || answer.claim == Claim::kUnsupported) return;
      const auto problem = problems_.find(answer.problem_id);  // a store may hold more than this study
      if (problem == problems_.end()) return;
      const auto& [set, trial] = problem->second;
      if (!study_.solvers[solver->second].takes(set, trial)) return;
      add_answer(answer.problem_id, solver->second, standing(answer.claim, answer.verdict));
      if (answer.verdict == Verdict::kSolved) solved_.emplace_back(solver->second, answer);
    });
    compare_velocities();
  }

  Json rows(std::string_view sql) { return report::records_of(report::run_query(made_, "validate", sql)); }

 private:
  static std::unordered_set<std::int64_t> problems_where(Store& store, const std::string& condition) {
    std::unordered_set<std::int64_t> problems;
    sqlite::Statement query(store.database(), "SELECT id FROM problems WHERE " + condition);
    while (query.step()) problems.insert(query.integer(0));
    return problems;
  }

  void add_answer(std::int64_t problem, std::size_t solver, std::string_view standing) {
    const auto known = problems_.find(problem);
    if (known == problems_.end()) return;
    sqlite::Statement(made_, "INSERT INTO answers VALUES (?, ?, ?, ?, ?)")
        .run(problem, solver, known->second.first, known->second.second, standing);
  }

  /// Of the solved answers, where the problem has one velocity only.
  void compare_velocities() {
    const auto solved = std::exchange(solved_, {});
    if (solved.size() < 2) return;
    const std::int64_t id = solved.front().second.problem_id;
    const auto& [set, trial] = problems_.at(id);
    const Problem problem = study_.sets[set].set->generate(study_.seed, trial);
    if (!VelocityAgreement::applies(problem, definite_.contains(id))) return;
    const VelocityAgreement agreement(problem);
    std::vector<std::pair<std::size_t, VelocityAgreement::Side>> sides;
    for (const auto& [solver, stored] : solved) {
      const std::optional<Answer> answer = store_.answer(id, stored.solver_id);
      if (answer) sides.emplace_back(solver, agreement.side(*answer, stored.errors));
    }
    sqlite::Statement add(made_, "INSERT INTO other_velocities VALUES (?, ?, ?)");
    for (const auto& [a, own] : sides) {
      for (const auto& [b, other] : sides) {
        if (a != b && !agreement.agree(own, other)) add.run(id, a, b);
      }
    }
  }

  const Study& study_;
  Store& store_;
  sqlite::Database made_;
  std::unordered_set<std::int64_t> definite_;
  std::unordered_map<std::int64_t, std::size_t> solver_of_;
  std::unordered_map<std::int64_t, std::pair<std::size_t, std::int64_t>> problems_;
  std::vector<std::pair<std::size_t, StoredAnswer>> solved_;  ///< to the problem at hand, verified
};

}  // namespace

const char* standing(Claim claim, Verdict verdict) {
  if (verdict == Verdict::kWrong) return "wrong";
  const bool proven_unsolvable = claim == Claim::kUnsolvable && verdict == Verdict::kUnsolvable;
  return verdict == Verdict::kSolved || proven_unsolvable ? "right" : "silent";
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

Validation validate(const Study& study, Store& store) {
  Comparer comparer(study, store);
  return {.pairs = comparer.rows("SELECT * FROM pairs"),
          .over_sets = comparer.rows("SELECT * FROM over_sets"),
          .totals = comparer.rows("SELECT * FROM totals"),
          .disagreements = comparer.rows("SELECT * FROM disagreements")};
}

bool Validation::ours_wrong() const {
  return std::any_of(pairs.begin(), pairs.end(),
                     [](const Json& pair) { return pair["native_wrong"] != 0 || pair["both_wrong"] != 0; });
}

}  // namespace lcpbench
