// The program of a room of tests: <room>_tests [FILE...] [--gtest_...]. With names of files ("store" is store_test.cpp)
// it runs the tests of those files alone, of them those of the filter.

#include <algorithm>
#include <iostream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace {

/// ":A.b:A.c", the tests of no named file. Adds to kept[i] the number of tests of file i.
std::string tests_elsewhere(const std::vector<std::string>& endings, std::vector<int>& kept) {
  std::string filter;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const testing::TestSuite& suite = *all.GetTestSuite(i);
    for (int k = 0; k < suite.total_test_count(); ++k) {
      const testing::TestInfo& test = *suite.GetTestInfo(k);
      const auto file = std::find_if(endings.begin(), endings.end(), [&](const std::string& ending) {
        return std::string_view(test.file()).ends_with(ending);
      });
      if (file != endings.end()) {
        ++kept[static_cast<std::size_t>(file - endings.begin())];
      } else {
        filter += ":" + std::string(suite.name()) + "." + test.name();
      }
    }
  }
  return filter;
}

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  std::vector<std::string> endings;
  for (int i = 1; i < argc; ++i) endings.push_back("/" + std::string(argv[i]) + "_test.cpp");
  if (endings.empty()) return RUN_ALL_TESTS();
  std::vector<int> kept(endings.size());
  std::string elsewhere = tests_elsewhere(endings, kept);
  for (std::size_t i = 0; i < endings.size(); ++i) {
    if (kept[i] > 0) continue;
    std::cerr << argv[0] << ": no test is of a file *" << endings[i] << "\n";
    return 2;
  }
  std::string& filter = testing::GTEST_FLAG(filter);
  if (filter.find('-') == std::string::npos && !elsewhere.empty()) elsewhere.front() = '-';
  filter += elsewhere;
  return RUN_ALL_TESTS();
}
