#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "study/report/report.h"
#include "study/report/canvas.h"
#include "study/report/axes.h"
#include "study/report/speed_error.h"
#include "tests/support/program_run.h"
#include "tests/support/synthetic_store.h"

// What a reader of report.html meets: its size, its folds, its pictures, the choice of a reference.

namespace lcpbench {
namespace {

using report::Box;

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++count;
  return count;
}

/// The text of the page that is not folded, without tags, style sheets, scripts and pictures.
std::string unfolded_text(const std::string& page) {
  std::string text;
  int folds = 0;
  int hidden = 0;
  for (std::size_t at = 0; at < page.size();) {
    const std::size_t begin = std::min(page.find('<', at), page.size());
    if (folds == 0 && hidden == 0) text += page.substr(at, begin - at);
    const std::size_t end = page.find('>', begin);
    if (end == std::string::npos) break;
    const std::string tag = page.substr(begin + 1, end - begin - 1);
    if (tag.starts_with("details")) ++folds;
    if (tag == "/details") --folds;
    for (const char* element : {"style", "script", "svg"}) {
      if (tag.starts_with(element)) ++hidden;
      if (tag == "/" + std::string(element)) --hidden;
    }
    at = end + 1;
  }
  return text;
}

class ReportPageTest : public testing::Test {
 protected:
  ReportPageTest() : made_(folder_ / "s.db") {}

  void write() {
    write_report(made_.store(), folder_ / "out");
    page_ = read_file(folder_ / "out/report.html");
  }

  /// Sets that each of many solvers meets, with errors and times of their own.
  void fill(int sets, int solvers, int trials) {
    std::vector<std::int64_t> ids{made_.solver("lemke", "engine=dense")};
    while (std::ssize(ids) < solvers) {
      const auto number = std::to_string(ids.size());
      ids.push_back(made_.solver("solver_" + number, "", "", ids.size() % 2 == 0 ? "native" : "Library " + number));
    }
    for (int set = 0; set < sets; ++set) {
      for (int trial = 0; trial < trials; ++trial) {
        std::vector<std::pair<std::int64_t, MadeAnswer>> answers;
        for (std::size_t i = 0; i < ids.size(); ++i) {
          const double size = 1 + 0.37 * ((trial * 7 + static_cast<int>(i) * 3 + set) % 11);
          const double error = std::pow(10, -8.0 - static_cast<double>(i % 7)) * size;
          answers.push_back({ids[i], {.error = error, .time_s = 1e-6 * static_cast<double>(i + 1) * size}});
        }
        made_.problem("paper/copositive/exp1{variant=" + std::to_string(set) + "}", trial, answers, 10);
      }
    }
  }

