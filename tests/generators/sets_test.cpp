#include "generators/sets.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/io/problem_io.h"

namespace lcpbench::sets_test {
namespace {

namespace fs = std::filesystem;

template <class F>
std::string error_of(F&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::vector<std::string> names() {
  std::vector<std::string> result;
  for (const SetInfo& set : list_sets()) result.push_back(set.name);
  return result;
}

bool is_hard(const std::string& name) { return name.rfind("hard/", 0) == 0; }
bool is_scene(const std::string& name) { return name.rfind("scene/", 0) == 0; }

TEST(ListSetsTest, DescribesEverySet) {
  for (const SetInfo& set : list_sets()) {
    EXPECT_FALSE(set.size.empty() || set.source.empty() || set.summary.empty()) << set.name;
    EXPECT_EQ(set.options.empty(), is_scene(set.name)) << set.name;
    EXPECT_EQ(open_set(set.name)->name(), set.name);
    if (is_hard(set.name) || is_scene(set.name)) continue;
    EXPECT_FALSE(open_set(set.name)->count().has_value());
    EXPECT_NO_THROW(open_set(set.name)->generate(7, 3).size()) << set.name;
  }
}

TEST(ListSetsTest, EverySetHasItsHash) {
  std::ifstream file(GOLDEN_HASHES);
  std::set<std::string> hashed;
  for (std::string hash, name; file >> hash >> name;) hashed.insert(name);
  for (const SetInfo& set : list_sets()) {
    if (is_scene(set.name) || set.name == "changed") continue;  // committed bits; and changed_test.cpp has its bits
    EXPECT_TRUE(hashed.contains(set.name.starts_with("made/") ? set.name + "{nc_max=150}" : set.name)) << set.name;
  }
}

/// Their models are others' work: the licence of each stands in the description.
TEST(ListSetsTest, RobotsAreHeldOutAndNameTheirModel) {
  int robots = 0;
  for (const SetInfo& set : list_sets()) {
    if (!set.name.starts_with("scene/robot/")) continue;
    const std::string name = set.name.substr(12, set.name.rfind('/') - 12);
    EXPECT_TRUE(std::regex_search(set.summary, std::regex("^held out of fits: captured: " + name +
                                                          " of MuJoCo Menagerie \\((BSD-3-Clause|Apache-2.0|MIT)[;)]")))
        << set.summary;
    EXPECT_NE(open_set(set.name)->generate(1, 0).contact(), nullptr);
    ++robots;
  }
  EXPECT_GE(robots, 10);
}

TEST(ListSetsTest, ASceneIsItsCapturedSteps) {
  const auto set = open_set("scene/box/ode");
  ASSERT_TRUE(set->count().has_value());
  const std::int64_t last = *set->count() - 1;
  EXPECT_EQ(problem_hash(set->generate(1, last)), problem_hash(set->generate(99, last)));
  EXPECT_EQ(error_of([&] { set->generate(1, last + 1); }),
            "scene/box/ode: trial " + std::to_string(last + 1) + ": the set has " + std::to_string(last + 1));
  EXPECT_EQ(error_of([] { open_set("scene/box/ode{x=1}"); }), "scene/box/ode: unknown option 'x': the set has none");
}

TEST(ListSetsTest, EveryOptionIsReadAndPrinted) {
  for (const SetInfo& set : list_sets()) {
    for (const SettingInfo& option : set.options) {
      EXPECT_EQ(open_set(set.name + "{" + option.name + "=" + option.default_value + "}")->name(), set.name);
      if (option.type != "integer") continue;
      const std::string changed = set.name + "{" + option.name + "=7}";
      EXPECT_EQ(open_set(changed)->name(), changed);
    }
  }
}

TEST(OpenSetTest, NamesAreCanonical) {
  EXPECT_EQ(open_set(" paper/monotone/exp2 { placement=random , redundancy=combination } ")->name(),
            "paper/monotone/exp2{redundancy=combination,placement=random}");
  EXPECT_EQ(open_set("paper/monotone/exp2{redundancy=multiple}")->name(), "paper/monotone/exp2");
  EXPECT_EQ(open_set("paper/monotone/extra100{nc_max=100}")->name(), "paper/monotone/extra100");
  EXPECT_EQ(open_set("paper/monotone/extra100{nc_max=20}")->name(), "paper/monotone/extra100{nc_max=20}");
}

TEST(OpenSetTest, RefusesWhatItDoesNotKnow) {
  EXPECT_EQ(
      error_of([] { open_set("paper/monotone/exp7"); }),
      "unknown problem set 'paper/monotone/exp7' (did you mean 'paper/monotone/exp1'?); `lcpbench sets` lists them");
  EXPECT_NE(
      error_of([] { open_set("paper/monotone/exp1{redundancy=combination}"); }).find("unknown option 'redundancy'"),
      std::string::npos);
  EXPECT_EQ(error_of([] { open_set("rigid/exp2{redundancy=some}"); }),
            "rigid/exp2: redundancy = 'some': expected multiple|combination");
  EXPECT_NE(error_of([] { open_set("rigid/exp2{nc_max=1}"); }).find("expected an integer in [2, 200]"),
            std::string::npos);
  EXPECT_NE(error_of([] { open_set(""); }), "no error");
}

TEST(GenerateTest, NamesTheProblemAndRefusesNegativeTrials) {
  const auto set = open_set("paper/monotone/exp2{redundancy=combination}");
  EXPECT_EQ(set->generate(5, 12).name(), "paper/monotone/exp2{redundancy=combination} seed 5 trial 12");
  EXPECT_EQ(error_of([&] { set->generate(5, -1); }),
            "paper/monotone/exp2{redundancy=combination}: trial -1: expected 0 or more");
}

TEST(ExpandSetsTest, GlobsMatchOverSlashes) {
  EXPECT_EQ(expand_sets("*"), names());
  EXPECT_EQ(expand_sets("paper/*").size(), 22u);
  EXPECT_EQ(expand_sets("*/exp1"), (std::vector<std::string>{"paper/monotone/exp1", "paper/copositive/exp1",
                                                             "rigid/exp1", "rigid/frictional/exp1"}));
  EXPECT_EQ(expand_sets("paper/monotone/exp?").size(), 4u);
  EXPECT_EQ(expand_sets("paper/mono*5-1e?"),
            (std::vector<std::string>{"paper/monotone/exp5-1e5", "paper/monotone/exp5-1e8"}));
  EXPECT_EQ(expand_sets("rigid/exp1"), (std::vector<std::string>{"rigid/exp1"}));
}

TEST(ExpandSetsTest, OptionsGoToEveryMatch) {
  EXPECT_EQ(expand_sets("*/exp2{redundancy=combination}"),
            (std::vector<std::string>{
                "paper/monotone/exp2{redundancy=combination}", "paper/copositive/exp2{redundancy=combination}",
                "rigid/exp2{redundancy=combination}", "rigid/frictional/exp2{redundancy=combination}"}));
  EXPECT_EQ(expand_sets("paper/*/exp2{redundancy=multiple}"),
            (std::vector<std::string>{"paper/monotone/exp2", "paper/copositive/exp2"}));
  EXPECT_NE(error_of([] { expand_sets("paper/monotone/exp*{redundancy=combination}"); }).find("exp1: unknown option"),
            std::string::npos);
}

TEST(ExpandSetsTest, RefusesWhatMatchesNothing) {
  EXPECT_EQ(error_of([] { expand_sets("paper/*/exp9"); }),
            "no problem set matches 'paper/*/exp9'; `lcpbench sets` lists them");
}

class FileSetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / "lcpbench_file_set_test";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Problem save(const std::string& set, const std::string& file) const {
    const Problem problem = open_set(set)->generate(1, 2);
    write_problem(problem, folder_ / file);
    return problem;
  }

  fs::path folder_;
};

TEST_F(FileSetTest, AFileIsASetOfOne) {
  const Problem problem = save("paper/copositive/exp3", "one.json");
  const std::string name = "file:" + (folder_ / "one.json").string();
  const auto set = open_set(name);
  EXPECT_EQ(set->name(), name);
  EXPECT_EQ(set->count(), 1);
  EXPECT_EQ(problem_hash(set->generate(99, 0)), problem_hash(problem));
  EXPECT_EQ(error_of([&] { set->generate(1, 1); }), name + ": trial 1: the set has 1");
  EXPECT_EQ(expand_sets(name), (std::vector<std::string>{name}));
}

TEST_F(FileSetTest, AFolderIsASetInNameOrder) {
  const Problem second = save("paper/monotone/exp1", "b.json");
  const Problem first = save("rigid/exp1", "a.json");
  std::ofstream(folder_ / "README.md") << "not a problem\n";
  std::ofstream(folder_ / ".hidden.json") << "not a problem\n";
  fs::create_directory(folder_ / "c.json");
  const auto set = open_set("file:" + folder_.string());
  ASSERT_EQ(set->count(), 2);
  EXPECT_EQ(problem_hash(set->generate(1, 0)), problem_hash(first));
  EXPECT_EQ(problem_hash(set->generate(1, 1)), problem_hash(second));
}

TEST_F(FileSetTest, NamesALinkThatLeadsNowhere) {
  save("rigid/exp1", "a.json");
  fs::create_symlink("nothing.json", folder_ / "b.json");
  EXPECT_EQ(error_of([&] { open_set("file:" + folder_.string()); }).find((folder_ / "b.json").string()), 0U);
}

TEST_F(FileSetTest, RefusesWhatIsNotThere) {
  const std::string missing = (folder_ / "none.json").string();
  EXPECT_EQ(error_of([&] { open_set("file:" + missing); }), missing + ": no such file or folder");
  EXPECT_NE(error_of([&] { open_set("file:" + folder_.string()); }).find("no problem file"), std::string::npos);
}

}  // namespace
}  // namespace lcpbench::sets_test
