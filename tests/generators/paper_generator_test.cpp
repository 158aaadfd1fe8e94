#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "generators/paper/paper.h"
#include "tests/generators/generator_checks.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::paper_generator_test {
namespace {

using checks::Tables;
using Opened = testing::OpenedSet<PaperSet, draw_paper>;

Opened open(const std::string& text) { return testing::opened_set<draw_paper>(paper_sets(), text); }

bool same(const PaperSample& a, const PaperSample& b) {
  return a.v == b.v && a.N.data == b.N.data && a.D.data == b.D.data && a.edges == b.edges && a.mu == b.mu &&
         a.form == b.form && a.G.data == b.G.data && a.X.data == b.X.data && a.alpha == b.alpha;
}

bool on_grid(const std::vector<double>& values, double low, double high) {
  return std::all_of(values.begin(), values.end(), [&](double value) {
    const double steps = value * 0x1p20;
    return value >= low && value <= high && std::trunc(steps) == steps;
  });
}

std::size_t independent_count(const PaperSample& sample) { return sample.edges.size() - sample.dependences.size(); }

const std::vector<std::string> kEverySetAndReading = {
    "paper/monotone/exp1",
    "paper/monotone/exp1{alpha=one}",
    "paper/monotone/exp1{alpha=wide,x=bell}",
    "paper/monotone/exp1{x=positive}",
    "paper/monotone/exp2",
    "paper/monotone/exp2{redundancy=combination}",
    "paper/monotone/exp3",
    "paper/monotone/exp4",
    "paper/monotone/exp4{redundancy=combination,placement=random}",
    "paper/monotone/exp5-1e10",
    "paper/copositive/exp1",
    "paper/copositive/exp1{edges=per_contact}",
    "paper/copositive/exp2",
    "paper/copositive/exp2{redundancy=combination}",
    "paper/copositive/exp2{redundancy=combination,edges=per_contact,placement=random}",
    "paper/copositive/exp2{edges=per_contact}",
    "paper/copositive/exp3",
    "paper/copositive/exp4{redundancy=combination}",
    "paper/copositive/exp5-1e8{sizes=swapped}",
};

TEST(PaperGeneratorTest, ShapesRangesGridAndOppositePairs) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 100; ++trial) {
      const PaperSample sample = set.draw(trial);
      const std::size_t ngc = sample.v.size();
      const std::size_t nc = sample.edges.size();
      std::size_t columns = 0;
      for (const int edges : sample.edges) columns += static_cast<std::size_t>(edges);
      ASSERT_EQ(sample.N.rows, ngc);
      ASSERT_EQ(sample.N.cols, nc);
      ASSERT_EQ(sample.N.data.size(), ngc * nc);
      ASSERT_EQ(sample.D.rows, ngc);
      ASSERT_EQ(sample.D.cols, columns);
      ASSERT_EQ(sample.D.data.size(), ngc * columns);
      ASSERT_EQ(sample.mu.size(), nc);
      ASSERT_TRUE(on_grid(sample.v, -1, 1));
      ASSERT_TRUE(on_grid(sample.mu, 0, 1));
      // At most {-2..2} times 19 independent contacts, each below 1 in magnitude.
      ASSERT_TRUE(on_grid(sample.N.data, -38, 38));
      ASSERT_TRUE(on_grid(sample.D.data, -38, 38));
      std::size_t begin = 0;
      for (const int edges : sample.edges) {
        ASSERT_TRUE(set.set->features.frictional ? edges >= 4 && edges <= 24 && edges % 2 == 0 : edges == 0);
        const auto half = static_cast<std::size_t>(edges / 2);
        for (std::size_t t = begin; t < begin + half; ++t) {
          for (std::size_t i = 0; i < ngc; ++i) ASSERT_EQ(sample.D(i, t + half), -sample.D(i, t));
        }
        begin += 2 * half;
      }
    }
  }
}

