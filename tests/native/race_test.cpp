#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/timed_solve.h"
#include "generators/random.h"
#include "native/auto/powers.h"
#include "native/auto/race.h"

namespace lcpbench::race_test {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// A method that ends after a known work, and whose iterate has a known residual from another work on.
class Runner final : public ResumableSolver {
 public:
  double needs = kNever;      ///< work until it claims solved
  double gives_up = kNever;   ///< work until it ends without
  double has_iterate = kNever;
  double residual = kNever;
  double rate = 0;  ///< at which the residual falls from then on
  double tells_from = 0;  ///< work from which that residual tells how far it is
  int begins = 0;
  int loads = 0;
  double longest_turn = 0;
  const Vector* start = nullptr;
  double start_entry = 0;  ///< of the start at begin()

  void begin(const Vector* given, double) override {
    ++begins;
    start = given;
    start_entry = given == nullptr ? 0 : (*given)(0);
    done_ = 0;
  }
  bool go_on(double work, double, Answer& answer) override {
    longest_turn = std::max(longest_turn, work);
    done_ = std::min(done_ + work, std::min(needs, gives_up));
    if (done_ < std::min(needs, gives_up)) return false;
    answer.claim = needs <= gives_up ? Claim::kSolved : Claim::kNumericalFailure;
    return true;
  }
  double work() const override { return done_; }
  double best(Vector& z) override {
    if (done_ < has_iterate) return kNever;
    const double now = residual * std::exp(-rate * (done_ - has_iterate));
    z = Vector::Constant(1, now);
    return now;
  }
  bool residual_tells() const override { return done_ >= tells_from; }
  const Capabilities& capabilities() const override { return capabilities_; }

 private:
  void on_load(const Problem&) override {}
  void on_solve(const SolveRequest&, Answer&) override {}

  Capabilities capabilities_;
  double done_ = 0;
};

class Runners final : public Stable {
 public:
  explicit Runners(std::vector<Entrant> of) : field(std::move(of)) {
    for (std::size_t k = 0; k < field.size(); ++k) all.push_back(std::make_unique<Runner>());
  }
  Entrant first() override { return field[0]; }
  std::span<const Entrant> entrants() override { return field; }
  ResumableSolver& loaded(std::size_t entrant) override {
    ++all[entrant]->loads;
    return *all[entrant];
  }
  bool passes(const Vector& best, Answer& to) override {
    ++tests;
    if (!(best(0) <= passing_residual)) return false;
    to.z = best;
    return true;
  }
  bool disproves(Answer& to) override {
    ++proofs;
    if (has_proof) to.claim = Claim::kUnsolvable;
    return has_proof;
  }
  Race::End run(const Race::Terms& terms = {}) { return race.run(*this, terms, answer); }
  Runner& operator[](std::size_t k) { return *all[k]; }