  ScratchFolder folder_;
  SyntheticStore made_;
  std::string page_;
};

/// The main study has some 400 cells of 21 sets and may have 3 MB; the style sheets and words take 60 kB.
TEST_F(ReportPageTest, BytesGrowSlowlyWithTheCells) {
  fill(6, 20, 40);
  write();
  const std::size_t cells = 6 * 20;
  EXPECT_LT(page_.size(), 60000 + cells * 5000);
}

/// A page of print holds some 3,000 characters of tables and text beside the headline's picture.
TEST_F(ReportPageTest, WhatIsNotFoldedPrintsOnFewPages) {
  fill(6, 20, 40);
  write();
  const std::size_t six_sets = unfolded_text(page_).size();
  EXPECT_LT(six_sets, 3u * 3000);
  EXPECT_NE(page_.find("@media print"), std::string::npos);
  EXPECT_EQ(page_.find("<details open"), std::string::npos);
}

TEST_F(ReportPageTest, CellsStandInTheirTablesAndNotInThePage) {
  fill(2, 5, 40);
  write();
  EXPECT_EQ(page_.find("even_trials"), std::string::npos);
  const std::string results = read_file(folder_ / "out/tables/results.csv");
  EXPECT_EQ(results.substr(0, results.find('\n')),
            "set,solver,library,problems,solved_share,solved_share_low,solved_share_high,false_claims,gave_up,refused,"
            "median_time_s,median_time_low_s,median_time_high_s,time_ratio,time_ratio_low,time_ratio_high,"
            "time_ratio_problems,error_median,"
            "error_p99,reliability,model,solver_error_median_m_per_s,model_error_median_m_per_s,"
            "worst_trial,worst_replay");
  EXPECT_EQ(count_of(results, "\n"), 1U + 2 * 5);
  EXPECT_NE(results.find("paper/copositive/exp1{variant=0},solver_1,Library 1,40,1.0,"), std::string::npos) << results;
}

TEST_F(ReportPageTest, ProvenanceIsForPeopleAndTheRecordIsFolded) {
  fill(1, 2, 5);
  write();
  const std::string section = page_.substr(page_.find("<section id=\"provenance\">"));
  const std::string facts = section.substr(0, section.find("<details"));
  for (const char* words : {"2026-01-31 12:00 UTC", "5 problems of 1 set, 2 solvers and settings, 10 answers",
                            "test processor", "test compiler", "lcpbench run quick", "not recorded"}) {
    EXPECT_NE(facts.find(words), std::string::npos) << words;
  }
  EXPECT_NE(section.find("<summary>The full record of the run of 2026-01-31T12:00:00Z</summary>"), std::string::npos);
}

nlohmann::json factors_of(const std::string& page) {
  const std::string opening = "<script type=\"application/json\" id=\"factors\">";
  const std::size_t begin = page.find(opening) + opening.size();
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

/// The page's script divides nothing but these: a solver's summed time over another one's where both solved.
TEST_F(ReportPageTest, FactorsOverAnySolverStandInThePage) {
  const auto reference = made_.solver("lemke", "engine=dense");
  const auto library = made_.solver("engine", "", "", "Some library");
  const auto quick = made_.solver("quick");
  for (std::int64_t trial = 0; trial < 40; ++trial) {
    const bool fails = trial == 0;
    made_.problem("paper/copositive/exp1", trial,
                  {{reference, {.time_s = 8e-3}},
                   {library, {.claim = fails ? Claim::kIterationLimit : Claim::kSolved,
                              .error = fails ? std::nan("") : 1e-12,
                              .time_s = fails ? 9.0 : 2e-3}},
                   {quick, {.time_s = 1e-3}}},
                  10);
  }
  write();
  const nlohmann::json factors = factors_of(page_);
  std::map<std::string, int> number;
  for (const auto& [key, name] : factors["solvers"].items()) number[name] = std::stoi(key);
  ASSERT_EQ(number.size(), 3U);
  const nlohmann::json& set = factors["by_set"]["0"];
  ASSERT_EQ(set["of"].size(), 3U);
  const auto over = [&](const std::string& solver, const std::string& reference_solver) {
    const auto place = [&set, &number](const std::string& name) {
      return std::find(set["of"].begin(), set["of"].end(), number.at(name)) - set["of"].begin();
    };
    const auto i = place(solver);
    const auto j = place(reference_solver);
    return i < j ? set["factors"][static_cast<std::size_t>(i)][static_cast<std::size_t>(j - i - 1)].get<double>()
                 : 1 / set["factors"][static_cast<std::size_t>(j)][static_cast<std::size_t>(i - j - 1)].get<double>();
  };
  EXPECT_DOUBLE_EQ(over("quick", "engine"), 0.5);
  EXPECT_DOUBLE_EQ(over("quick", "lemke{engine=dense}"), 0.125);
  EXPECT_DOUBLE_EQ(over("engine", "lemke{engine=dense}"), 0.25);
  EXPECT_NE(page_.find("<p id=\"reference\" hidden>"), std::string::npos) << "without the script there is no choice";
  EXPECT_NE(page_.find("<optgroup label=\"Libraries\"><option value=\"" + std::to_string(number["engine"]) + "\">engine"),
            std::string::npos);
  EXPECT_NE(page_.find("data-factor=\"0:" + std::to_string(number["quick"]) + "\">0.12"), std::string::npos);
  EXPECT_NE(page_.find("data-speed=\"s1:" + std::to_string(number["quick"]) + "\">8.00× faster than the dense reference"),
            std::string::npos);
}

/// The centres of the circles and the starts of the paths that are hollow.
std::vector<std::string> hollow_markers(const std::string& svg) {
  std::vector<std::string> markers;
  for (std::size_t at = svg.find("class=\"h "); at != std::string::npos; at = svg.find("class=\"h ", at + 1)) {
    markers.push_back(svg.substr(at, svg.find("/>", at) - at));
  }
  return markers;
}

double attribute(const std::string& element, const std::string& name) {
  const std::size_t at = element.find(name + "=\"");
  return at == std::string::npos ? std::nan("") : std::stod(element.substr(at + name.size() + 2));
}

/// A solver that solves a tenth of the problems exactly, and gives up on the others, is the most accurate of all by the
/// answers that it gave. Nothing may draw it there.
TEST_F(ReportPageTest, FailuresAreDrawnInTheirBandAndNotAsSmallErrors) {
  const auto reference = made_.solver("lemke", "engine=dense");
  const auto rung = made_.solver("lemke", "precision=quad");
  for (const char* set : {"paper/copositive/exp5-1e5", "paper/copositive/exp5-1e8"}) {
    for (std::int64_t trial = 0; trial < 50; ++trial) {
      const bool solves = trial % 10 == 0;
      made_.problem(set, trial,
                    {{reference, {.error = 1e-9, .time_s = 1e-3}},
                     {rung, {.claim = solves ? Claim::kSolved : Claim::kNumericalFailure,
                             .error = solves ? 0.0 : std::nan(""),
                             .time_s = 1e-4}}},
                    10);
    }
  }
  write();
  const std::string picture = read_file(folder_ / "out/figures/paper_copositive_exp5-1e8.svg");
  const std::vector<std::string> markers = hollow_markers(picture);
  ASSERT_EQ(markers.size(), 2U) << "the point and its entry in the legend";
  EXPECT_NE(picture.find(">failed</text>"), std::string::npos);
  EXPECT_EQ(picture.find("10⁻¹⁷"), std::string::npos) << "no error of this picture is that small";
  // The band lies above the errors, whose axis begins at the highest line of the grid.
  EXPECT_LT(attribute(markers[0], "cy"), 92 + 64);
  EXPECT_NE(picture.find("Failed: lemke{precision=quad}"), std::string::npos);
  const std::string dial = read_file(folder_ / "out/figures/paper_copositive_exp5-.conditioning.svg");
  EXPECT_GE(hollow_markers(dial).size(), 2U);
  EXPECT_EQ(dial.find("10⁻¹⁷"), std::string::npos);
  EXPECT_NE(dial.find("failed at 1e8"), std::string::npos);
}

/// Thirty solvers, ten of them wrong on something: the wrong and the frontier have names, as far as there is room.
TEST_F(ReportPageTest, CrowdedPicturesNumberTheirPoints) {
  std::vector<std::int64_t> ids{made_.solver("lemke", "engine=dense")};
  while (ids.size() < 30) ids.push_back(made_.solver("a_solver_with_a_name_" + std::to_string(ids.size())));
  for (int trial = 0; trial < 60; ++trial) {
    std::vector<std::pair<std::int64_t, MadeAnswer>> answers;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      const bool wrong = i % 3 == 2 && trial == 0;
      const double error = std::pow(10, -9.0 - static_cast<double>(i % 4) / 4);
      answers.push_back({ids[i], {.error = wrong ? 0.5 : error, .time_s = 1e-4 * (1 + 0.05 * static_cast<double>(i))}});
    }
    made_.problem("paper/copositive/exp1", trial, answers, 10);
  }
  write();
  const std::string picture = read_file(folder_ / "out/figures/paper_copositive_exp1.svg");
  std::size_t named = 0;
  for (int i = 1; i < 30; ++i) {
    const std::string name = "a_solver_with_a_name_" + std::to_string(i);
    EXPECT_NE(picture.find(name), std::string::npos) << name << " has neither a label nor an entry in the list";
    named += count_of(picture, ">" + name + "</text>") > 0 ? 1 : 0;
  }
  EXPECT_LE(named, 16U);
  EXPECT_NE(picture.find("> 1  "), std::string::npos) << "the list of the numbers";
}

TEST(CrowdedLabelTest, OverlapsAndCrossingsAreFound) {
  const std::vector<report::LabelledPoint> points{{100, 100, 60}, {100, 160, 60}, {400, 100, 60}};
  std::vector<report::PlacedLabel> placed{{{200, 150, 260, 165}, true}, {{200, 95, 260, 110}, true},
                                          {{410, 95, 470, 110}, false}};
  EXPECT_EQ(report::crowded_labels(points, placed), (std::vector<std::size_t>{0, 1})) << "their leaders cross";
  placed = {{{110, 95, 170, 110}, false}, {{150, 100, 210, 115}, false}, {{410, 95, 470, 110}, false}};
  EXPECT_EQ(report::crowded_labels(points, placed), (std::vector<std::size_t>{0, 1})) << "they overlap";
  placed = {{{110, 95, 170, 110}, false}, {{110, 155, 170, 170}, false}, {{410, 95, 470, 110}, false}};
  EXPECT_TRUE(report::crowded_labels(points, placed).empty());
}

/// A film has thousands of bodies and dots: where nothing changes, nothing is written.
TEST(CurveTest, FlatStretchesAndDotsAtOnePlaceAreWrittenOnce) {
  report::Canvas canvas(10, 10);
  canvas.steps({{0, 1}, {1, 1}, {2, 1}, {3, 5}, {4, 5}}, {});
  canvas.steps({{0, 1}, {1, 1}}, {});
  canvas.dots({{1, 2}, {3, 4}, {1, 2.04}}, 2, report::kInk);
  const std::string svg = canvas.draw("a", "b");
  EXPECT_NE(svg.find("d=\"M0.0 1.0H3.0V5.0H4.0\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("d=\"M0.0 1.0H1.0\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("stroke-width=\"4\" stroke-linecap=\"round\" d=\"M1.0 2.0h0M3.0 4.0h0\""), std::string::npos)
      << svg;
}

TEST(CurveTest, APictureOfManyProblemsIsNoLarger) {
  report::Curve curve{"solver", 0, {}};
  constexpr int kProblems = 20000;
  for (int i = 1; i <= kProblems; ++i) curve.steps.emplace_back(1e-12 * i, static_cast<double>(i) / kProblems);
  report::ShareAxes axes;
  axes.tic = [](int) { return std::string("tic"); };
  EXPECT_LT(report::draw_shares(SetSummary{}, axes, {curve}).size(), 25000U);
}

TEST(CurveStyleTest, NoTwoCurvesOfAPictureLookAlike) {
  std::set<std::pair<std::string, std::string>> styles;
  for (std::size_t number = 0; number < 80; ++number) {
    const report::Stroke stroke = report::curve_stroke(number, 1.8);
    EXPECT_TRUE(styles.emplace(stroke.color, stroke.dash).second) << number;
  }
}

}  // namespace
}  // namespace lcpbench