// A dependent contact is made from N and from D with the same sources and the same integers.
TEST(PaperGeneratorTest, DependentContactsDependInNAndDAlike) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    const bool multiple = set.reading.redundancy == Redundancy::kMultiple;
    for (std::uint64_t trial = 0; trial < 60; ++trial) {
      const PaperSample sample = set.draw(trial);
      std::vector<std::size_t> begin(1, 0);
      for (const int edges : sample.edges) begin.push_back(begin.back() + static_cast<std::size_t>(edges));
      std::vector<bool> dependent(sample.edges.size());
      for (const Dependence& one : sample.dependences) dependent[one.contact] = true;
      for (const Dependence& one : sample.dependences) {
        ASSERT_EQ(one.sources.size(), one.factors.size());
        ASSERT_FALSE(one.sources.empty());
        ASSERT_TRUE(!multiple || one.sources.size() == 1);
        for (std::size_t s = 0; s < one.sources.size(); ++s) {
          ASSERT_FALSE(dependent[one.sources[s]]);
          ASSERT_GE(one.factors[s], multiple ? 1 : -2);
          ASSERT_LE(one.factors[s], multiple ? 5 : 2);
          ASSERT_NE(one.factors[s], 0);
          ASSERT_LE(sample.edges[one.contact], sample.edges[one.sources[s]]);
        }
        const auto combined = [&](const ColumnMajor<double>& J, std::size_t row, auto&& column_of) {
          double sum = 0;
          for (std::size_t s = 0; s < one.sources.size(); ++s) {
            sum += static_cast<double>(one.factors[s]) * J(row, column_of(one.sources[s]));
          }
          return sum;
        };
        for (std::size_t row = 0; row < sample.v.size(); ++row) {
          ASSERT_EQ(sample.N(row, one.contact), combined(sample.N, row, [](std::size_t c) { return c; }));
          for (std::size_t t = 0; t < static_cast<std::size_t>(sample.edges[one.contact] / 2); ++t) {
            ASSERT_EQ(sample.D(row, begin[one.contact] + t),
                      combined(sample.D, row, [&](std::size_t c) { return begin[c] + t; }));
          }
        }
      }
    }
  }
}

// Independent contacts have the largest rank that their number and ngc allow, dependent ones add none. Exact: the rank
// modulo a prime cannot exceed the rank, nor the rank this bound.
TEST(PaperGeneratorTest, RanksAreAsLargeAsTheIndependentContactsAllow) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    for (std::uint64_t trial = 0; trial < 60; ++trial) {
      const PaperSample sample = set.draw(trial);
      const std::size_t bound = std::min(sample.v.size(), independent_count(sample));
      ASSERT_EQ(checks::rank_mod_prime(sample.N, kGridStep), static_cast<int>(bound)) << trial;
      if (sample.form == InertiaForm::kFactored) {
        ASSERT_EQ(checks::rank_mod_prime(sample.X, kGridStep), static_cast<int>(sample.X.cols)) << trial;
      }
    }
  }
}

TEST(PaperGeneratorTest, FullRankInertiaIsSymmetricAndPositiveDefinite) {
  for (const std::string& name : kEverySetAndReading) {
    SCOPED_TRACE(name);
    const Opened set = open(name);
    if (set.set->features.reduced) continue;
    for (std::uint64_t trial = 0; trial < 200; ++trial) {
      const PaperSample sample = set.draw(trial);
      ASSERT_EQ(sample.form, InertiaForm::kDense);
      ASSERT_EQ(sample.G.rows, sample.v.size());
      ASSERT_TRUE(checks::symmetric(sample.G));
      ASSERT_TRUE(checks::positive_definite(sample.G)) << trial;
    }
  }
}

