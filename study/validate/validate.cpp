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

extern const std::string_view kValidateTables, kValidatePlan;  // validate.sql and plan.json, by CMake

namespace {

using Json = nlohmann::ordered_json;

/// Our interior point over CHOLMOD: the library factorizes, the method is ours.
constexpr const char* kOursInAWorker = "velocity_ipm_cholmod";

/// A slow reference gets at least this number of problems of each set, or all problems of a smaller set.
constexpr std::int64_t kFewest = 20;

/// What the plan says of a solver; one that it does not name runs on everything.
void add_unasked(const std::string& name, const Plan& plan, std::vector<PlannedSolver>& solvers) {
  const std::size_t before = solvers.size();
  for (PlannedSolver entry : plan.solvers) {
    if (entry.spec.name != name) continue;
    entry.every = std::clamp<std::int64_t>(plan.trials / kFewest, 1, entry.every);
    solvers.push_back(std::move(entry));  // entries of one solver add up
  }
  if (solvers.size() == before) solvers.push_back({.spec = {name, {}}});
}

std::vector<PlannedSolver> validation_solvers(const std::vector<Spec>& asked, const Plan& plan) {
  std::vector<PlannedSolver> solvers;
  bool ours_asked = false;
  bool reference_asked = false;
  for (const Spec& spec : asked) {
    solvers.push_back({.spec = canonical_solver_spec(spec)});
    (is_ours(find_solver(spec.name)) ? ours_asked : reference_asked) = true;
  }
  for (const RegisteredSolver& solver : registered_solvers()) {
    const bool wanted = is_ours(solver) ? !ours_asked : !reference_asked;
    if (wanted && runs_unasked(solver)) add_unasked(solver.definition.name, plan, solvers);
  }
  return solvers;
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

  /// How often our solvers and the references came out each way. @param keys  one row for each of their values
  Json outcomes(const std::string& names, const std::string& keys) {
    return rows(
        "SELECT " + names +
        ", COUNT(*) AS compared, SUM(outcome = 'agree') AS agree, SUM(outcome = 'native_wrong') AS native_wrong, "
        "SUM(outcome = 'reference_wrong') AS reference_wrong, SUM(outcome = 'both_wrong') AS both_wrong, "
        "SUM(outcome = 'undecided') AS undecided FROM met GROUP BY " +
        keys + " ORDER BY " + keys);
  }

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
  Plan plan = parse_plan(kValidatePlan, "study/validate/plan.json");
  plan.trials = trials;
  plan.solvers = validation_solvers(asked, plan);
  plan.other_sets = true;  // that a slow reference is quick on a set says nothing about what is asked for
  if (!sets.empty()) plan.sets.clear();
  for (const std::string& set : sets) plan.sets.push_back({.pattern = set});
  return plan;
}

Validation validate(const Study& study, Store& store) {
  Comparer comparer(study, store);
  return {.pairs = comparer.outcomes("\"set\", native, reference", "set_place, native_place, reference_place"),
          .over_sets = comparer.outcomes("native, reference", "native_place, reference_place"),
          .totals = comparer.outcomes("native, printf('%d reference%s', COUNT(DISTINCT reference), "
                                      "iif(COUNT(DISTINCT reference) = 1, '', 's')) AS reference",
                                      "native_place"),
          .disagreements = comparer.rows("SELECT * FROM disagreements")};
}

bool Validation::ours_wrong() const {
  return std::any_of(pairs.begin(), pairs.end(),
                     [](const Json& pair) { return pair["native_wrong"] != 0 || pair["both_wrong"] != 0; });
}

}  // namespace lcpbench