  std::vector<Entrant> field;
  std::vector<std::unique_ptr<Runner>> all;
  double passing_residual = 0;
  int tests = 0;
  bool has_proof = false;
  int proofs = 0;
  Race race;
  Answer answer;
};

TEST(PowersTest, RiseAndAreInverse) {
  EXPECT_EQ(power_of_two(-3), 0.125);
  EXPECT_EQ(power(16, 0.75), 8);
  double last = 0;
  for (double x = 1e-3; x < 1e3; x *= 1.01) {
    EXPECT_NEAR(power_of_two(log2_of(x)), x, 1e-12 * x);  // of the roundings of a logarithm near 10
    EXPECT_NEAR(power(x, 0.2), std::pow(x, 0.2), 0.07 * std::pow(x, 0.2));  // 6 % of each is what powers.h states
    EXPECT_GT(power(x, 1.7), last);
    last = power(x, 1.7);
  }
}

// Whatever was predicted, and whatever the others do and promise: the bound that race.h derives.
TEST(RaceTest, TakesAtMostAConstantTimesTheWorkOfAnyEntrant) {
  DrawSequence draws(TrialKey{stream_id("tests/race"), 1, 0}, Purpose::kPlantedValues, 0);
  const auto number = [&draws] { return static_cast<double>(draws.signed_grid()) * kGridStep; };  // in [-1, 1]
  double largest = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const std::size_t count = 2 + static_cast<std::size_t>(trial) % 3;
    const auto best = static_cast<std::size_t>(trial) % count;
    Runners runners(std::vector<Entrant>(count, {.cost = 1}));
    for (std::size_t k = 0; k < count; ++k) {
      Entrant& entrant = runners.field[k];
      Runner& runner = runners[k];
      entrant.cost = std::pow(10, 6 + 3 * number());
      entrant.load_cost = entrant.cost * std::pow(10, -2 + 2 * number());
      entrant.converges = number() > -0.5;
      entrant.falls_late = number() > 0;
      entrant.learns = k != best && number() > 0;
      entrant.is_reserve = k != best && k > 0 && number() > 0.5;
      if (k == best || number() > 0) runner.needs = std::pow(10, 6 + 3 * number());
      if (k != best && number() > 0) runner.gives_up = std::pow(10, 6 + 3 * number());
      if (!entrant.converges) continue;
      runner.has_iterate = entrant.cost * std::pow(10, -2 + 2 * number());
      runner.residual = std::pow(10, -3 + 3 * number());
      runner.rate = std::pow(10, -7 + 3 * number());
      runner.tells_from = std::pow(10, 5 + 5 * number());
      entrant.shape = std::pow(4, number());
    }
    ASSERT_EQ(runners.run(), Race::End::kClaimed);

    const double others = static_cast<double>(count - 1);
    const Entrant& entrant = runners.field[best];
    const double needs = runners[best].needs + entrant.load_cost;
    const double bound =
        (1 + 2 * Race::kLead * others) * needs + Race::kHeadStart + (others + 1) * Race::kLeastTurn;
    EXPECT_LE(runners.race.work(), bound * (1 + 1e-12));  // of the sums' rounding
    largest = std::max(largest, runners.race.work() / needs);
  }
  EXPECT_GT(largest, 15);  // or the entrants were no adversaries
}

TEST(RaceTest, GivesTheFirstTurnToTheLeastPrediction) {
  Runners runners({{.cost = 3e6, .load_cost = 1e5}, {.cost = 1e6, .load_cost = 1e5}, {.cost = 2e6, .load_cost = 1e5}});
  for (std::size_t k = 0; k < 3; ++k) runners[k].needs = 9e5;
  EXPECT_EQ(runners.run(), Race::End::kClaimed);
  EXPECT_EQ(runners.race.winner(), 1U);
  EXPECT_EQ(runners[0].loads + runners[2].loads, 0);
}

TEST(RaceTest, LetsAMethodOfACertainPredictionGoOnToItsEnd) {
  Runners runners({{.cost = 1e6, .shape = 3, .load_cost = 1e5}, {.cost = 1.5e6, .load_cost = 1e5}});
  runners[0].needs = 1e6;
  EXPECT_EQ(runners.run(), Race::End::kClaimed);
  EXPECT_EQ(runners[1].loads, 0);
}

TEST(RaceTest, AsksOnceWhetherThereIsNoAnswer) {
  for (const bool has_proof : {true, false}) {
    Runners runners({{.cost = 1e5}, {.cost = 1e5}});
    for (const std::size_t k : {0U, 1U}) runners[k].gives_up = 1e8;
    runners.has_proof = has_proof;
    EXPECT_EQ(runners.run({.proof_at = 1e6}), has_proof ? Race::End::kClaimed : Race::End::kAllGaveUp);
    EXPECT_EQ(runners.proofs, 1);
    EXPECT_GE(runners.race.work(), 1e6);
    EXPECT_LE(runners.race.work(), has_proof ? 1e7 : kNever);
  }
}

TEST(RaceTest, LosesNothingThatAMethodHasDone) {
  Runners runners({{.cost = 1e5}, {.cost = 1e5}});
  runners[0].needs = 1e7;
  EXPECT_EQ(runners.run(), Race::End::kClaimed);
  EXPECT_EQ(runners.race.winner(), 0U);
  EXPECT_EQ(runners[0].loads, 1);
  EXPECT_EQ(runners[0].begins, 1);
  EXPECT_LE(runners[1].work(), 2 * Race::kLead * 1e7);
}