TEST(PaperGeneratorTest, ReducedInertiaIsGivenByItsFactors) {
  const Opened set = open("paper/monotone/exp3");
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    const PaperSample sample = set.draw(trial);
    ASSERT_EQ(sample.form, InertiaForm::kFactored);
    ASSERT_EQ(sample.X.rows, sample.v.size());
    ASSERT_EQ(sample.X.cols, sample.alpha.size());
    ASSERT_TRUE(sample.X.cols >= 6 && sample.X.cols <= sample.v.size());
    ASSERT_TRUE(on_grid(sample.X.data, -1, 1));
    ASSERT_TRUE(on_grid(sample.alpha, kGridStep, 1));
    ASSERT_TRUE(sample.G.data.empty());
  }
}

// The bound: eigenvectors orthonormal to a few ngc u, and each entry of G rounded relative to the largest eigenvalue.
TEST(PaperGeneratorTest, ConditionedInertiaHasTheEigenvaluesOneAndCondition) {
  const std::pair<const char*, double> conditions[] = {{"1e5", 1e5}, {"1e8", 1e8}, {"1e10", 1e10}};
  for (const auto& [label, condition] : conditions) {
    for (const std::string kind : {"monotone", "copositive"}) {
      for (const std::string map : {"loglinear", "linear", "geometric"}) {
        const Opened set = open("paper/" + kind + "/exp5-" + label + "{spectrum=" + map + "}");
        for (std::uint64_t trial = 0; trial < 40; ++trial) {
          const PaperSample sample = set.draw(trial);
          const double slack = static_cast<double>(sample.v.size()) * 0x1p-52 * condition;
          ASSERT_TRUE(checks::symmetric(sample.G));
          ASSERT_TRUE(checks::spectrum_ends_at(sample.G, 1, condition, slack)) << set.set->name << map << trial;
        }
      }
    }
  }
}

// What a study of conditioning relies on: along the dial problems differ in their inertia alone.
TEST(PaperGeneratorTest, TheDialOfConditionChangesTheSpectrumAlone) {
  for (const std::string name : {"paper/monotone/exp1", "paper/copositive/exp2"}) {
    const Opened as_drawn = open(name);
    const std::pair<const char*, double> conditions[] = {{"1", 1}, {"1e6", 1e6}, {"1e12", 1e12}};
    for (const auto& [label, condition] : conditions) {
      const Opened dialled = open(name + "{condition=" + label + "}");
      for (std::uint64_t trial = 0; trial < 20; ++trial) {
        const PaperSample plain = as_drawn.draw(trial);
        PaperSample sample = dialled.draw(trial);
        const double slack = static_cast<double>(sample.v.size()) * 0x1p-52 * condition;
        ASSERT_TRUE(checks::symmetric(sample.G));
        ASSERT_TRUE(checks::spectrum_ends_at(sample.G, 1, condition, slack)) << name << label << trial;
        ASSERT_FALSE(same(sample, plain));
        sample.G = plain.G;
        ASSERT_TRUE(same(sample, plain));
      }
    }
    for (const char* bad : {"{condition=0.5}", "{condition=2e12}", "{condition=nan}", "{condition=-1}"}) {
      EXPECT_THROW(open(name + bad), InputError) << bad;
    }
  }
  EXPECT_THROW(open("paper/monotone/exp3{condition=10}"), InputError);
  EXPECT_THROW(open("paper/monotone/exp5-1e8{condition=10}"), InputError);
}

TEST(PaperGeneratorTest, SizesAreUniformOverTheirRanges) {
  Tables ngc, nc, redundant, rank, edges;
  const Opened set = open("paper/copositive/exp4");
  for (std::uint64_t trial = 0; trial < 20000; ++trial) {
    const PaperSample sample = set.draw(trial);
    const auto size = [](const auto& container) { return static_cast<std::int64_t>(container.size()); };
    ngc.add(size(sample.v), 6, 15);
    nc.add(size(sample.edges), 2, 20);
    redundant.add(size(sample.dependences), 0, size(sample.edges) - 1);
    rank.add(size(sample.alpha), 6, size(sample.v));
    edges.add(sample.edges.front() / 2, 2, 12);
    ASSERT_TRUE(std::all_of(sample.edges.begin(), sample.edges.end(), [&](int e) { return e == sample.edges[0]; }));
  }
  for (const Tables* tables : {&ngc, &nc, &redundant, &rank, &edges}) {
    const checks::ChiSquare uniform = tables->test();
    EXPECT_TRUE(uniform.plausible()) << uniform.statistic() << " at " << uniform.degrees();
  }
}

