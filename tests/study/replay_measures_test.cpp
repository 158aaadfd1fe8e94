// Scenes stepped on with the answers of solvers: what is made of the measures.
#include "study/replay/replay.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/io/scenes_file.h"
#include "generators/sets.h"
#include "study/replay/claims.h"
#include "tests/support/study_support.h"

namespace lcpbench::replay_measures_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Replay replay(const std::string& solver, const std::vector<double>& drifts, const std::string& end = "") {
  Replay result{solver, {}, end};
  for (const double drift : drifts) {
    const auto step = static_cast<std::int64_t>(result.steps.size());
    result.steps.push_back(
        {step, 0.005 * static_cast<double>(step), 4, "solved", 10 - drift, 1e-5, drift, kNone, 0.001});
  }
  return result;
}

ReplayedScene scene(std::vector<Replay> replays) { return {"tower", "ODE", 0.005, 4, false, std::move(replays)}; }

TEST(Replay, MeasuresTheLargestAndTheStepsSurvived) {
  const Replay falls = replay("falls", {0, 0.05, 0.2, 0.1});
  EXPECT_EQ(falls.largest(&ReplayStep::drift_m), 0.2);
  EXPECT_TRUE(std::isnan(falls.largest(&ReplayStep::slip_m)));
  EXPECT_EQ(falls.survived(), 2);
  EXPECT_NEAR(falls.energy_rise(), 0.1, 1e-12);
  EXPECT_EQ(replay("stands", {0, 0, 0, 0}).survived(), 4);
  EXPECT_EQ(replay("ends", {0, 0}, "it blew up").survived(), 1);
  EXPECT_EQ(replay("none", {}, "no answer").survived(), 0);
}

TEST(Replay, TablesQuoteWhatTheyMust) {
  EXPECT_NE(replay_summary_csv({scene({replay("a{b=1,c=2}", {0}, "said \"no\",\nand left")})})
                .find("tower,ODE,\"a{b=1,c=2}\",4,0,\"said \"\"no\"\",?and left\",1,1,"),
            std::string::npos);
  ReplayedScene foreign = scene({replay("auto", {0})});
  foreign.engine = "Balls, \"2\"";  // an external engine gives itself a name
  EXPECT_NE(replay_summary_csv({foreign}).find("\ntower,\"Balls, \"\"2\"\"\",auto,4,"), std::string::npos);
}

TEST(Replay, ReadsWhatWasWrittenAndNamesWhatIsWrong) {
  ScratchFolder folder;
  const std::string file = folder / "track.csv";
  const std::string heading = "step,time_s,contacts,claim,energy_j,deepest_m,drift_m,slip_m,cpu_s\n";
  const auto write = [&](const std::string& text) { std::ofstream(file) << text; };
  write(heading + "0,0,8,solved,88.5,1e-16,0,,1e-3\n1,0.005,0,none,88.5,0,0.00024,,2e-3\nend,it blew up\n");
  EXPECT_TRUE(is_complete_track(file));
  const Replay replay = read_track(file, "auto");
  ASSERT_EQ(replay.steps.size(), 2U);
  EXPECT_EQ(replay.steps[1].drift_m, 0.00024);
  EXPECT_EQ(replay.steps[1].claim, "none");
  EXPECT_NEAR(replay.cpu_s_per_s(), 0.3, 1e-12);
  EXPECT_EQ(replay.end, "it blew up");
  EXPECT_EQ(replay.with_contacts(), 1);
  write(heading + "0,0,8,solved,88.5,1e-16,0,,\n");
  EXPECT_FALSE(is_complete_track(file));
  EXPECT_THROW(read_track(file, "auto"), InputError);
  write(heading + "0,0,8,solved,high,1e-16,0,,\nend,\n");
  EXPECT_THROW(read_track(file, "auto"), InputError);
  EXPECT_FALSE(is_complete_track(folder / "nowhere.csv"));
}

