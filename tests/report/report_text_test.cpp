// Numbers and tables as texts.

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "study/output/csv.h"
#include "study/report/text.h"

namespace lcpbench::report_text_test {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TEST(CsvTest, QuotesWhatNeedsItAndKeepsEmptyFirstFields) {
  const auto records =
      nlohmann::ordered_json::parse(R"([{"a": "", "b": {"c": 0.1}}, {"a": "x,\"y\"", "b": {"c": null}}])");
  EXPECT_EQ(csv_table(Json::array({flattened(records[0]), flattened(records[1])})), "a,b.c\n,0.1\n\"x,\"\"y\"\"\",\n");
  EXPECT_EQ(csv_table({"a", "b.c"}, {}), "a,b.c\n");
  EXPECT_EQ(csv_table({"a"}, {Json::array({1}), Json::array({nullptr})}), "a\n1\n\"\"\n") << "no line is empty";
}

/// A spreadsheet would run such a cell, a terminal would obey it; numbers stay numbers.
TEST(CsvTest, TextsAreNoFormulasAndCommandNoTerminal) {
  for (const auto& [text, cell] :
       std::vector<std::pair<std::string, std::string>>{{"=1+1", "'=1+1"},
                                                        {"@SUM(A1)", "'@SUM(A1)"},
                                                        {"+cmd|' /C calc'!A0", "'+cmd|' /C calc'!A0"},
                                                        {"-2,3", "\"'-2,3\""},
                                                        {"-1.5e-10", "-1.5e-10"},
                                                        {"+7", "+7"},
                                                        {"-", "'-"},
                                                        {"a-b=c", "a-b=c"},
                                                        {"\x1b[31mred\n\x7f", "?[31mred??"},
                                                        {"\u009b31m \xff\u2013", "?31m ?\u2013"}}) {
    EXPECT_EQ(csv_text(text), cell);
  }
  const auto records = nlohmann::ordered_json::parse(R"([{"=a": "=b", "number": -1.5, "whole": -3}])");
  EXPECT_EQ(csv_table(records), "'=a,number,whole\n'=b,-1.5,-3\n");
}

TEST(TextTest, NumbersHaveUnitsAndNeverRoundToCertainty) {
  EXPECT_EQ(report::percent(1.0), "100 %");
  EXPECT_EQ(report::percent(0.99999), ">99.99 %");
  EXPECT_EQ(report::percent(0.9998), "99.98 %");
  EXPECT_EQ(report::percent(1.0 / 3), "33.3 %");
  EXPECT_EQ(report::percent(0.00001), "<0.01 %");
  EXPECT_EQ(report::percent(0), "0 %");
  EXPECT_EQ(report::percent(kNone), "–");
  EXPECT_EQ(report::duration(2.814e-4), "281 µs");
  EXPECT_EQ(report::duration(9.999e-4), "1.00 ms");
  EXPECT_EQ(report::duration(0.99996), "1.00 s");
  EXPECT_EQ(report::duration(12.34), "12.3 s");
  EXPECT_EQ(report::duration(4e-9), "4.00 ns");
  EXPECT_EQ(report::duration(kNone), "–");
  EXPECT_EQ(report::factor(12345), "12300");
  EXPECT_EQ(report::factor(0.00891), "0.0089");
  EXPECT_EQ(report::scientific(std::numeric_limits<double>::infinity()), "no number");
}

}  // namespace
}  // namespace lcpbench::report_text_test
