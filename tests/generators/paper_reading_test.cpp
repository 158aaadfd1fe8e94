// The readings of the paper that sets have as options.

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "generators/paper/paper.h"
#include "tests/generators/generator_checks.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::paper_reading_test {
namespace {

using checks::Tables;
using Opened = testing::OpenedSet<PaperSet, draw_paper>;

Opened open(const std::string& text) { return testing::opened_set<draw_paper>(paper_sets(), text); }

bool on_grid(const std::vector<double>& values, double low, double high) {
  return std::all_of(values.begin(), values.end(), [&](double value) {
    const double steps = value * 0x1p20;
    return value >= low && value <= high && std::trunc(steps) == steps;
  });
}

std::size_t independent_count(const PaperSample& sample) { return sample.edges.size() - sample.dependences.size(); }

TEST(PaperReadingTest, SwappedExchangesTheTwoRanges) {
  Tables ngc, nc;
  const Opened set = open("paper/copositive/exp1{sizes=swapped}");
  for (std::uint64_t trial = 0; trial < 3000; ++trial) {
    const PaperSample sample = set.draw(trial);
    ngc.add(static_cast<std::int64_t>(sample.v.size()), 2, 20);
    nc.add(static_cast<std::int64_t>(sample.edges.size()), 6, 15);
  }
  EXPECT_TRUE(ngc.test().plausible());
  EXPECT_TRUE(nc.test().plausible());
}

TEST(PaperReadingTest, RankRanges) {
  Tables below, from_one;
  const Opened below_set = open("paper/monotone/exp3{rank=6..ngc-1}");
  const Opened from_one_set = open("paper/monotone/exp3{rank=1..ngc}");
  for (std::uint64_t trial = 0; trial < 5000; ++trial) {
    const PaperSample a = below_set.draw(trial);
    const auto ngc = static_cast<std::int64_t>(a.v.size());
    // With ngc = 6 the range {6..5} is empty; the largest deficient rank is taken.
    below.add(static_cast<std::int64_t>(a.alpha.size()), std::min<std::int64_t>(6, ngc - 1), ngc - 1);
    from_one.add(static_cast<std::int64_t>(from_one_set.draw(trial).alpha.size()), 1, ngc);
  }
  EXPECT_TRUE(below.test().plausible());
  EXPECT_TRUE(from_one.test().plausible());
}

TEST(PaperReadingTest, LiteralTakesTheInertiaItselfForItsInverse) {
  for (const std::string name : {"paper/monotone/exp1", "paper/copositive/exp5-1e5"}) {
    const PaperSample usual = open(name).draw(3);
    const PaperSample literal = open(name + "{matrix=literal}").draw(3);
    EXPECT_EQ(literal.form, InertiaForm::kInverse);
    EXPECT_EQ(literal.G.data, usual.G.data);
    EXPECT_EQ(literal.N.data, usual.N.data);
  }
  const PaperSample factors = open("paper/monotone/exp3").draw(3);
  const PaperSample literal = open("paper/monotone/exp3{matrix=literal}").draw(3);
  EXPECT_EQ(literal.form, InertiaForm::kInverse);
  EXPECT_TRUE(literal.alpha.empty() && literal.X.data.empty());
  EXPECT_EQ(literal.G.data, weighted_outer_sum(factors.X, factors.alpha).data);
}

TEST(PaperReadingTest, EdgesPerContactVaryBetweenContacts) {
  Tables edges;
  const Opened set = open("paper/copositive/exp1{edges=per_contact}");
  for (std::uint64_t trial = 0; trial < 1000; ++trial) {
    for (const int count : set.draw(trial).edges) edges.add(count / 2, 2, 12);
  }
  EXPECT_TRUE(edges.test().plausible());
}

TEST(PaperReadingTest, DependentContactsStandLastOrAnywhere) {
  const Opened last = open("paper/monotone/exp2{nc_max=10}");
  const Opened anywhere = open("paper/monotone/exp2{nc_max=10,placement=random}");
  Tables places;
  for (std::uint64_t trial = 0; trial < 20000; ++trial) {
    const PaperSample ordered = last.draw(trial);
    for (std::size_t i = 0; i < ordered.dependences.size(); ++i) {
      ASSERT_EQ(ordered.dependences[i].contact, independent_count(ordered) + i);
    }
    const PaperSample mixed = anywhere.draw(trial);
    ASSERT_EQ(mixed.dependences.size(), ordered.dependences.size());
    if (mixed.dependences.size() == 1) {
      places.add(static_cast<std::int64_t>(mixed.dependences[0].contact), 0,
                 static_cast<std::int64_t>(mixed.edges.size()) - 1);
    }
  }
  EXPECT_TRUE(places.test().plausible());
}

TEST(PaperReadingTest, CeilingsHoldAndAreReached) {
  const Opened set = open("paper/monotone/exp1{ngc_max=9,nc_max=4}");
  Tables ngc, nc;
  for (std::uint64_t trial = 0; trial < 1000; ++trial) {
    const PaperSample sample = set.draw(trial);
    ngc.add(static_cast<std::int64_t>(sample.v.size()), 6, 9);
    nc.add(static_cast<std::int64_t>(sample.edges.size()), 2, 4);
  }
  EXPECT_TRUE(ngc.test().plausible());
  EXPECT_TRUE(nc.test().plausible());
}

TEST(PaperReadingTest, WeightsAndVectorsFollowTheirDistributions) {
  const PaperSample one = open("paper/monotone/exp3{alpha=one,x=positive}").draw(0);
  EXPECT_EQ(one.alpha, std::vector<double>(one.alpha.size(), 1.0));
  EXPECT_TRUE(on_grid(one.X.data, 0, 1));

  const Opened wide_set = open("paper/monotone/exp3{alpha=wide,x=bell}");
  Tables exponents;
  double sum = 0;
  double squares = 0;
  double count = 0;
  for (std::uint64_t trial = 0; trial < 500; ++trial) {
    const PaperSample wide = wide_set.draw(trial);
    for (const double alpha : wide.alpha) {
      ASSERT_EQ(alpha, std::exp2(std::round(std::log2(alpha))));
      exponents.add(std::lround(std::log2(alpha)), -10, 10);
    }
    for (const double x : wide.X.data) {
      sum += x;
      squares += x * x;
      count += 1;
    }
  }
  EXPECT_TRUE(exponents.test().plausible());
  // Mean 0 and variance 1; five standard errors (the fourth moment of the sum of twelve is 2.9).
  EXPECT_NEAR(sum / count, 0, 5 / std::sqrt(count));
  EXPECT_NEAR(squares / count, 1, 5 * std::sqrt(1.9 / count));
}

}  // namespace
}  // namespace lcpbench::paper_reading_test
