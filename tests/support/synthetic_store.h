#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "study/store/store.h"
#include "tests/support/study_support.h"

namespace lcpbench {

/// What one solver is made to answer on one problem of a store written by hand.
struct MadeAnswer {
  Claim claim = Claim::kSolved;
  double error = 1e-12;  ///< relative velocity residual; NaN: no usable answer
  bool criterion = true;
  bool proves_unsolvable = false;
  double time_s = 1e-3;  ///< set-up takes a quarter of it
  double violation_m_per_s = 1e-10;
  double solver_error_m_per_s = Errors::kNone;
  double model_error_m_per_s = Errors::kNone;
  const char* detail = "";
};

/// A store filled by hand: known rows in, so that what comes out of a summary can be worked out on paper.
class SyntheticStore {
 public:
  /// @param planned  what the store's run planned, JSON as planned_cells() gives it; "": nothing is recorded
  explicit SyntheticStore(const std::filesystem::path& file, const std::string& planned = "")
      : store_(Store::open_for_writing(file)) {
    store_.begin();
    store_.add_run("2026-01-31T12:00:00Z",
                   R"({"processor": "test processor", "isa": "baseline", "seed": 1, "compiler": "test compiler",)" +
                       (planned.empty() ? "" : " \"planned\": " + planned + ",") +
                       R"( "command": "lcpbench run quick", "skipped": ["absent_solver: library not found"]})");
    store_.commit();
  }

  Store& store() { return store_; }

  std::int64_t solver(const std::string& name, const std::string& settings = "", const std::string& sweep = "",
                      const std::string& library = "native") {
    SolverRow row{name,    settings, settings.empty() ? "engine=dense" : settings,
                  library, "1.0",    library == "native" ? "baseline" : "",
                  sweep,   settings == "cone=true"      ? FrictionModel::kCone
                           : settings == "slip=none" ? FrictionModel::kConvex
                                                     : FrictionModel::kPyramid};
    store_.begin();
    const std::int64_t id = store_.add_solver(row);
    store_.commit();
    return id;
  }

  /// Answers of several solvers to one problem. `friction_rows` beyond the contacts make it frictional; a theory of
  /// "solvable" says that the data prove it so.
  void problem(const std::string& set, std::int64_t trial,
               const std::vector<std::pair<std::int64_t, MadeAnswer>>& answers, int friction_rows = 0,
               const std::string& theory = "solvable", const std::string& kind = "contact", std::uint64_t seed = 1) {
    store_.begin();
    store_.add(result(set, trial, answers, friction_rows, theory, kind, seed));
    store_.commit();
  }

  /// The same, not yet in the store.
  ProblemResult result(const std::string& set, std::int64_t trial,
                       const std::vector<std::pair<std::int64_t, MadeAnswer>>& answers, int friction_rows,
                       const std::string& theory, const std::string& kind, std::uint64_t seed = 1) {
    ProblemResult result;
    result.problem = {problem_id(set, seed, trial),
                      store_.add_set(set),
                      seed,
                      trial,
                      kind,
                      5 + friction_rows,
                      6,
                      kind == "lcp" ? 0 : 5,
                      kind == "scene",
                      "00",
                      theory};
    for (const auto& [solver, answer] : answers) result.answers.push_back(row(solver, answer, kind == "lcp"));
    return result;
  }

 private:
  static AnswerRow row(std::int64_t solver, const MadeAnswer& answer, bool bare) {
    AnswerRow row;
    row.solver_id = solver;
    row.claim = answer.claim;
    row.detail = answer.detail;
    row.farkas_checked = answer.proves_unsolvable;
    row.errors.usable = !std::isnan(answer.error);
    if (bare) {
      row.errors.backward_row_norm = answer.error;
    } else {
      row.errors.velocity_residual_relative = answer.error;
      row.errors.velocity_residual_m_per_s = answer.solver_error_m_per_s;
      row.errors.model_error_m_per_s = answer.model_error_m_per_s;
      row.errors.violation_m_per_s = row.errors.usable ? answer.violation_m_per_s : Errors::kNone;
    }
    row.errors.solved = answer.error <= (bare ? kSolvedBackwardError : kSolvedVelocityResidual);
    row.errors.criterion = row.errors.usable && answer.criterion && !bare;
    row.times.setup_cpu_s = row.times.setup_wall_s = answer.time_s / 4;
    row.times.solve_cpu_s = row.times.solve_wall_s = 3 * answer.time_s / 4;
    return row;
  }

  Store store_;
};

}  // namespace lcpbench
