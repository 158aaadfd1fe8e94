// The interface that users' scripts rely on: exit codes, one-line errors, and what commands do together.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/store/store.h"
#include "tests/support/program_test.h"

namespace lcpbench::cli_test {
namespace {

using nlohmann::json;

class CommandLineTest : public ProgramTest {};

TEST_F(CommandLineTest, MistakesOfUseExitWith2AndOneLine) {
  write_problem_of("one.json", kOneRow);
  write("b.M.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
  write("b.q.mtx", "%%MatrixMarket matrix array real general\n1 1\n1\n");
  write("plan.json", R"({"format": "lcpbench-plan", "version": 1, "name": "p",
      "sets": ["rigid/exp1"], "solvers": [{"solver": "lemke", "sets": ["rigid/*"]}]})");
  done("run --set paper/monotone/exp1 --solver lemke --trials 1 --store s.db");
  for (const char* arguments : {"frobnicate",
                                "frobnicate --help",
                                "run nosuch",
                                "run --shard 0/3",
                                "run --shard 4/3",
                                "run --shard 1/3x",
                                "run --list-shards 0",
                                "run --list-shards 2 --costs nosuch.db",
                                "run --trials 0",
                                "run --seed -4",
                                "run --seed 18446744073709551616",
                                "run --seed 1.5",
                                "run --budget nan",
                                "run --jobs 0",
                                "run smoke --solver nope",
                                "run smoke --solver 'lemke{foo=1}'",
                                "run smoke --set nope",
                                "run --sweep nope",
                                "run --sweep paper --solver murty",
                                "run smoke --set paper/monotone/exp1 --store .",
                                "run smoke --store /nosuchfolder/x.db",
                                "run plan.json --set planted/definite",
                                "solve",
                                "solve nosuch.json",
                                "solve nosuch.scenes#1",
                                "solve x.scenes#y",
                                "solve --format xml one.json",
                                "solve --solved-at 0 one.json",
                                "solve --solved-at nan one.json",
                                "solve --max-velocity-error nan one.json",
                                "solve --max-velocity-error 0 one.json",
                                "solve --max-velocity-error 1e-3 --solver auto one.json",
                                "solve one.json --solver 'external{command=./nowhere}'",
                                "audit nosuch.scenes",
                                "dataset d --made -1",
                                "capture stack --out y.json",
                                "models",
                                "models nosuch.json",
                                "models --max-velocity-error -1 one.json",
                                "generate",
                                "generate nope --seed 1 --count 1 --out d",
                                "generate paper/monotone/exp1 --seed 1 --count 0 --out d",
                                "generate paper/monotone/exp1 --seed 1 --count 1 --out ''",
                                "merge",
                                "merge out.db nosuch.db",
                                "merge s.db ./s.db",
                                "sets nope",
                                "sets file:nosuch",
                                "sets file:nosuch.scenes#3",
                                "sets 'paper/monotone/exp2{redundancy=nope}'",
                                "report nosuch.db --out ''",
                                "bench --solver nope",
                                "bench --problems 0",
                                "bench --problems 1 --time-limit nan",
                                "validate --solver nosuch",
                                "validate --trials 0",
                                "validate --time-limit nan",
                                "validate --store /nosuchfolder/s.db --trials 1 --solver lemke --set planted/definite",
                                "validate --out /dev/null/folder --trials 1 --solver lemke --set planted/definite",
                                "certify",
                                "certify one.json --store s.db",
                                "certify one.json --every 3",
                                "certify --store nosuch.db",
                                "certify --store s.db --exact",
                                "certify --store s.db --set paper/monotone/exp2",
                                "certify --store s.db --every 0",
                                "certify --store one.json",
                                "certify one.json --time-limit 0",
                                "certify one.json --proofs /nosuchfolder/p",
                                "certify one.json --proofs one.json",
                                "certify --store s.db --proofs ./s.db",
                                "certify b.M.mtx --proofs b.q.mtx",
                                "shrink",
                                "shrink one.json --solver lemke",
                                "shrink one.json --out small.json",
                                "shrink nosuch.json --solver lemke --out small.json",
                                "shrink one.json --solver lemke --until slow --out small.json",
                                "shrink one.json --solver lemke --out small.txt",
                                "shrink one.json --solver lemke --out one.json",
                                "shrink one.json --solver lemke --out nowhere/small.json",
                                "shrink nosuch.json --solver lemke --out /proc/small.json",
                                "shrink one.json --solver lemke --until missed --against auto --out small.json",
                                "shrink one.json --solver lemke --against lemke --out small.json",
                                "shrink one.json --solver lemke --speed -1 --out small.json",
                                "replay",
                                "replay stack --out made",
                                "replay nosuch --solver auto --out made",
                                "replay stack --solver engine --out made",
                                "replay stack --solver auto --steps 0 --out made",
                                "replay stack --solver auto --engine nosuch --out made",
                                "replay stack --solver auto --out /dev/null/out"}) {
    expect_mistake(arguments);
  }
  EXPECT_TRUE(contains(run("solve").err, "(lcpbench solve --help)"));
  EXPECT_TRUE(contains(run("--frobnicate").err, "(lcpbench --help)"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "nosuch.db"));
  EXPECT_NE(read("one.json"), "");
  EXPECT_EQ(run("certify --store s.db").exit_code, 0);
}

TEST_F(CommandLineTest, MisspeltNamesAreRecognised) {
  write_problem_of("one.json", kOneRow);
  for (const auto& [arguments, name] : std::vector<std::pair<std::string, std::string>>{
           {"slove one.json", "solve"},
           {"solve one.json --sovler lemke", "--solver"},
           {"solve one.json --solver lmke", "lemke"},
           {"solve one.json --solver 'lemke{engin=dense}'", "engine"},
           {"solvers contact_lemk", "contact_lemke"},
           {"run qick", "quick"},
           {"run --set paper/monotone/epx1", "paper/monotone/exp1"},
           {"sets 'paper/monotone/exp2{redundncy=multiple}'", "redundancy"}}) {
    expect_mistake(arguments);
    EXPECT_TRUE(contains(read("err"), "(did you mean '" + name + "'?)")) << arguments << ": " << read("err");
  }
  EXPECT_FALSE(contains(run("solve one.json --xyzzy").err, "did you mean"));
}

TEST_F(CommandLineTest, OutputThatDoesNotArriveIsAnErrorAndEndsUpInNoFile) {
  for (const char* command :
       {"solvers", "sets --format json", "generate paper/monotone/exp1 --seed 1 --count 1 --out d",
        "run --set paper/monotone/exp1 --solver lemke --trials 1", "--help"}) {
    const ProgramRun output = run(std::string(command) + " >/dev/full");
    EXPECT_EQ(output.exit_code, 2) << command;
    EXPECT_TRUE(contains(output.err, "No space left on device")) << command << ": " << output.err;
  }
  EXPECT_TRUE(contains(run("sets >&-").err, "Bad file descriptor"));
  done("generate paper/monotone/exp1 --seed 1 --count 2 --out open");
  EXPECT_EQ(run("generate paper/monotone/exp1 --seed 1 --count 2 --out closed <&- >&- 2>&-").exit_code, 2);
  for (const char* name : {"/000000.json", "/000001.json"}) {
    EXPECT_EQ(read(std::string("closed") + name), read(std::string("open") + name)) << name;
  }
}

TEST_F(CommandLineTest, HelpIsNoErrorAndNamesEveryCommand) {
  const std::string overview = done("--help");
  EXPECT_EQ(done(""), overview);
  for (const std::string command :
       {"solvers", "steppers", "sets",    "generate",  "audit",   "solve",  "models", "replay",
        "shrink",  "certify",  "run",     "merge",     "report",  "bench",  "query",  "view",
        "inspect", "validate", "compare", "stability", "capture", "dataset"}) {
    EXPECT_TRUE(contains(overview, "\n  " + command + " ")) << command;
    const std::string help = done(command + " --help");
    EXPECT_FALSE(contains(help, std::string(31, ' '))) << "what an option does has one left edge";
  }
}

// A solver of the round cone is none of the pyramid: `bench` judges its answers as `solve` does.
TEST_F(CommandLineTest, BenchVerifiesAnswersByTheirSolversModelOfFriction) {
  const json cells =
      run_json("bench --set scene/stack/ode --solver 'cone_ipm{cone=true}' --reference auto --problems 3")["cells"];
  ASSERT_EQ(cells.size(), 1U);
  EXPECT_EQ(cells[0]["timed"], 3);
}

TEST_F(CommandLineTest, AMissingWorkerProgramMakesItsSolversUnavailable) {
  setenv("LCPBENCH_WORKER_DIR", (folder_ / "").c_str(), 1);
  const json solvers = run_json("solvers");
  const ProgramRun study = run("run smoke --trials 1 --store alone.db");
  unsetenv("LCPBENCH_WORKER_DIR");
  for (const json& solver : solvers) {
    EXPECT_EQ(solver["available"], solver["origin"] != "library") << solver["name"];
  }
  EXPECT_EQ(study.exit_code, 0) << study.err;
  EXPECT_TRUE(contains(study.err, "skipped: bullet_dantzig: ")) << study.err;
}

// Not there, no library, no PATH: in each case the study goes on without it, and the reason names no folder.
TEST_F(CommandLineTest, ALibraryOfTheUsersThatIsNoneMakesItsSolverUnavailable) {
  write("notes.txt", "no library");
  write_problem_of("one.json", kOneRow);
  write("plan.json", R"({"format": "lcpbench-plan", "version": 1, "name": "two", "trials": 1,
      "sets": ["planted/definite"], "solvers": ["lemke", {"solver": "path", "optional": true}]})");
  for (const auto& [library, cause] :
       std::vector<std::pair<std::string, std::string>>{{folder_ / "nowhere.so", "nowhere.so"},
                                                        {folder_ / "notes.txt", "notes.txt"},
                                                        {"libm.so.6", "Path_Version"}}) {
    setenv("PATH_LIBRARY", library.c_str(), 1);
    const json path = run_json("solvers path")[0];
    const ProgramRun asked = run("solve one.json --solver path");
    const ProgramRun study = run("run plan.json --fresh --store two.db");
    unsetenv("PATH_LIBRARY");
    const std::string reason = path["reason"];
    EXPECT_EQ(path["available"], false) << library;
    EXPECT_TRUE(contains(reason, cause) && !contains(reason, "/")) << reason;
    EXPECT_EQ(asked.exit_code, 2);
    EXPECT_TRUE(contains(asked.err, reason)) << asked.err;
    EXPECT_EQ(study.exit_code, 0) << study.err;
    EXPECT_TRUE(contains(study.err, "skipped: path: " + reason)) << study.err;
  }
}

TEST_F(CommandLineTest, SetsShowsFilesAndCanonicalNames) {
  done("generate paper/monotone/exp1 --seed 1 --count 3 --out three");
  const json files = run_json("sets file:three");
  EXPECT_EQ(files[0]["name"], "file:three");
  EXPECT_EQ(files[0]["size"], "3 problems");
  const json option = run_json("sets paper/monotone/exp2")[0]["options"].at(0);
  const std::string as_default = option["name"].get<std::string>() + "=" + option["default"].get<std::string>();
  EXPECT_EQ(run_json("sets 'paper/monotone/exp2{" + as_default + "}'")[0]["name"], "paper/monotone/exp2");
  const json changed = run_json("sets 'paper/*/exp2{redundancy=combination}'");
  ASSERT_EQ(changed.size(), 2U);
  EXPECT_EQ(changed[0]["name"], "paper/monotone/exp2{redundancy=combination}");
  // What is known of a hard case is known of it with its options.
  EXPECT_TRUE(contains(done("sets hard/contact/painleve-acceleration --format json"), "no solution: "));
  EXPECT_TRUE(
      contains(done("sets 'hard/contact/painleve-acceleration{mu=1}' --format json"), "solvable, one solution"));
}

TEST_F(CommandLineTest, TrialAloneIsByteIdenticalToTheTrialInABatch) {
  const std::string generate = "generate 'paper/copositive/exp2{redundancy=combination}' --seed 5 ";
  done(generate + "--count 4 --out batch");
  done(generate + "--count 1 --first 3 --out alone");
  const std::string alone = read("alone/000003.json");
  EXPECT_GT(alone.size(), 100U);
  EXPECT_EQ(alone, read("batch/000003.json"));
  EXPECT_NE(alone, read("batch/000002.json"));
}

TEST_F(CommandLineTest, OneBadFileDoesNotStopTheOthers) {
  write("bad.json", "{}");
  write_problem_of("good.json", kOneRow);
  for (const char* command : {"solve bad.json good.json --solver lemke", "certify bad.json good.json"}) {
    const ProgramRun output = run(std::string(command) + " --format json");
    EXPECT_EQ(output.exit_code, 2);
    EXPECT_EQ(output.err.rfind("lcpbench: bad.json: ", 0), 0U) << output.err;
    EXPECT_EQ(lines_of(output.err).size(), 1U) << output.err;
    EXPECT_EQ(json::parse(output.out).size(), 1U);
  }
}

/// As reports name them: of captured sets by the step, with its bodies.
TEST_F(CommandLineTest, ProblemsOfSetsHaveNames) {
  done("generate paper/copositive/exp1 --seed 1 --first 7 --count 1 --out g");
  EXPECT_EQ(run_json("solve 'paper/copositive/exp1#7' --solver lemke")[0]["z"],
            run_json("solve g/000007.json --solver lemke")[0]["z"]);
  const json page = run_json("view 'scene/mass-ratio-1e4/bullet#60' --solver auto");
  EXPECT_EQ(page["scenes"][0]["title"], "mass-ratio-1e4, step 60 of Bullet");
  EXPECT_EQ(page["scenes"][0]["shapes"].size(), 5U);
  EXPECT_TRUE(contains(run("solve 'scene/mass-ratio-1e4/bullet#61'").err, "has no step 61; the one before is 60"));
  EXPECT_TRUE(contains(run("solve 'paper/none#7'").err, "paper/none#7: no such file"));
}

// A pile of four cubes that may rest: contact_lemke's path ends in another solution.
TEST_F(CommandLineTest, SolveSaysHowDifferentlyVerifiedAnswersMove) {
  done("generate scene/mass-ratio-1e6/bullet --seed 1 --first 3 --count 1 --out m");
  const std::string differently = "another verified answer moves differently by ";
  EXPECT_TRUE(contains(done("solve m/000003.json --solver contact_lemke --solver friction_ipm"), differently));
  const std::string alike = done("solve m/000003.json --solver auto --solver friction_ipm");
  EXPECT_TRUE(contains(alike, "solved by 2 of 2 solvers") && !contains(alike, differently)) << alike;
}

TEST_F(CommandLineTest, SolveSaysWhichImpulsesItShows) {
  done("generate scene/stack/ode --seed 1 --count 1 --out s");
  EXPECT_TRUE(contains(done("solve s/000000.json --solver auto"),
                       "other impulses may give the same motion; auto shows those that it reached"));
  done("generate 'made/robot{nc_max=40}' --seed 20261201 --first 3 --count 1 --out r");
  const std::string vain = done("solve r/000003.json --solver 'auto{impulses=even}'");
  EXPECT_TRUE(contains(vain, "auto{impulses=even} did not find those")) << vain;
  for (const json& row : run_json("solve s/000000.json --solver 'auto{impulses=even}' --solver psor")) {
    EXPECT_EQ(row["impulses"], row["solver"] == "auto" ? "even" : "");
  }
}

// A block on two equal contacts, of which the fastest solvers load one alone.
TEST_F(CommandLineTest, SolveShowsTheImpulsesOfEquallyStiffContactsUnlessASolverIsNamed) {
  write_problem_of("two.json", R"("kind":"contact","v":[-0.1],"N":[[1,1]],"G":[[1.2]])");
  const std::string text = done("solve two.json");
  for (const char* words : {"contacts (auto{impulses=even}):", "\n0              0.06\n", "\n1              0.06\n",
                            "auto{impulses=even} shows those that equally stiff"}) {
    EXPECT_TRUE(contains(text, words)) << words << "\n" << text;
  }
  EXPECT_TRUE(contains(done("solve two.json --solver lemke"), "contacts (lemke):"));
}

TEST_F(CommandLineTest, SolveAndCertifyShowTheAnswerItself) {
  std::ofstream(folder_ / "lcp.json") << R"({"format":"lcpbench-problem","version":1,"name":"l","kind":"lcp",)"
                                      << R"("M":[[2,1],[1,2]],"q":[-5,-6]})";
  EXPECT_NE(run("solve lcp.json --solver auto").out.find("z (auto): 1.33333 2.33333\n"), std::string::npos);
  EXPECT_NE(run("certify lcp.json").out.find("z (certified): 1.33333 2.33333\n"), std::string::npos);
  EXPECT_EQ(run("solve lcp.json lcp.json --solver auto").out.find("z (auto)"), std::string::npos);

  // A block that slides: 0.12 N s hold it up, and friction takes mu of that from its 1.2 kg at 1 m/s.
  std::ofstream(folder_ / "slide.json")
      << R"({"format":"lcpbench-problem","version":1,"name":"s","kind":"contact","v":[1,0,-0.1],"N":[[0],[0],[1]],)"
      << R"("D":[[1,0,-1,0],[0,1,0,-1],[0,0,0,0]],"edges":[4],"mu":[0.3],"G":[[1.2,0,0],[0,1.2,0],[0,0,1.2]]})";
  for (const char* command : {"solve slide.json --solver auto", "certify slide.json"}) {
    const std::string text = run(command).out;
    EXPECT_NE(text.find("normal N s  1st tangent N s  2nd tangent N s  slip m/s"), std::string::npos) << text;
    EXPECT_NE(text.find("0.12           -0.036                0      0.97"), std::string::npos) << text;
    EXPECT_EQ(text.find("other impulses"), std::string::npos) << text;  // these are the only ones
  }
}

TEST_F(CommandLineTest, SolveSaysWhereThePyramidIsTooCoarse) {
  const auto solve =
      [&](double x, double y) {
        std::ofstream(folder_ / "cone.json")
            << R"({"format":"lcpbench-problem","version":1,"name":"c","kind":"contact","v":[)" << x << "," << y
            << R"(,-0.5],"N":[[0],[0],[1]],"D":[[1,0,-1,0],[0,1,0,-1],[0,0,0,0]],"edges":[4],"mu":[0.5],)"
            << R"("G":[[1,0,0],[0,1,0],[0,0,1]]})";
        return run("solve cone.json --solver auto").out;
      };
  const std::string between = solve(1.2, -1.0);  // between two edges
  for (const char* word : {"models cone.json", "--max-velocity-error 0.01 ", "cone_ipm{cone=true}", "round cone by "}) {
    EXPECT_NE(between.find(word), std::string::npos) << word << "\n" << between;
  }
  EXPECT_EQ(solve(1.2, 0).find("--max-velocity-error"), std::string::npos);  // along an edge the pyramid is the cone
}

/// The usual engine limits each tangent by itself: 0.5 N s each, where the pyramid allows that of their sum.
TEST_F(CommandLineTest, SolveSaysWhichAnswersFitABoxOfFriction) {
  const auto reason = [&](const std::string& answer) {
    write("box.scenes", R"({"format":"lcpbench-scenes","version":1,"scene":"s","engine":"E","engine_version":"1"})"
                        "\n"
                        R"({"step":3,"problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact",)"
                        R"("v":[1,1,-1],"N":[[0],[0],[1]],"D":[[1,0,-1,0],[0,1,0,-1],[0,0,0,0]],"edges":[4],)"
                        R"("mu":[0.5],"G":[[1,0,0],[0,1,0],[0,0,1]]},"engine":{"impulses":)" +
                            answer + "}}\n");
    return run_json("solve box.scenes --solver engine")[0]["why"].get<std::string>();
  };
  const std::string box = reason("[1, 0,0,0.5,0.5]");
  EXPECT_TRUE(contains(box, "With a box of friction") && contains(box, "turned by 45 degrees and sqrt(2) mu")) << box;
  EXPECT_FALSE(contains(reason("[1, 0,0,0.6,0.5]"), "box"));
  EXPECT_EQ(reason("[1, 0,0,0.25,0.25]"), "");
  // Where the impulses are right and the velocity beside them is not, friction is not the cause.
  write("wrong.py", R"(import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    answer = {"claim": "solved", "z": [1, 0, 0, 0.25, 0.25, 0.75], "velocity": [9, 9, 9]}
    print(json.dumps({"sequence": asked["sequence"], **(answer if asked["verb"] == "solve" else {})}), flush=True)
)");
  const std::string why = run_json(
      "solve 'box.scenes#3' --solver 'external{command=python3 wrong.py,form=contact}'")[0]["why"];
  EXPECT_TRUE(contains(why, "its velocity is not the one that its z gives") && !contains(why, "With a box")) << why;
  EXPECT_TRUE(contains(done("view box.scenes#3 --solver engine"), "  E 1: claim solved, verdict solved"));
  EXPECT_TRUE(contains(run("solve box.scenes --solver tinyphys").err, "by any name, is 'engine'"));
}

/// Two versions of an engine do not share a row.
TEST_F(CommandLineTest, EachRecordedEngineIsARowOfItsOwn) {
  for (const char* version : {"1", "2"}) {
    write(std::string("v") + version + ".scenes",
          std::string(R"({"format":"lcpbench-scenes","version":1,"scene":"s","engine":"E","engine_version":")") + version +
              "\"}\n"
              R"({"step":3,"problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact",)"
              R"("v":[-1],"N":[[1]],"G":[[1]]},"engine":{"impulses":[)" +
              version + "]}}\n");
  }
  const std::string text = done("run --set file:v1.scenes --set file:v2.scenes --solver engine --store e.db --long");
  EXPECT_TRUE(contains(text, "E 1") && contains(text, "E 2")) << text;
  done("report e.db --out r");
  const json report = json::parse(read("r/report.json"));
  std::vector<std::string> labels;
  for (const json& solver : report["solvers"]) labels.push_back(solver["label"]);
  EXPECT_EQ(labels, (std::vector<std::string>{"E 1", "E 2"}));
}

TEST_F(CommandLineTest, SolveAsksForTurnedNormalsWhereNoContactApproaches) {
  write("part.scenes", R"({"format":"lcpbench-scenes","version":1,"scene":"s"})"
                       "\n"
                       R"({"step":3,"problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact",)"
                       R"("v":[1],"N":[[1]],"G":[[1]]},"engine":{"impulses":[1]}})"
                       "\n");
  EXPECT_TRUE(contains(done("solve part.scenes --solver engine --wide"), "No contact approaches (least N'v + b 1 m/s)"));
}

TEST_F(CommandLineTest, AMixedLcpIsSolvedAndJudgedByItsBounds) {
  std::ofstream(folder_ / "box.json") << R"({"format":"lcpbench-problem","version":1,"name":"b","kind":"lcp",)"
                                      << R"("M":[[1,0],[0,1]],"q":[-1,3],"friction_of":[null,0],"mu":[null,0.5]})";
  const std::string text = run("solve box.json").out;
  EXPECT_NE(text.find("mixed: 0 free unknowns, 1 friction row (box friction, a model of its own)"), std::string::npos);
  EXPECT_NE(text.find("1 -0.5\n"), std::string::npos) << text;
  for (const json& row : run_json("solve box.json")) {
    EXPECT_NE(row["verdict"], "wrong") << row["solver"];
    if (row["verdict"] != "solved") continue;
    EXPECT_NEAR(row["z"][0].get<double>(), 1, 1e-6) << row["solver"];  // what the verdict allows
    EXPECT_NEAR(row["z"][1].get<double>(), -0.5, 1e-6) << row["solver"];
  }
  EXPECT_EQ(run_json("certify box.json")[0]["certificate"], "open");
  EXPECT_EQ(run("inspect box.json").exit_code, 0);
}

TEST_F(CommandLineTest, SolveNamesTheContactThatSoftnessMovesMost) {
  const auto solve = [&](const std::string& v) {
    write_problem_of("soft.json", R"("kind": "contact", "v": [1, )" + v + R"(], "N": [[1, 0], [0, 1]],
        "compliance_n": [1, 1], "G": [[1, 0], [0, 1]])");
    return done("solve soft.json --solver auto");
  };
  EXPECT_TRUE(contains(solve("-1"), "softness: without compliance contact 1 would move differently by"));
  EXPECT_TRUE(contains(solve("1"), "softness: without compliance no contact would move differently\n"));
}

/// A sliding particle of 1 kg with r_n = 1 and mu = 0.5, by hand: v+ is (3/4, 0, -1/2) with Coulomb's friction, (1/2,
/// 0, 0) where it is hard, and (2/3, 0, -1/3) in the convex model.
TEST_F(CommandLineTest, AReportTellsTheErrorsOfRelaxationAndSoftness) {
  write_problem_of("soft.json", R"("kind": "contact", "v": [1, 0, -1], "N": [[0], [0], [1]], "edges": [4], "mu": [0.5],
      "D": [[1, 0, -1, 0], [0, 1, 0, -1], [0, 0, 0, 0]], "G": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "compliance_n": [1])");
  done(
      "run --set file:soft.json --set 'changed{of=file:soft.json,by=hard}' --solver 'cone_ipm{cone=true}' "
      "--solver 'cone_ipm{cone=true,slip=none}' --store s.db");
  done("report s.db --out r");
  const std::string table = read("r/tables/model_errors.csv");
  EXPECT_TRUE(contains(table, ",1,0.16666")) << table;
  EXPECT_TRUE(contains(table, ",1,0.5") || contains(table, ",1,0.4999")) << table;
  EXPECT_EQ(lines_of(table).size(), 3U) << table;
}

TEST_F(CommandLineTest, SolveRunsAllThatFitWhenNoneIsNamed) {
  write_problem_of("good.json", R"("kind": "lcp", "M": [[1, -1], [2, 1]], "q": [-1, -1])");
  std::vector<std::string> names;
  for (const json& row : run_json("solve good.json")) {
    names.push_back(row["solver"]);
    EXPECT_NE(row["claim"], "unsupported");
  }
  for (const char* name : {"lemke", "murty"}) EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  EXPECT_EQ(std::count(names.begin(), names.end(), "ode_quickstep"), 0);
}

const std::string kStudy =
    "run --set paper/monotone/exp1 --set paper/monotone/exp2 --solver lemke --solver primal_dual --trials 12 --seed 3 ";

TEST_F(CommandLineTest, RunResumesAndFreshStartsAnew) {
  EXPECT_TRUE(contains(done(kStudy + "--store a.db"), "48 of 48 cells"));
  const std::string rows = dump(folder_ / "a.db");
  done(kStudy + "--store a.db --jobs 2");
  EXPECT_EQ(dump(folder_ / "a.db"), rows);
  done("run --set paper/monotone/exp1 --solver lemke --trials 2 --store a.db --fresh");
  EXPECT_EQ(Store::open_for_reading(folder_ / "a.db").cell_count(), 2);
}

TEST_F(CommandLineTest, AQueryLosesNoColumnAndAlignsNumbersBehindNulls) {
  done("run --set paper/monotone/exp1 --solver lemke --trials 1 --store a.db");
  write("same.sql", "SELECT x.a, y.a FROM (SELECT 1 AS a) x, (SELECT 2 AS a) y");
  EXPECT_EQ(done("query a.db same.sql --format csv"), "a,a\n1,2\n");
  expect_mistake("query a.db same.sql --format json");
  write("null.sql", "SELECT NULL AS n UNION ALL SELECT 22222");
  EXPECT_TRUE(contains(done("query a.db null.sql"), "\n    -\n22222\n"));
}

TEST_F(CommandLineTest, ShardsAreListedWithTheirCostAndWhetherTheyAreDone) {
  expect_mistake(kStudy + "--list-shards 3");  // their cost is not known
  done(
      "run --set paper/monotone/exp1 --set paper/monotone/exp2 --solver lemke --solver primal_dual --trials 3 --seed 3 "
      "--jobs 1 --store pilot.db");
  EXPECT_EQ(Store::open_for_reading(folder_ / "pilot.db").runs().size(), 1U) << "the record of its cost is no run";
  const std::string list = kStudy + "--jobs 1 --list-shards 3 --costs pilot.db --store 's{}.db'";
  const json before = run_json(list);
  EXPECT_EQ(before["array"], "1-3");
  EXPECT_GT(before["megabytes"].get<int>(), 1);
  EXPECT_GE(before["minutes"].get<int>(), 1);
  std::int64_t cells = 0;
  for (const json& shard : before["shards"]) {
    cells += shard["cells"].get<std::int64_t>();
    EXPECT_GT(shard["processor_s"].get<double>(), 0);
    EXPECT_GT(shard["error_s"].get<double>(), 0);
  }
  EXPECT_EQ(cells, 48);
  done(kStudy + "--costs pilot.db --shard 2/3 --store s2.db");
  const json after = run_json(list);
  EXPECT_EQ(after["array"], "1,3");
  EXPECT_EQ(after["shards"][1]["done"], after["shards"][1]["cells"]);
  done("run --set paper/monotone/exp3 --solver lemke --solver primal_dual --trials 12 --seed 3 --store s1.db");
  EXPECT_EQ(run_json(list)["array"], "1,3") << "s1.db has the problems of another set";
  std::string other_seed = list;
  other_seed.replace(list.find("--seed 3"), 8, "--seed 4");
  EXPECT_EQ(run_json(other_seed)["array"], "1-3") << "s2.db has the problems of another seed";
  expect_mistake("run --set paper/copositive/exp1 --solver lemke --list-shards 3 --costs pilot.db");
  EXPECT_TRUE(contains(read("err"), "no times of 'lemke' on the set 'paper/copositive/exp1'")) << read("err");
}

TEST_F(CommandLineTest, MergeOfContradictionsExitsWith1) {
  done(kStudy + "--store a.db");
  std::filesystem::copy_file(folder_ / "a.db", folder_ / "b.db");
  change_rows(folder_ / "b.db", "UPDATE answers SET pivots = pivots + 1");
  const ProgramRun output = run("merge out.db a.db b.db");
  EXPECT_EQ(output.exit_code, 1);
  EXPECT_TRUE(contains(output.err, "conflict: b.db: answers: paper/monotone/exp")) << output.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.db"));
}

TEST_F(CommandLineTest, AScenesFileIsProblemsAndASet) {
  const std::string problem =
      R"("problem":{"format":"lcpbench-problem","version":1,"name":"p","kind":"contact","v":[-1],)"
      R"("N":{"starts":[0,1],"rows":[0],"values":[1]},"G_blocks":[[[2]]]}})";
  write("two.scenes", R"({"format":"lcpbench-scenes","version":1,"scene":"s"})"
                      "\n"
                      R"({"step":3,)" +
                          problem +
                          "\n"
                          R"({"step":7,)" +
                          problem + "\n{\"step\":8,");
  const ProgramRun all = run("solve two.scenes --solver lemke");
  EXPECT_EQ(all.exit_code, 0) << all.err;
  for (const char* step : {"two.scenes#3: contact", "two.scenes#7: contact"}) {
    EXPECT_TRUE(contains(all.out, step)) << all.out;
  }
  EXPECT_TRUE(contains(all.err, "2 complete steps can be read")) << all.err;
  EXPECT_FALSE(contains(done("solve two.scenes#7 --solver lemke"), "#3"));
  EXPECT_EQ(run("solve two.scenes#8").exit_code, 2);
  EXPECT_EQ(run("certify two.scenes#7 --proofs two.scenes").exit_code, 2);  // the file stays as it is
  done("run --set file:two.scenes --solver lemke --store scenes.db");
  done("generate file:two.scenes --seed 1 --count 2 --out d");
}

}  // namespace
}  // namespace lcpbench::cli_test
