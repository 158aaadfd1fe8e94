#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "core/timed_solve.h"
#include "generators/random.h"
#include "native/auto/race.h"

namespace lcpbench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// A method that ends after a known work, and whose iterate has a known residual from another work on.
class Runner final : public ResumableSolver {
 public:
  double needs = kNever;      ///< work until it claims solved
  double gives_up = kNever;   ///< work until it ends without
  double has_iterate = kNever;
  double residual = kNever;
  int loads = 0;
  double longest_turn = 0;
  const Vector* start = nullptr;
  double start_entry = 0;  ///< of the start at begin()

  void begin(const Vector* given, double) override {
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
    z = Vector::Constant(1, residual);
    return residual;
  }
  const Capabilities& capabilities() const override { return capabilities_; }

 private:
  void on_load(const Problem&) override {}
  void on_solve(const SolveRequest&, Answer&) override {}

  Capabilities capabilities_;
  double done_ = 0;
};

class Runners final : public Stable {
 public:
  explicit Runners(std::size_t count) : entrants(count, {.cost = 1}) {
    for (std::size_t k = 0; k < count; ++k) runners.push_back(std::make_unique<Runner>());
  }
  ResumableSolver& loaded(std::size_t entrant) override {
    ++runners[entrant]->loads;
    return *runners[entrant];
  }
  Race::End run(const Race::Terms& terms = {}) { return race.run(entrants, *this, terms, answer); }
  Runner& operator[](std::size_t k) { return *runners[k]; }

  std::vector<Entrant> entrants;
  std::vector<std::unique_ptr<Runner>> runners;
  Race race;
  Answer answer;
};

// Whatever was predicted, and whatever the others do: the bound that race.h derives.
TEST(RaceTest, TakesAtMostAConstantTimesTheWorkOfAnyEntrant) {
  DrawSequence draws(TrialKey{stream_id("tests/race"), 1, 0}, Purpose::kPlantedValues, 0);
  const auto number = [&draws] { return static_cast<double>(draws.signed_grid()) * kGridStep; };  // in [-1, 1]
  double largest = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    const std::size_t count = 2 + static_cast<std::size_t>(trial) % 3;
    Runners field(count);
    for (std::size_t k = 0; k < count; ++k) {
      field.entrants[k].cost = std::pow(10, 3 + 3 * number());
      field.entrants[k].load_cost = field.entrants[k].cost * std::pow(10, -2 + number());
      if (number() > 0) field[k].needs = std::pow(10, 3 + 3 * number());
    }
    const auto best = static_cast<std::size_t>(trial) % count;
    field[best].needs = std::pow(10, 3 + 3 * number());
    ASSERT_EQ(field.run(), Race::End::kClaimed);

    double least = kNever;
    for (const Entrant& entrant : field.entrants) least = std::min(least, entrant.cost);
    const double budget = std::min(field.entrants[best].cost, Race::kLargestBudget * least);
    const double work = std::max(field[best].needs + field.entrants[best].load_cost, Race::kFirstShare * budget);
    const double bound = 2 * (1 + Race::kLargestBudget * static_cast<double>(count - 1)) * work;
    double done = 0;
    for (std::size_t k = 0; k < count; ++k) done += field[k].loads > 0 ? field[k].work() : 0;
    EXPECT_LE(done, bound * (1 + 1e-12) + static_cast<double>(count) * Race::kLeastTurn);  // of the sums' rounding
    largest = std::max(largest, done / work);
  }
  EXPECT_GT(largest, 3);  // or the entrants were no adversaries
}

TEST(RaceTest, GivesTheFirstTurnToTheLeastPrediction) {
  Runners field(3);
  field.entrants = {{.cost = 30}, {.cost = 10}, {.cost = 20}};
  for (std::size_t k = 0; k < 3; ++k) field[k].needs = 9;
  EXPECT_EQ(field.run(), Race::End::kClaimed);
  EXPECT_EQ(field.race.winner(), 1U);
  EXPECT_EQ(field[0].loads + field[2].loads, 0);
}

TEST(RaceTest, LosesNothingThatAMethodHasDone) {
  Runners field(2);
  field.entrants = {{.cost = 10}, {.cost = 10}};
  field[0].needs = 1000;
  EXPECT_EQ(field.run(), Race::End::kClaimed);
  EXPECT_EQ(field.race.winner(), 0U);
  EXPECT_EQ(field[0].loads, 1);
  EXPECT_LE(field[1].work(), 1000);
}

TEST(RaceTest, HandsOutTheBestIterateWhereAllGiveUp) {
  Runners field(3);
  for (std::size_t k = 0; k < 3; ++k) {
    field[k].gives_up = 100;
    field[k].has_iterate = 1;
    field[k].residual = k == 1 ? 1e-3 : 1e-2;
  }
  EXPECT_EQ(field.run(), Race::End::kAllGaveUp);
  EXPECT_EQ(field.race.best_residual(), 1e-3);
  EXPECT_EQ(field.race.best()(0), 1e-3);
  EXPECT_EQ(field.race.winner(), 1U);
}

TEST(RaceTest, StartsAMethodFromWhatTheOthersHaveFound) {
  Runners field(2);
  field.entrants = {{.cost = 1e4}, {.cost = 2e4, .learns = true}};
  field[0].has_iterate = 1;
  field[0].residual = 0.25;
  field[1].needs = 5;
  EXPECT_EQ(field.run(), Race::End::kClaimed);
  EXPECT_EQ(field[1].start_entry, 0.25);
}

TEST(RaceTest, EndsWithAnIterateThatIsGoodEnoughAfterSomePatience) {
  Runners field(2);
  field.entrants = {{.cost = 1e4}, {.cost = 1e4}};
  field[1].has_iterate = 1e4;
  field[1].residual = 1e-5;
  EXPECT_EQ(field.run({.accepted = 5e-5, .ends_early = true}), Race::End::kGoodEnough);
  EXPECT_GT(field.race.work(), 1e4 * Race::kPatience);
  EXPECT_LE(field.race.work(), 4 * 4e4 * Race::kPatience);  // both have done 2e4 then, and rounds double
  EXPECT_EQ(field.race.best_residual(), 1e-5);
}

TEST(RaceTest, BeginsNoLoadThatOutlastsTheDeadline) {
  Runners field(2);
  field.entrants = {{.cost = 1e12, .load_cost = 1e12}, {.cost = 2e12}};
  field[1].gives_up = 1;
  EXPECT_EQ(field.run({.deadline_s = wall_clock_s() + 1}), Race::End::kTimeLimit);
  EXPECT_EQ(field[0].loads, 0);
  EXPECT_EQ(field[1].loads, 1);
}

TEST(RaceTest, IsOverAtTheDeadline) {
  Runners field(1);
  EXPECT_EQ(field.run({.deadline_s = wall_clock_s()}), Race::End::kTimeLimit);
  EXPECT_EQ(field[0].loads, 0);
}

}  // namespace
}  // namespace lcpbench
