#include "study/validate/validate.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "study/report/tables.h"
#include "study/run/open_solver.h"
#include "study/validate/velocity_agreement.h"

namespace lcpbench {

extern const std::string_view kValidateTables, kValidatePlan;  // validate.sql and plan.json, by CMake

namespace {

/// Our interior point over CHOLMOD: the library factorizes, the method is ours.
constexpr const char* kOursInAWorker = "velocity_ipm_cholmod";

/// A slow reference gets at least this number of problems of each set, or all problems of a smaller set.
constexpr std::int64_t kFewest = 20;

/// What the plan says of a solver; one that it does not name runs on everything.
void add_unasked(const std::string& name, const Plan& plan, std::vector<PlannedSolver>& solvers) {
  const std::size_t before = solvers.size();
  for (const PlannedSolver& entry : plan.solvers) {
    if (entry.spec.name == name) solvers.push_back(entry);  // entries of one solver add up
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

/// Fills `other_velocities` of study/validate/validate.sql.
void compare_velocities(const Study& study, Store& store) {
  sqlite::Statement problems(
      store.database(), "SELECT problem, \"set\", trial FROM verified GROUP BY problem HAVING COUNT(*) > 1");
  sqlite::Statement answers(store.database(),
                            "SELECT place, id, complementarity_j, violation_m_per_s, min_z FROM verified "
                            "WHERE problem = ? ORDER BY place");
  sqlite::Statement add(store.database(), "INSERT INTO other_velocities VALUES (?, ?, ?)");
  while (problems.step()) {
    const std::int64_t id = problems.integer(0);
    const ProblemSet& set = *study.sets[static_cast<std::size_t>(problems.integer(1))].set;
    const Problem problem = set.generate(study.seed, problems.integer(2));
    if (!VelocityAgreement::applies(problem, true)) continue;
    const VelocityAgreement agreement(problem);
    std::vector<std::pair<std::int64_t, VelocityAgreement::Side>> sides;
    answers.bind(1, id);
    while (answers.step()) {
      Errors errors;
      answers.read(2, errors.complementarity_j, errors.violation_m_per_s, errors.min_z);
      const std::optional<Answer> answer = store.answer(id, answers.integer(1));
      if (answer) sides.emplace_back(answers.integer(0), agreement.side(*answer, errors));
    }
    answers.reset();
    for (const auto& [a, own] : sides) {
      for (const auto& [b, other] : sides) {
        if (a != b && !agreement.agree(own, other)) add.run(id, a, b);
      }
    }
  }
}

}  // namespace

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

Study validation_study(const Plan& plan) {
  Study study = resolve(plan);
  for (StudySolver& solver : study.solvers) {
    for (std::size_t set = 0; set < study.sets.size(); ++set) {
      for (std::int64_t& step : solver.every[set]) {
        step = std::clamp<std::int64_t>(study.sets[set].trials / kFewest, 1, step);
      }
    }
  }
  return study;
}

Validation validate(const Study& study, Store& store) {
  Json sets = Json::array();
  for (const StudySet& each : study.sets) {
    const std::string name = each.set->name();
    const auto seed = static_cast<std::int64_t>(study.seed);
    sets.push_back(
        {{"place", sets.size()}, {"id", set_id(name)}, {"name", name}, {"seed", seed}, {"trials", each.trials}});
  }
  Json solvers = Json::array();
  for (const StudySolver& each : study.solvers) {
    const bool ours = is_ours(find_solver(each.row.name));
    solvers.push_back(
        {{"place", solvers.size()}, {"id", each.row.id()}, {"name", each.row.text()}, {"ours", ours}});
  }
  solvers.push_back({{"place", solvers.size()}, {"id", nullptr}, {"name", kTruthReference}, {"ours", false}});
  report::fill_table(store.database(), "study_sets", sets);
  report::fill_table(store.database(), "study_solvers", solvers);
  store.database().execute(std::string(kValidateTables));
  compare_velocities(study, store);
  const auto rows = [&store](const std::string& sql) {
    return report::records_of(report::run_query(store.database(), "validate", sql));
  };
  const auto outcomes = [&rows](const std::string& names, const std::string& keys) {
    return rows(
        "SELECT " + names +
        ", COUNT(*) AS compared, SUM(outcome = 'agree') AS agree, SUM(outcome = 'native_wrong') AS native_wrong, "
        "SUM(outcome = 'reference_wrong') AS reference_wrong, SUM(outcome = 'both_wrong') AS both_wrong, "
        "SUM(outcome = 'undecided') AS undecided FROM met GROUP BY " +
        keys + " ORDER BY " + keys);
  };
  return {.pairs = outcomes("\"set\", native, reference", "set_place, native_place, reference_place"),
          .over_sets = outcomes("native, reference", "native_place, reference_place"),
          .totals = outcomes("native, printf('%d reference%s', COUNT(DISTINCT reference), "
                             "iif(COUNT(DISTINCT reference) = 1, '', 's')) AS reference",
                             "native_place"),
          .disagreements = rows("SELECT * FROM disagreements")};
}

bool Validation::ours_wrong() const {
  return std::any_of(pairs.begin(), pairs.end(),
                     [](const Json& pair) { return pair["native_wrong"] != 0 || pair["both_wrong"] != 0; });
}

}  // namespace lcpbench