TEST(FieldClaims, AVerdictNeedsEveryRepetition) {
  FieldClaim better{.id = "x", .claim = "A beats B.", .source = "somebody", .measure = "drift_m"};
  better.steppers = {"a", "b"};
  const double lost = std::numeric_limits<double>::infinity();
  EXPECT_EQ(holds(better, {"s", {{0.01, 0.02}, {0.03, lost}}}), Holds::kYes);
  EXPECT_EQ(holds(better, {"s", {{0.01, 0.02}, {0.03, 0.001}}}), Holds::kSometimes);
  EXPECT_EQ(holds(better, {"s", {{0.059, 0.057}, {0.054, 0.056}}}), Holds::kNo);  // no difference in the second
  EXPECT_EQ(holds(better, {"s", {{lost, lost}, {0.03, 0.001}}}), Holds::kNo);
  EXPECT_EQ(holds(better, {"s", {{lost, 1e-9}, {lost, 9e-5}}}), Holds::kSame);
  EXPECT_EQ(holds(better, {"s", {{0.0100}, {0.0103}}}), Holds::kSame);
  EXPECT_EQ(holds(better, {"s", {{0.02}, {0.03}, {0.001}}}), Holds::kYes) << "the baseline is not compared with";
  FieldClaim keeps{.kind = FieldClaim::Kind::kKeeps, .measure = "drift_m", .limit = 0.1, .steppers = {"a"}};
  EXPECT_EQ(holds(keeps, {"s", {{0.01, 0.1}}}), Holds::kYes);
  EXPECT_EQ(holds(keeps, {"s", {{lost, lost}}}), Holds::kNo);
  const ClaimedScene kept{"kept", {{0.01}, {2.5}}};
  const ClaimedScene fallen{"fallen", {{lost}, {lost}}};
  EXPECT_EQ(claim_verdict(keeps, {kept}), "holds");
  EXPECT_EQ(claim_verdict(keeps, {fallen}), "does not hold");
  EXPECT_EQ(claim_verdict(keeps, {kept, fallen}), "holds on kept; not on fallen");
  const ClaimedScene best{"best", {{0.01}, {0.03}}}, even{"even", {{lost}, {lost}}}, worse{"worse", {{0.03}, {0.01}}};
  EXPECT_EQ(claim_verdict(better, {best, even, worse}), "holds on best; no difference on even; not on worse");
  EXPECT_EQ(claim_verdict(better, {best, even}), "holds on best; no difference on even");
  EXPECT_EQ(claim_verdict(better, {even, worse}), "does not hold");
  EXPECT_NE(claim_section(keeps, {kept, fallen})
                .find("| scene | `a` | `nothing` | holds |\n| --- | --- | --- | --- |\n"
                      "| kept | 1 cm | 2.5 m | yes |\n| fallen | lost | lost | no |"),
            std::string::npos);
}

/// Else a stepper that blows up at once would be as near to the truth as nothing else.
TEST(FieldClaims, AReplayThatEndsEarlyIsLostAndNotNear) {
  const ScratchFolder folder;
  const auto frames = [&](const std::string& name, const std::vector<std::int64_t>& steps) {
    ScenesWriter writer(folder / name, {.scene = "made", .engine = "made"});
    for (const std::int64_t number : steps) {
      SceneStep step;
      step.step = number;
      step.time = 0.005 * static_cast<double>(number);
      step.problem = open_set("rigid/exp1{nc_max=2}")->generate(1, 0);
      step.poses = {{1e-3 * static_cast<double>(number), 0, 0, 1, 0, 0, 0}};
      writer.add(step);
    }
    writer.close();
    return ScenesFile(folder / name);
  };
  const ScenesFile truth = frames("truth.scenes", {0, 160, 320, 479});
  EXPECT_NEAR(error_of(frames("whole.scenes", {0, 10, 20, 29}), truth), 0.3, 1e-12);
  EXPECT_TRUE(std::isinf(error_of(frames("blown-up.scenes", {0, 3}), truth)));
  const ScenesFile whole = frames("a.scenes", {0, 10, 20, 29});
  EXPECT_TRUE(std::isinf(parting_s(whole, frames("b.scenes", {0, 10, 20, 29}))));
  EXPECT_NEAR(parting_s(whole, frames("c.scenes", {0, 10, 13})), 0.1, 1e-12) << "one goes on, and one blew up";
}

TEST(FieldClaims, ThePlanIsReadAndMistakesAreNamed) {
  const std::vector<FieldClaim> claims = read_claims(std::string(kClaimsOfTheField), "plan");
  EXPECT_GE(claims.size(), 10U);
  for (const FieldClaim& claim : claims) EXPECT_FALSE(claim.source.empty()) << claim.id;
  for (const std::string text : {"{", "{}", R"({"format": "lcpbench-claims", "version": 2, "claims": []})",
                                 R"({"format": "lcpbench-claims", "version": 1, "claims": [{"id": "x", "claim": "y",
                                    "source": "z", "measure": "drift", "limit": 1, "scenes": ["stack"],
                                    "steppers": ["pgs"]}]})",
                                 R"({"format": "lcpbench-claims", "version": 1, "claims": [{"id": "x", "claim": "y",
                                    "source": "z", "measure": "drift_m", "scenes": ["stack"],
                                    "steppers": ["pgs"]}]})",
                                 R"({"format": "lcpbench-claims", "version": 1, "claims": [{"id": "x", "claim": "y",
                                    "source": "z", "measure": "drift_m", "limit": 1, "scenes": ["stack"],
                                    "steppers": ["pgs"], "engin": "bullet"}]})"}) {
    EXPECT_THROW(read_claims(text, "plan"), InputError) << text;
  }
}

}  // namespace
}  // namespace lcpbench::replay_measures_test
