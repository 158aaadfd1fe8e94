// The interface that users' scripts rely on: the fields of every JSON document, and the bound of the verdict.

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/store/store.h"
#include "tests/support/program_test.h"

namespace lcpbench::documents_test {
namespace {

using nlohmann::json;

/// Checks that an object has exactly these fields, "name:type name:type ...": s text, n number, b boolean, o object, a
/// array; behind a question mark the field may be null.
void expect_fields(const json& object, const std::string& fields) {
  ASSERT_TRUE(object.is_object());
  std::istringstream words(fields);
  std::size_t count = 0;
  for (std::string word; words >> word; ++count) {
    const std::string name = word.substr(0, word.find(':'));
    const char type = word[name.size() + 1];
    ASSERT_TRUE(object.contains(name)) << name << " is missing in " << object.dump();
    const json& value = object.at(name);
    const bool right = (type == 's' && value.is_string()) || (type == 'n' && value.is_number()) ||
                       (type == 'b' && value.is_boolean()) || (type == 'o' && value.is_object()) ||
                       (type == 'a' && value.is_array()) || (word.ends_with('?') && value.is_null());
    EXPECT_TRUE(right) << name << " = " << value.dump();
  }
  EXPECT_EQ(object.size(), count) << object.dump();
}

class DocumentsTest : public ProgramTest {
 protected:
  void write_oblique_point() {
    write_problem_of("oblique.json", R"("kind": "contact", "v": [3, 4, -1], "N": [[0], [0], [1]], "edges": [4],
        "mu": [0.5], "D": [[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 0, 0]], "G": [[2, 0, 0], [0, 2, 0], [0, 0, 2]])");
  }
};

/// A point of mass 2 that slides between two of its four edges.
TEST_F(DocumentsTest, ModelsJson) {
  write_oblique_point();
  const json documents = run_json("models oblique.json");
  ASSERT_EQ(documents.size(), 1U);
  expect_fields(documents[0], "problem:o islands:a models:a");
  std::vector<std::string> names;
  for (const json& model : documents[0]["models"]) {
    expect_fields(model,
                  "model:s claim:s error_m_per_s:n? solver_error_m_per_s:n? velocity_difference_m_per_s:n? time_s:n? "
                  "passes:n islands:a");
    names.push_back(model["model"]);
  }
  const std::vector<std::string> expected{"nothing", "normals",   "rest", "4",       "4-turned",   "8",   "8-turned",
                                          "16",      "16-turned", "soft", "relaxed", "cone-rough", "cone"};
  EXPECT_EQ(names, expected);
  EXPECT_NEAR(documents[0]["models"][3]["velocity_difference_m_per_s"].get<double>(), 0.3, 1e-6);
  done("models oblique.json");
}

TEST_F(DocumentsTest, SolveHasTheModelsErrorAndTheSolvers) {
  write_oblique_point();
  const json models = run_json("models oblique.json")[0]["models"];
  const json rows = run_json("solve oblique.json --solver lemke --solver 'cone_ipm{cone=true}'");
  ASSERT_EQ(rows.size(), 2U);
  for (const json& row : rows) {
    const double total = row["errors"]["model_error_m_per_s"];
    const double solvers = row["errors"]["velocity_residual_m_per_s"];
    EXPECT_LT(solvers, 1e-6) << row["solver"];
    if (row["model"] == "cone") {
      EXPECT_EQ(total, solvers);
    } else {
      EXPECT_NEAR(total, models[3]["error_m_per_s"].get<double>(), 1e-12);  // of four edges
      EXPECT_GT(total, 0.1);
    }
  }
}

TEST_F(DocumentsTest, SolveWithAVelocityErrorJson) {
  write_oblique_point();
  const json rows = run_json("solve oblique.json --max-velocity-error 1e-3");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["model"], "cone");
  EXPECT_EQ(rows[0]["claim"], "solved");
  EXPECT_TRUE(rows[0]["met"].get<bool>());
  EXPECT_LE(rows[0]["errors"]["velocity_residual_m_per_s"].get<double>(), 1e-3);
  EXPECT_NEAR(rows[0]["velocity"][0].get<double>(), 2.7, 2e-3);
  EXPECT_EQ(rows[0]["islands"][0]["model"], "cone-rough");
  // What no model reaches is not claimed.
  const ProgramRun missed = run("solve oblique.json --max-velocity-error 1e-12 --time-limit 1e-6 --format json");
  EXPECT_EQ(missed.exit_code, 1) << missed.err;
  EXPECT_FALSE(json::parse(missed.out)[0]["met"].get<bool>());
}

TEST_F(DocumentsTest, SolversJson) {
  const json solvers = run_json("solvers");
  std::vector<std::string> names;
  for (const json& solver : solvers) {
    expect_fields(solver,
                  "name:s summary:s source:s origin:s library:s version:s available:b reason:s needs:s "
                  "frictionless_only:b friction_setting:s max_size:n? max_entries:n guarantees:s settings:a");
    EXPECT_EQ(solver["available"].get<bool>(), solver["reason"].get<std::string>().empty());
    for (const json& setting : solver["settings"]) {
      expect_fields(setting, "name:s type:s default:s range:s help:s");
    }
    names.push_back(solver["name"]);
  }
  for (const char* name : {"lemke", "primal_dual", "regularized", "murty", "bullet_dantzig", "bullet_lemke", "ipopt_qp",
                           "ipopt_mpcc", "ode_quickstep"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
}

TEST_F(DocumentsTest, SetsJson) {
  const json sets = run_json("sets 'paper/*/exp1'");
  ASSERT_EQ(sets.size(), 2U);
  for (const json& set : sets) {
    expect_fields(set, "name:s size:s source:s summary:s options:a");
  }
}

TEST_F(DocumentsTest, SolveJson) {
  done("generate paper/monotone/exp1 --seed 1 --count 1 --out m");
  write_problem_of("lcp.json", R"("kind": "lcp", "M": [[2, 1], [1, 2]], "q": [-5, -6])");
  const json rows = run_json("solve m/000000.json lcp.json --solver lemke --solver 'lemke{engine=dense}'");
  ASSERT_EQ(rows.size(), 4U);
  for (const json& row : rows) {
    expect_fields(row,
                  "problem:o solver:s settings:s label:s model:s claim:s verdict:s truth:s least_violation_m_per_s:n? why:s "
                  "z:a? velocity:a? errors:o time:o counters:o impulses:s rows:a? detail:s");
    expect_fields(row["problem"], "name:s kind:s n:n ngc:n? nc:n? edges:a? rows:n?");
    expect_fields(row["errors"],
                  "velocity_residual_m_per_s:n? velocity_residual_relative:n? model_error_m_per_s:n? "
                  "natural_residual:n? backward_row_norm:n? forward_velocity:n? violation_m_per_s:n? work_gain_j:n? "
                  "complementarity_j:n? cone_violation:n? min_z:n? returned_velocity_error:n? "
                  "least_violation_m_per_s:n? proof_margin:n? optimum_distance:n? velocity_mismatch:n? worst_row:n? "
                  "contact_residual_m_per_s:n? worst_bounded_row:o?");
    expect_fields(row["time"], "setup_s:n solve_s:n verify_s:n");
    expect_fields(row["counters"], "iterations:n? pivots:n? factorizations:n?");
    for (const json& count : row["counters"]) EXPECT_TRUE(count.is_null() || count.get<std::int64_t>() >= 0) << count;
    EXPECT_EQ(row["verdict"], "solved");
  }
  const json& lcp = rows[2];
  EXPECT_EQ(lcp["problem"]["name"], "made");
  EXPECT_TRUE(lcp["velocity"].is_null());
  ASSERT_EQ(lcp["z"].size(), 2U);
  EXPECT_NEAR(lcp["z"][0].get<double>(), 4.0 / 3.0, 1e-14);  // the 2 x 2 system by hand
  EXPECT_NEAR(lcp["z"][1].get<double>(), 7.0 / 3.0, 1e-14);
  EXPECT_EQ(rows[0]["velocity"].size(), rows[0]["problem"]["ngc"].get<std::size_t>());
}

TEST_F(DocumentsTest, CertifyJson) {
  done("generate paper/monotone/exp1 --seed 1 --count 1 --out m");
  write_problem_of("lcp.json", R"("kind": "lcp", "M": [[2, 1], [1, 2]], "q": [-5, -6])");
  const std::string fields = "problem:o certificate:s proof:s z:a? velocity:a? velocity_unique:b? farkas:a? seconds:n";
  const json rows = run_json("certify m/000000.json lcp.json");
  ASSERT_EQ(rows.size(), 2U);
  for (const json& row : rows) {
    expect_fields(row, fields);
    EXPECT_EQ(row["certificate"], "solution");
    EXPECT_EQ(row["proof"], "exact_basis");
    EXPECT_EQ(row["z"].size(), row["problem"]["n"]);
    EXPECT_TRUE(row["farkas"].is_null());
  }
  EXPECT_EQ(rows[0]["velocity"].size(), rows[0]["problem"]["ngc"]);
  EXPECT_EQ(rows[0]["velocity_unique"], true);
  EXPECT_TRUE(rows[1]["velocity"].is_null() && rows[1]["velocity_unique"].is_null());
  const json exact = run_json("certify lcp.json --exact")[0];
  expect_fields(exact, fields + " z_exact:a velocity_exact:a? farkas_exact:a?");
  EXPECT_EQ(exact["z_exact"], json({"4/3", "7/3"}));
}

TEST_F(DocumentsTest, BenchJson) {
  const json bench = run_json("bench --set paper/monotone/exp1 --solver lemke --problems 5");
  expect_fields(bench, "provenance:o reference:s isa:s cells:a");
  EXPECT_EQ(bench["reference"], "lemke{engine=dense}");
  ASSERT_EQ(bench["cells"].size(), 1U);
  const json& cell = bench["cells"][0];
  expect_fields(cell,
                "set:s solver:s settings:s problems:n timed:n speedup_mean:n? speedup_geomean:n? speedup_low:n? "
                "speedup_high:n? reference_mean_s:n? solver_mean_s:n?");
  EXPECT_EQ(cell["timed"], 5);
  EXPECT_NEAR(cell["speedup_mean"].get<double>(),
              cell["reference_mean_s"].get<double>() / cell["solver_mean_s"].get<double>(), 1e-6);
  EXPECT_LE(cell["speedup_low"].get<double>(), cell["speedup_mean"].get<double>());
}

TEST_F(DocumentsTest, BenchTimesOnlyWhatBothSolved) {
  const json bench = run_json("bench --set paper/monotone/exp1 --solver 'lemke{max_pivots=1}' --problems 12");
  const json& cell = bench["cells"][0];
  EXPECT_EQ(cell["problems"], 12);
  EXPECT_LT(cell["timed"].get<int>(), 12);
}

TEST_F(DocumentsTest, ProvenanceSaysWhereResultsComeFrom) {
  done("run --set paper/monotone/exp1 --solver lemke --trials 12 --seed 3 --store a.db");
  Store store = Store::open_for_reading(folder_ / "a.db");
  const json provenance = json::parse(store.runs().at(0));
  expect_fields(provenance,
                "lcpbench:s commit:s compiler:s flags:s build_type:s processor:s isa:s cores:n os:s kernel:s sqlite:s "
                "libraries:o solvers:o command:s started:s plan:o planned:o seed:n jobs:n shard:s skipped:a");
  EXPECT_EQ(provenance["plan"]["trials"], 12);
  EXPECT_EQ(provenance["seed"], 3);
  EXPECT_NE(provenance["command"].get<std::string>().find("--trials 12"), std::string::npos);
}

// psor leaves some 1e-11 here.
TEST_F(DocumentsTest, AnotherBoundOfTheVerdictCanBeAskedFor) {
  write_problem_of("two.json", R"("kind": "lcp", "M": [[2, 1], [1, 3]], "q": [-4, -5])");
  EXPECT_EQ(run_json("solve two.json --solver psor")[0]["verdict"], "solved");
  const json strict = run_json("solve two.json --solver psor --solved-at 1e-14");
  EXPECT_EQ(strict[0]["verdict"], "wrong");
  EXPECT_TRUE(contains(strict[0]["why"], "the limit is 1e-14")) << strict[0]["why"];

  const std::string study = "run --set file:two.json --solver psor --store ";
  done(study + "strict.db --solved-at 1e-14");
  done(study + "usual.db");
  const auto verdict = [&](const std::string& store) {
    return sqlite::Database(folder_ / store, sqlite::Mode::kReadOnly).texts("SELECT verdict FROM judged");
  };
  EXPECT_EQ(verdict("strict.db"), std::vector<std::string>{"wrong"});
  EXPECT_EQ(verdict("usual.db"), std::vector<std::string>{"solved"});
  done(study + "strict.db --solved-at 1e-14");
  expect_mistake(study + "strict.db");
  EXPECT_TRUE(contains(read("err"), "judged by --solved-at 1e-14 so far, not by the default bound")) << read("err");
  expect_mistake(study + "usual.db --solved-at 1e-14");
  for (const std::string how : {"", " --mixed"}) {
    expect_mistake("merge both.db strict.db usual.db" + how);
    EXPECT_TRUE(contains(read("err"), "plan/solved_at")) << read("err");
  }
}

}  // namespace
}  // namespace lcpbench::documents_test