TEST(PaperGeneratorTest, EntriesAreUniform) {
  std::vector<int> N(32), D(32), v(32), mu(32);
  const auto count = [](const std::vector<double>& values, double low, double width, std::vector<int>& counts) {
    for (const double value : values) ++counts.at(static_cast<std::size_t>((value - low) / width * 32));
  };
  const Opened set = open("paper/copositive/exp1");
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    const PaperSample sample = set.draw(trial);
    count(sample.N.data, -1, 2, N);
    count(sample.v, -1, 2, v);
    count(sample.mu, 0, 1, mu);
    const std::size_t half = sample.D.rows * static_cast<std::size_t>(sample.edges[0] / 2);
    count({sample.D.data.begin(), sample.D.data.begin() + static_cast<std::ptrdiff_t>(half)}, -1, 2, D);
  }
  for (const std::vector<int>* counts : {&N, &D, &v, &mu}) {
    checks::ChiSquare uniform;
    uniform.add_uniform(*counts);
    EXPECT_TRUE(uniform.plausible()) << uniform.statistic();
  }
}

TEST(PaperGeneratorTest, SetsSeedsAndTrialsDiffer) {
  const Opened one = open("paper/monotone/exp1");
  const Opened two = open("paper/monotone/exp2");
  EXPECT_FALSE(same(one.draw(0), one.draw(1)));
  EXPECT_FALSE(same(one.draw(0, 1), one.draw(0, 2)));
  EXPECT_NE(one.draw(0).v, two.draw(0).v);
}

TEST(PaperGeneratorTest, ATrialIsTheSameAloneInABatchAndInTwoThreads) {
  for (const std::string name : {"paper/copositive/exp5-1e8", "paper/monotone/exp4{redundancy=combination}"}) {
    SCOPED_TRACE(name);
    testing::expect_order_and_threads_do_not_matter(
        open(name), [](const PaperSample& a, const PaperSample& b) { return same(a, b); });
  }
}

// So that two readings can be compared on problems that differ in nothing else.
TEST(PaperGeneratorTest, AReadingChangesOnlyWhatItConcerns) {
  const Opened multiple = open("paper/copositive/exp5-1e8");
  const Opened combination = open("paper/copositive/exp5-1e8{redundancy=combination}");
  const Opened vectors = open("paper/copositive/exp5-1e8{x=bell}");
  for (std::uint64_t trial = 0; trial < 30; ++trial) {
    const PaperSample a = multiple.draw(trial);
    const PaperSample b = combination.draw(trial);
    const PaperSample c = vectors.draw(trial);
    ASSERT_EQ(a.v, b.v);
    ASSERT_EQ(a.mu, b.mu);
    ASSERT_EQ(a.edges, b.edges);
    ASSERT_EQ(a.G.data, b.G.data);
    const auto independent = static_cast<std::ptrdiff_t>(independent_count(a) * a.v.size());
    ASSERT_TRUE(std::equal(a.N.data.begin(), a.N.data.begin() + independent, b.N.data.begin()));
    ASSERT_EQ(a.N.data, c.N.data);
    ASSERT_EQ(a.D.data, c.D.data);
    ASSERT_NE(a.G.data, c.G.data);
  }
}

// --- the readings of the paper that sets have as options ---

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
}  // namespace lcpbench::paper_generator_test
