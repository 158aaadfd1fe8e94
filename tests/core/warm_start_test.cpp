#include "core/warm_start.h"

#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace lcpbench::warm_start_test {
namespace {

using Ids = std::vector<ContactId>;

/// Contacts with these numbers of edges and one coordinate.
ContactLayout layout_of(const std::vector<int>& edges) {
  ContactProblem problem;
  problem.v = Vector::Zero(1);
  problem.edges = edges;
  const auto nc = static_cast<Index>(edges.size());
  const Index directions = std::accumulate(edges.begin(), edges.end(), 0);
  problem.N = Matrix::Ones(1, nc);
  problem.D = Matrix::Zero(1, directions);
  problem.mu = Vector::Zero(nc);
  problem.inertia = DenseInertia{Matrix::Identity(1, 1)};
  return contact_layout(problem);
}

TEST(ContactMatchTest, FindsContactsInAnyOrder) {
  ContactMatch match;
  match.find(Ids{7, 3, 9, 1}, Ids{3, 9, 4, 7});
  EXPECT_EQ(match.before(), (std::vector<Index>{1, 2, -1, 0}));
  EXPECT_EQ(match.matched(), 3);
  match.find(Ids{}, Ids{3, 9});
  EXPECT_EQ(match.before(), (std::vector<Index>{-1, -1}));
  EXPECT_EQ(match.matched(), 0);
  match.find(Ids{3}, Ids{});
  EXPECT_TRUE(match.before().empty());
}

TEST(ContactMatchTest, RepeatedIdsMatchSomeOfTheSameName) {
  ContactMatch match;
  match.find(Ids{4, 2, 4}, Ids{4, 4, 4});
  for (const Index before : match.before()) EXPECT_TRUE(before == 0 || before == 2) << before;
}

TEST(ContactMatchTest, AllocatesNothingForNoMoreContactsThanBefore) {
  const Ids before{1, 2, 3, 4, 5};
  const Ids now{5, 4, 3, 2, 1};
  ContactMatch match;
  match.find(before, now);
  EXPECT_EQ(testing::count_allocations([&] { match.find(now, before); }), 0);
  ContactMatch first_sort;
  first_sort.find(Ids{}, now);
  EXPECT_EQ(testing::count_allocations([&] { first_sort.find(now, before); }), 0);
}

TEST(ContactIdTest, NamesOfOneStepDiffer) {
  EXPECT_EQ(contact_id("box-3:corner-1"), contact_id("box-3:corner-1"));
  EXPECT_NE(contact_id("box-3:corner-1"), contact_id("box-3:corner-2"));
  EXPECT_EQ(contact_id(""), 0xcbf29ce484222325U);   // FNV's offset basis
  EXPECT_EQ(contact_id("a"), 0xaf63dc4c8601ec8cU);  // the published value of FNV-1a
}

TEST(MatchedStartTest, MovesEachContactsImpulsesToItsPlaceNow) {
  // Before: contact 0 with 4 edges, 1 without friction, 2 with 2 edges. z = [f_N; f_D; lambda]
  const ContactLayout before = layout_of({4, 0, 2});
  Vector z(3 + 6 + 2);
  z << 10, 11, 12, 1, 2, 3, 4, 5, 6, 0.1, 0.2;
  // Now: 2, one that is new, 0, and 1.
  const ContactLayout now = layout_of({2, 4, 4, 0});
  ContactMatch match;
  match.find(Ids{100, 101, 102}, Ids{102, 103, 100, 101});
  Vector start;
  matched_start(z, before, match, now, start);
  Vector expected(4 + 10 + 3);
  expected << 12, 0, 10, 11, 5, 6, 0, 0, 0, 0, 1, 2, 3, 4, 0.2, 0, 0.1;
  EXPECT_EQ(start, expected);
  EXPECT_EQ(testing::count_allocations([&] { matched_start(z, before, match, now, start); }), 0);
}

TEST(MatchedStartTest, OtherEdgesKeepTheNormalImpulseAlone) {
  const ContactLayout before = layout_of({4, 0});
  Vector z(2 + 4 + 1);
  z << 10, 11, 1, 2, 3, 4, 0.1;
  const ContactLayout now = layout_of({0, 2});
  ContactMatch match;
  match.find(Ids{1, 2}, Ids{1, 2});
  Vector start;
  matched_start(z, before, match, now, start);
  Vector expected(2 + 2 + 1);
  expected << 10, 11, 0, 0, 0;
  EXPECT_EQ(start, expected);
}

TEST(MatchedStartTest, BoundedRowsKeepTheirImpulsesIfTheirNumberIsTheSame) {
  ContactLayout before{.nc = 1, .rows = 2, .friction_begin = {0, 0}, .lambda = {-1}};
  ContactMatch match;
  match.find(std::vector<ContactId>{7}, std::vector<ContactId>{7});
  Vector start;
  matched_start(Vector{{3, 4, 5}}, before, match, before, start);
  EXPECT_EQ(start, (Vector{{3, 4, 5}}));
  ContactLayout now = before;
  now.rows = 1;
  matched_start(Vector{{3, 4, 5}}, before, match, now, start);
  EXPECT_EQ(start, (Vector{{3, 0}}));
}

}  // namespace
}  // namespace lcpbench::warm_start_test