TEST(RaceTest, HandsOutTheBestIterateWhereAllGiveUp) {
  Runners runners(std::vector<Entrant>(3, {.cost = 1}));
  for (std::size_t k = 0; k < 3; ++k) {
    runners[k].gives_up = 100;
    runners[k].has_iterate = 1;
    runners[k].residual = k == 1 ? 1e-3 : 1e-2;
  }
  EXPECT_EQ(runners.run(), Race::End::kAllGaveUp);
  EXPECT_EQ(runners.race.best_residual(), 1e-3);
  EXPECT_EQ(runners.race.best()(0), 1e-3);
  EXPECT_EQ(runners.race.winner(), 1U);
}

TEST(RaceTest, EndsWithAnIterateAtTheAimThatPassesTheTest) {
  Runners runners({{.cost = 1e6, .converges = true}, {.cost = 2e6, .converges = true}});
  runners.passing_residual = 2e-6;
  runners[0].has_iterate = 0;
  runners[0].residual = 0.5;
  runners[0].rate = 1e-5;  // 1e-4 after 8.5e5, 2e-6 after 1.24e6
  runners[0].needs = 1e8;
  EXPECT_EQ(runners.run({.aim = 1e-4}), Race::End::kClaimed);
  EXPECT_EQ(runners.race.winner(), 0U);
  ASSERT_EQ(runners.answer.z.size(), 1);
  EXPECT_LE(runners.answer.z(0), 2e-6);
  EXPECT_LE(runners[0].work(), 1.24e6 * Race::kLook);
  EXPECT_LE(runners.tests, 6);  // each at half the residual of the last one
}

TEST(RaceTest, StartsAMethodFromWhatTheOthersHaveFound) {
  Runners runners({{.cost = 1e5}, {.cost = 2e5, .learns = true}});
  runners[0].has_iterate = 1;
  runners[0].residual = 0.0625;
  runners[1].needs = 5;
  EXPECT_EQ(runners.run(), Race::End::kClaimed);
  EXPECT_EQ(runners[1].start_entry, 0.0625);
}

TEST(RaceTest, LetsAReserveEnterWhereTheEntrantBeforeItStalls) {
  Runners runners({{.cost = 1e5, .converges = true}, {.cost = 1e5, .is_reserve = true}});
  runners[0].has_iterate = 1e4;
  runners[0].residual = 0.5;
  runners[1].needs = 1e6;
  EXPECT_EQ(runners.run(), Race::End::kClaimed);
  EXPECT_EQ(runners.race.winner(), 1U);
  EXPECT_EQ(runners[0].begins, 1);
  EXPECT_LE(runners[0].work(), 2 * Race::kLead * 1e6);
}

TEST(RaceTest, EndsWithAnIterateThatIsGoodEnoughAfterSomePatience) {
  Runners runners({{.cost = 1e5}, {.cost = 1e5}});
  runners[1].has_iterate = 1e4;
  runners[1].residual = 1e-5;
  EXPECT_EQ(runners.run({.accepted = 5e-5, .ends_early = true}), Race::End::kGoodEnough);
  EXPECT_GT(runners.race.work(), 1e4 * Race::kPatience * power(1e4, Race::kSlowness));  // the residual over the aim
  EXPECT_LE(runners.race.work(), 2 * Race::kLead * 4e5 * Race::kPatience);
  EXPECT_EQ(runners.race.best_residual(), 1e-5);
}

TEST(RaceTest, BeginsNoLoadThatOutlastsTheDeadline) {
  Runners runners({{.cost = 1e12, .load_cost = 1e12}, {.cost = 2e12}});
  runners[1].gives_up = 1;
  EXPECT_EQ(runners.run({.deadline_s = wall_clock_s() + 1}), Race::End::kTimeLimit);
  EXPECT_EQ(runners[0].loads, 0);
  EXPECT_EQ(runners[1].loads, 1);
}

TEST(RaceTest, IsOverAtTheDeadline) {
  Runners runners(std::vector<Entrant>(1, {.cost = 1}));
  EXPECT_EQ(runners.run({.deadline_s = wall_clock_s()}), Race::End::kTimeLimit);
  EXPECT_EQ(runners[0].loads, 0);
}

}  // namespace
}  // namespace lcpbench::race_test
