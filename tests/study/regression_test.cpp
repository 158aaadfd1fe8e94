// The gate against silent changes: a small fixed study of the native solvers must give the counts in
// tests/golden/regression.json. Never seconds: those belong to the machine.
//
// No tolerance. Problems are bit-identical everywhere, and at the instruction-set level `baseline` of x86-64, which has
// no fused multiply-add, every compiler must round each operation alike; so a count that differs is a changed program.
// Elsewhere the vector width and fused operations may turn a tie in a pivot, and the counts hold only by chance.

#include <cstdlib>
#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/store/store.h"
#include "tests/support/program_run.h"
#include "tests/support/study_support.h"

namespace lcpbench::regression_test {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kToAccept =
    "\nIf this is meant: LCPBENCH_ACCEPT=1 ./regression_test (in the build folder) writes the new counts into "
    "tests/golden/regression.json; commit it and say in the message why they changed.\n";

/// One record per set and solver: sums over its problems, and over the cells of a sweep.
Json counts_of(Store& store) {
  sqlite::Statement query(
      store.database(),
      "SELECT sets.name, s.name || iif(s.settings = '', '', '{' || s.settings || '}')"
      "         || iif(s.sweep = '', '', ' sweep ' || s.sweep),"
      "       COUNT(*), SUM(j.verdict = 'solved'), SUM(j.verdict = 'wrong'),"
      "       SUM(j.claim = 'solved' AND v.criterion), SUM(max(a.pivots, 0)),"
      "       SUM(max(a.iterations, 0))"
      " FROM judged_cells j JOIN solvers s ON s.id = j.solver_id JOIN sets ON sets.id = j.set_id"
      " JOIN verdicts v USING (problem_id, solver_id, part) JOIN answers a USING (problem_id, solver_id, part)"
      " GROUP BY j.set_id, j.solver_id ORDER BY 1, 2");
  Json records = Json::array();
  while (query.step()) {
    records.push_back({{"set", query.text(0)},
                       {"solver", query.text(1)},
                       {"answers", query.integer(2)},
                       {"solved", query.integer(3)},
                       {"false_claims", query.integer(4)},
                       {"criterion", query.integer(5)},
                       {"pivots", query.integer(6)},
                       {"iterations", query.integer(7)}});
  }
  return records;
}

std::map<std::string, Json> by_name(const Json& records) {
  std::map<std::string, Json> named;
  for (const Json& record : records) {
    named[record.at("set").get<std::string>() + ", " + record.at("solver").get<std::string>()] = record;
  }
  return named;
}

/// "paper/monotone/exp1, lemke: solved 20 -> 19, pivots 110 -> 112", one line for each record that differs.
std::string differences(const Json& expected, const Json& found) {
  const std::map<std::string, Json> before = by_name(expected);
  const std::map<std::string, Json> after = by_name(found);
  std::string text;
  for (const auto& [name, record] : before) {
    const auto now = after.find(name);
    if (now == after.end()) text += name + ": is gone\n";
    if (now == after.end() || now->second == record) continue;
    text += name + ":";
    for (const auto& [key, value] : record.items()) {
      if (now->second.at(key) != value) text += " " + key + " " + value.dump() + " -> " + now->second.at(key).dump();
    }
    text += "\n";
  }
  for (const auto& [name, record] : after) {
    if (!before.contains(name)) text += name + ": is new\n";
  }
  return text;
}

/// One record a line, so that a change can be read in a diff.
std::string document_text(const Json& records) {
  std::string text = "[";
  for (const Json& record : records) text += (text.size() > 1 ? ",\n " : "\n ") + record.dump();
  return text + "\n]\n";
}

TEST(RegressionTest, CountsOfAFixedStudyAreThoseOnRecord) {
#ifndef __x86_64__
  GTEST_SKIP() << "the counts on record are those of x86-64";
#endif
  const ScratchFolder folder;
  const std::string command = "LCPBENCH_ISA=baseline '" LCPBENCH_PROGRAM "' run '" LCPBENCH_PLAN "' --store '" +
                              (folder / "s.db").string() + "' >'" + (folder / "out").string() + "' 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_file(folder / "out");
  Store store = Store::open_for_reading(folder / "s.db");
  const Json found = counts_of(store);
  if (std::getenv("LCPBENCH_ACCEPT") != nullptr) {
    std::ofstream(LCPBENCH_COUNTS, std::ios::binary | std::ios::trunc) << document_text(found);
    GTEST_SKIP() << "wrote " << LCPBENCH_COUNTS;
  }
  const Json expected = Json::parse(read_file(LCPBENCH_COUNTS));
  ASSERT_GT(expected.size(), 50U) << LCPBENCH_COUNTS << " is not whole";
  const std::string changes = differences(expected, found);
  EXPECT_TRUE(changes.empty()) << "counts changed:\n" << changes << kToAccept;
}

}  // namespace
}  // namespace lcpbench::regression_test
