#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/error.h"
#include "generators/paper/paper.h"
#include "tests/generators/generator_checks.h"
#include "tests/generators/opened_set.h"

namespace lcpbench::paper_generator_test {
namespace {

using Opened = testing::OpenedSet<PaperSet, draw_paper>;

Opened open(const std::string& text) { return testing::opened_set<draw_paper>(paper_sets(), text); }

bool same(const PaperSample& a, const PaperSample& b) {
  return a.v == b.v && a.N.data == b.N.data && a.D.data == b.D.data && a.edges == b.edges && a.mu == b.mu &&
         a.form == b.form && a.G.data == b.G.data && a.X.data == b.X.data && a.alpha == b.alpha;
}

std::size_t independent_count(const PaperSample& sample) { return sample.edges.size() - sample.dependences.size(); }

// A dependent contact is made from N and from D with the same sources and the same integers.
TEST(PaperGeneratorTest, DependentContactsDependInNAndDAlike) {
  for (const std::string name :
       {"paper/monotone/exp2", "paper/monotone/exp2{redundancy=combination}",
        "paper/monotone/exp4{redundancy=combination,placement=random}", "paper/copositive/exp2{edges=per_contact}",
        "paper/copositive/exp2{redundancy=combination,edges=per_contact,placement=random}"}) {
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

}  // namespace
}  // namespace lcpbench::paper_generator_test
