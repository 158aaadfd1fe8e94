#include "study/report/report.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <libxml/parser.h>

#include "study/report/canvas.h"
#include "study/output/csv.h"
#include "study/report/tables.h"
#include "study/report/decision.h"
#include "study/report/text.h"
#include "tests/support/synthetic_store.h"

namespace lcpbench {
namespace {

using report::Box;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kHeadlineSet = "paper/copositive/exp5-1e8";

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// A store with the three situations: `good` is exact and fast, `lemke` exact and slow, `liar` wrong on a third.
void fill(SyntheticStore& made, const std::string& extra_set = "") {
  const auto reference = made.solver("lemke");
  const auto good = made.solver("good", "engine=kernel");
  const auto liar = made.solver("liar", "", "", "Some library");
  const auto silent = made.solver("silent");
  const auto refusing = made.solver("refusing");
  std::vector<std::string> sets{"paper/monotone/exp1", "paper/copositive/exp1", kHeadlineSet};
  if (!extra_set.empty()) sets.push_back(extra_set);
  for (const std::string& set : sets) {
    const int friction_rows = set.find("monotone") == std::string::npos ? 20 : 0;
    for (std::int64_t trial = 0; trial < 60; ++trial) {
      const double size = 1 + 0.1 * static_cast<double>(trial % 7);
      const bool lie = trial % 3 == 0;
      made.problem(set, trial,
                   {{reference, {.error = 1e-11 * size, .time_s = 4e-3 * size}},
                    {good, {.error = 1e-12 * size, .time_s = 1e-4 * size}},
                    {liar, {.error = lie ? 0.3 : 1e-13, .criterion = false, .time_s = 5e-5 * size}},
                    {silent, {.claim = Claim::kIterationLimit, .error = kNone, .time_s = 1e-3}},
                    {refusing, {.claim = Claim::kUnsupported, .error = kNone, .detail = "only frictionless"}}},
                   friction_rows);
    }
  }
}

void expect_well_formed_xml(const std::string& text) {
  xmlDocPtr document = xmlReadMemory(text.data(), static_cast<int>(text.size()), "figure.svg", nullptr,
                                     XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING);
  EXPECT_NE(document, nullptr);
  xmlFreeDoc(document);
}

/// Splits a page into tags and the text between them; the content of <style> and <script> is in neither.
struct Markup {
  std::vector<std::string> tags;  ///< without their angle brackets
  std::string text;
};

Markup parse_markup(const std::string& page) {
  Markup markup;
  std::size_t at = 0;
  while (at < page.size()) {
    const std::size_t begin = page.find('<', at);
    markup.text += page.substr(at, begin - at) + " ";
    if (begin == std::string::npos) break;
    const std::size_t end = page.find('>', begin);
    if (end == std::string::npos) throw std::runtime_error("a tag without end");
    markup.tags.push_back(page.substr(begin + 1, end - begin - 1));
    at = end + 1;
    const std::string& tag = markup.tags.back();
    if (tag == "style" || tag == "script") at = page.find("</" + tag + ">", at);
  }
  return markup;
}

std::string element_name(const std::string& tag) { return tag.substr(0, tag.find_first_of(" \n")); }

/// Every element is closed in order, those that HTML does not close aside, and quotes of attributes come in pairs.
void expect_balanced(const std::string& page) {
  std::vector<std::string> open;
  for (const std::string& tag : parse_markup(page).tags) {
    const std::string name = element_name(tag);
    EXPECT_EQ(std::count(tag.begin(), tag.end(), '"') % 2, 0) << tag;
    if (tag.ends_with('/')) continue;  // an element of a picture, closed at once
    if (name == "!DOCTYPE" || name == "meta" || name == "img" || name == "br" || name == "wbr") continue;
    if (name.front() != '/') {
      open.push_back(name);
      continue;
    }
    ASSERT_FALSE(open.empty()) << "<" << name << "> closes nothing";
    EXPECT_EQ("/" + open.back(), name);
    open.pop_back();
  }
  EXPECT_TRUE(open.empty());
}

/// A link that leads nowhere is a promise of a section that the page has not.
void expect_links_lead_somewhere(const std::string& page) {
  const std::string link = "href=\"#";
  std::size_t links = 0;
  for (std::size_t at = page.find(link); at != std::string::npos; at = page.find(link, at + 1), ++links) {
    const std::size_t begin = at + link.size();
    const std::string id = page.substr(begin, page.find('"', begin) - begin);
    EXPECT_NE(page.find("id=\"" + id + "\""), std::string::npos) << id;
  }
  EXPECT_GT(links, 3U);
}

std::string visible_text(const std::string& page) { return parse_markup(page).text; }

bool has_word(const std::string& text, const std::string& word) {
  const auto is_letter = [&text](std::size_t i) {
    return i < text.size() && std::isalnum(static_cast<unsigned char>(text[i]));
  };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    if (!is_letter(at - 1) && !is_letter(at + word.size())) return true;
  }
  return false;
}

/// No number that is none reaches the reader.
void expect_only_numbers(const std::string& page) {
  for (const char* word : {"nan", "NaN", "inf", "infinity", "null"})
    EXPECT_FALSE(has_word(visible_text(page), word)) << word;
}

std::vector<std::string> split_csv_line(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += '"';
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

nlohmann::json at_path(const nlohmann::json& record, const std::string& column) {
  nlohmann::json value = record;
  std::istringstream names(column);
  for (std::string name; std::getline(names, name, '.');) value = value.at(name);
  return value;
}

class ReportTest : public testing::Test {
 protected:
  void write(const std::string& extra_set = "") {
    SyntheticStore made(folder_ / "s.db");
    fill(made, extra_set);
    write_report(made.store(), folder_ / "out");
    page_ = read_file(folder_ / "out/report.html");
  }

  ScratchFolder folder_;
  std::string page_;
};

TEST_F(ReportTest, PageIsBalancedAndSelfContained) {
  write();
  expect_balanced(page_);
  expect_links_lead_somewhere(page_);
  for (const char* reference : {"http:", "https:", "//www", "@import", "url(", "<link", "<iframe", "<object", "src=", "fetch("}) {
    EXPECT_EQ(page_.find(reference), std::string::npos) << reference;
  }
}

/// The files that the page links to lie beside it.
TEST_F(ReportTest, LinkedFilesExist) {
  write();
  const std::string link = "href=\"";
  int files = 0;
  for (std::size_t at = page_.find(link); at != std::string::npos; at = page_.find(link, at + 1)) {
    const std::size_t begin = at + link.size();
    const std::string file = page_.substr(begin, page_.find('"', begin) - begin);
    if (file.starts_with("#")) continue;
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / file)) << file;
    ++files;
  }
  EXPECT_GE(files, 6);
}

TEST_F(ReportTest, ReaderSeesNoNaNAndNoInfinity) {
  write();
  expect_only_numbers(page_);
}

TEST_F(ReportTest, FirstScreenRecommendsTheReliableAndNamesTheLiar) {
  write();
  const std::string first_screen = page_.substr(0, page_.find("Three limits"));
  EXPECT_NE(first_screen.find("For frictional contacts: <code>good{engine=kernel}</code>"), std::string::npos);
  EXPECT_NE(first_screen.find("<code>liar</code>: said solved and was wrong on 33.3 %"), std::string::npos);
  EXPECT_NE(first_screen.find("as reliable, 40.0× slower"), std::string::npos);
  EXPECT_NE(first_screen.find("<figure><div class=\"scroll\" tabindex=\"0\"><svg "), std::string::npos);
  EXPECT_NE(first_screen.find("the error ρ of 99 % of its answers is at most 1.6e-12"), std::string::npos);
  EXPECT_NE(first_screen.find("error ρ: 1.6e-12 <small>99 %</small>, 1.3e-12 <small>median</small>"),
            std::string::npos);
  EXPECT_NE(read_file(folder_ / "out/tables/decision.csv").find("error_median,error_p99"), std::string::npos);
}

/// One solver on one small set is no comparison, and the page must not read like one.
TEST_F(ReportTest, ASolverAloneIsSaidToBeAlone) {
  SyntheticStore made(folder_ / "s.db");
  const auto solver = made.solver("lemke");
  for (std::int64_t trial = 0; trial < 40; ++trial) made.problem("paper/monotone/exp1", trial, {{solver, {}}});
  write_report(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  expect_links_lead_somewhere(page);
  EXPECT_NE(page.find("<code>lemke</code> (the only solver here), which solved 100 % (91.2–100 %) of 40 problems"),
            std::string::npos);
  EXPECT_NE(page.find("shown instead is the only set it has"), std::string::npos);
  EXPECT_EQ(page.find(" 0 problems"), std::string::npos);
}

/// The words on the line of the verdict give way to a point, at whichever end of the picture it lies.
TEST_F(ReportTest, TheBoundsWordsStandClearOfThePoints) {
  const auto words_align_at = [this](double fast_error, double slow_error) {
    const ScratchFolder folder;
    SyntheticStore made(folder / "s.db");
    const auto fast = made.solver("fast");
    const auto slow = made.solver("slow");
    for (std::int64_t trial = 0; trial < 20; ++trial) {
      const bool worst = trial == 0;
      made.problem("paper/copositive/exp1", trial,
                   {{fast, {.error = worst ? fast_error : 1e-10, .time_s = 1.1e-6}},
                    {slow, {.error = worst ? slow_error : 1e-10, .time_s = 0.9}}},
                   10);
    }
    write_report(made.store(), folder_ / "out");
    const std::string svg = read_file(folder_ / "out/figures/headline.svg");
    const std::size_t words = svg.find("does not count as solved");
    const std::size_t element = svg.rfind("<text", words);
    return svg.find("text-anchor=\"end\"", element) < words ? "end" : "start";
  };
  EXPECT_EQ(words_align_at(1e-10, 1e-10), "end");
  EXPECT_EQ(words_align_at(1e-10, 2e-4), "start");
  EXPECT_EQ(words_align_at(2e-4, 1e-10), "end");
}

TEST_F(ReportTest, SkippedAndRefusingSolversStandWithTheirReasons) {
  write();
  EXPECT_NE(page_.find("<code>absent_solver</code>: library not found"), std::string::npos);
  EXPECT_NE(page_.find("does not take these problems: only frictionless"), std::string::npos);
}

TEST_F(ReportTest, GaveUpIsDefinedByAllVerdictsAndClaimsThatItCounts) {
  write();
  const std::size_t at = page_.find("<dt><strong>Gave up</strong></dt>");
  ASSERT_NE(at, std::string::npos);
  const std::string definition = page_.substr(at, page_.find("</dd>", at) - at);
  for (const char* words : {"Refused, missed and open", "iteration or time limit", "numerical failure", "a crash",
                            "refused the problem", "said that it has no solution"}) {
    EXPECT_NE(definition.find(words), std::string::npos) << words;
  }
}

TEST_F(ReportTest, TablesReadBackToTheNumbersOfTheSummary) {
  write();
  const auto summary = nlohmann::json::parse(read_file(folder_ / "out/summary.json"));
  std::istringstream csv(read_file(folder_ / "out/tables/cells.csv"));
  std::string line;
  std::getline(csv, line);
  const std::vector<std::string> columns = split_csv_line(line);
  ASSERT_GT(columns.size(), 30U);
  std::size_t row = 0;
  for (; std::getline(csv, line); ++row) {
    const std::vector<std::string> fields = split_csv_line(line);
    ASSERT_EQ(fields.size(), columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const nlohmann::json expected = at_path(summary["cells"].at(row), columns[i]);
      const std::string text = expected.is_string() ? expected.get<std::string>() : fields[i];
      EXPECT_EQ(fields[i], text);
      EXPECT_EQ(fields[i].empty(), expected.is_null() || text.empty()) << columns[i];
      if (expected.is_number()) {
        EXPECT_EQ(std::strtod(fields[i].c_str(), nullptr), expected.get<double>()) << columns[i];
      }
    }
  }
  EXPECT_EQ(row, summary["cells"].size());
}

TEST_F(ReportTest, FiguresAreValidPicturesInLightAndDark) {
  write();
  for (const char* name :
       {"headline", "paper_copositive_exp5-1e8", "paper_monotone_exp1", "paper_monotone_exp1.errors"}) {
    const std::string svg = read_file(folder_ / ("out/figures/" + std::string(name) + ".svg"));
    ASSERT_FALSE(svg.empty()) << name;
    expect_well_formed_xml(svg);
    EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos);
    EXPECT_NE(svg.find("class=\"c-ground\""), std::string::npos);
    EXPECT_EQ(svg.find("fill=\"#"), std::string::npos) << "a colour that does not follow the reader's scheme";
    EXPECT_NE(svg.find("good{engine=kernel}"), std::string::npos) << name;
  }
  EXPECT_EQ(page_.find("<style>svg"), std::string::npos) << "the page has the pictures' style sheet once";
}

TEST_F(ReportTest, HostileNamesStayText) {
  write("<script>alert('x')</script>&\"copositive\"/../../e\n]]>\x01vil'\xff");
  EXPECT_EQ(page_.find("<script>alert"), std::string::npos);
  EXPECT_NE(page_.find("&lt;script&gt;alert(&#39;x&#39;)"), std::string::npos);
  expect_balanced(page_);
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out/figures")) {
    expect_well_formed_xml(read_file(entry.path()));
  }
  EXPECT_NO_THROW(nlohmann::json::parse(read_file(folder_ / "out/summary.json")));
}

TEST_F(ReportTest, WithoutTheHeadlineSetTheHardestFrictionalSetStandsIn) {
  SyntheticStore made(folder_ / "s.db");
  const auto solver = made.solver("lemke");
  for (std::int64_t trial = 0; trial < 5; ++trial) {
    made.problem("paper/copositive/exp1", trial, {{solver, {}}}, 10);
    made.problem("paper/copositive/exp2", trial, {{solver, {.error = trial == 0 ? 0.1 : 1e-12, .criterion = false}}},
                 10);
    made.problem("paper/monotone/exp1", trial, {{solver, {.error = 0.1, .criterion = false}}});
  }
  const Summary summary = summarize(made.store());
  ASSERT_TRUE(report::headline_set(summary).has_value());
  EXPECT_EQ(summary.sets[*report::headline_set(summary)].name, "paper/copositive/exp2");
  write_report(made.store(), folder_ / "out");
  EXPECT_NE(read_file(folder_ / "out/report.html").find("shown instead is the hardest set it has"), std::string::npos);
}

/// Whoever adds solvers must not push the picture off the first screen.
TEST_F(ReportTest, TheDecisionTableStaysSmallWithManySolvers) {
  SyntheticStore made(folder_ / "s.db");
  std::vector<std::pair<std::int64_t, MadeAnswer>> answers;
  for (int i = 0; i < 9; ++i)
    answers.emplace_back(made.solver("s" + std::to_string(i)), MadeAnswer{.time_s = 1e-3 * (i + 1)});
  for (int trial = 0; trial < 60; ++trial) made.problem("paper/copositive/exp1", trial, answers);
  write_report(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  expect_balanced(page);
  const std::size_t fold = page.find("<details><summary>and 4 more</summary>");
  ASSERT_NE(fold, std::string::npos);
  EXPECT_LT(page.find("<code>s4</code>: "), fold);
  EXPECT_GT(page.find("<code>s5</code>: "), fold) << "the best come first";
}

TEST_F(ReportTest, EmptyStoreStillGivesAReport) {
  SyntheticStore made(folder_ / "s.db");
  write_report(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  expect_balanced(page);
  expect_links_lead_somewhere(page);
  EXPECT_NE(page.find("does not yet hold enough verified answers"), std::string::npos);
  EXPECT_EQ(table_text(summarize(made.store()), 100), "no answers yet\n");
}

TEST_F(ReportTest, TablesWithoutRowsHaveTheSameHeaderAsThoseWithRows) {
  SyntheticStore none(folder_ / "none.db");
  SyntheticStore some(folder_ / "some.db");
  const auto solver = some.solver("lemke");
  const auto swept = some.solver("lemke", "zero_tolerance=1e-4", "paper");
  some.problem("paper/monotone/exp3", 0, {{solver, {}}, {swept, {}}});
  write_report(none.store(), folder_ / "none");
  write_report(some.store(), folder_ / "some");
  for (const char* table : {"cells.csv", "results.csv", "sweeps.csv", "claims.csv", "decision.csv"}) {
    const std::string rows = read_file(folder_ / "some/tables" / table);
    const std::string header = rows.substr(0, rows.find('\n') + 1);
    EXPECT_GT(header.size(), 20U) << table;
    EXPECT_GT(rows.size(), header.size()) << table;
    EXPECT_TRUE(read_file(folder_ / "none/tables" / table).starts_with(header)) << table;
  }
  EXPECT_EQ(read_file(folder_ / "none/tables/sweeps.csv").find('\n') + 1,
            read_file(folder_ / "none/tables/sweeps.csv").size());
}

TEST_F(ReportTest, TerminalTableKeepsItsColumnsApartWhenAnErrorIsNoNumber) {
  SyntheticStore made(folder_ / "s.db");
  const auto solver = made.solver("lemke");
  made.problem("paper/monotone/exp3", 0, {{solver, {.error = kNone}}});
  const std::string text = table_text(summarize(made.store()), 100);
  EXPECT_NE(text.find(" none\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("no number"), std::string::npos) << text;
}

TEST_F(ReportTest, TerminalTableKeepsItsColumnsUnderLongNames) {
  SyntheticStore made(folder_ / "s.db");
  const auto brief = made.solver("lemke");
  const auto wordy = made.solver("bullet_mlcp_lemke", "box=false,max_value=1e+10");
  made.problem("paper/monotone/exp3", 0, {{brief, {}}, {wordy, {}}});
  std::istringstream lines(table_text(summarize(made.store()), 100));
  std::vector<std::size_t> columns;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("100 %") != std::string::npos) columns.push_back(line.find("100 %"));
  }
  ASSERT_EQ(columns.size(), 2U);
  EXPECT_EQ(columns[0], columns[1]);
}

TEST_F(ReportTest, SetWhereAllIsUnsolvableHasNoRate) {
  SyntheticStore made(folder_ / "s.db");
  const auto solver = made.solver("lemke");
  for (std::int64_t trial = 0; trial < 3; ++trial) {
    made.problem("paper/monotone/exp3", trial,
                 {{solver, {.claim = Claim::kUnsolvable, .error = kNone, .proves_unsolvable = true}}}, 0, "");
  }
  write_report(made.store(), folder_ / "out");
  const std::string page = read_file(folder_ / "out/report.html");
  expect_only_numbers(page);
  EXPECT_NE(page.find("3 unsolvable"), std::string::npos);
}

TEST_F(ReportTest, PicturesNeedNoOtherProgramAndNoTemporaryFiles) {
  SyntheticStore made(folder_ / "s.db");
  fill(made);
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  setenv("TMPDIR", "/nonexistent", 1);
  write_report(made.store(), folder_ / "out");
  setenv("PATH", path.c_str(), 1);
  unsetenv("TMPDIR");
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/figures/headline.svg"));
}

TEST_F(ReportTest, AFolderThatCannotBeMadeIsOneClearLine) {
  SyntheticStore made(folder_ / "s.db");
  std::ofstream(folder_ / "file") << "x";
  try {
    write_report(made.store(), folder_ / "file/out");
    FAIL() << "wrote into a file";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what()).find("file/out: cannot make the folder"), std::string::npos);
  }
}

TEST_F(ReportTest, TerminalTableFitsAndNamesEverySolver) {
  SyntheticStore made(folder_ / "s.db");
  fill(made);
  const std::string out = table_text(summarize(made.store()), 100);
  std::istringstream lines(out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(character_count(line), 100U) << line;
  for (const char* expected : {"good{engine=kernel}", "liar", "33.3 %", "does not take these", "130 µs"}) {
    EXPECT_NE(out.find(expected), std::string::npos) << expected;
  }
}

/// A solver that met ten problems and solved all must not beat one that solved sixty of sixty.
TEST(DecisionTest, SmallSampleIsNotRecommended) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto steady = made.solver("steady");
  const auto sampled = made.solver("sampled");
  for (std::int64_t trial = 0; trial < 60; ++trial) {
    std::vector<std::pair<std::int64_t, MadeAnswer>> answers{{steady, {.time_s = 1e-2}}};
    if (trial % 6 == 0) answers.push_back({sampled, {.time_s = 1e-5}});
    made.problem("paper/monotone/exp1", trial, answers);
  }
  const Summary summary = summarize(made.store());
  const auto situations = report::decide(summary);
  ASSERT_TRUE(situations[0].recommended.has_value());
  EXPECT_EQ(summary.solvers[situations[0].contenders[0].solver].name, "steady");
  EXPECT_TRUE(situations[0].contenders[1].sampled);
  EXPECT_TRUE(situations[1].contenders.empty());
}

TEST(DecisionTest, IndistinguishableSolversAreATie) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto a = made.solver("a");
  const auto b = made.solver("b");
  for (std::int64_t trial = 0; trial < 60; ++trial) {
    const double size = 1 + static_cast<double>(trial % 5);
    made.problem("paper/monotone/exp1", trial, {{a, {.time_s = 1e-3 * size}}, {b, {.time_s = 1.01e-3 * size}}});
  }
  const auto situations = report::decide(summarize(made.store()));
  ASSERT_EQ(situations[0].contenders.size(), 2U);
  EXPECT_TRUE(situations[0].contenders[1].tie);
}

/// A set that is there for a sweep or one question would leave nobody who met all.
TEST(DecisionTest, SetsThatFewSolversMetDoNotCount) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto a = made.solver("a");
  const auto b = made.solver("b");
  const auto c = made.solver("c");
  const auto swept = made.solver("lemke", "zero_tolerance=1e-4", "paper");
  for (std::int64_t trial = 0; trial < 40; ++trial) {
    made.problem("paper/monotone/exp1", trial, {{a, {.time_s = 1e-5}}, {b, {.time_s = 1e-2}}, {c, {.time_s = 1e-2}}});
    made.problem("paper/monotone/exp1{x=bell}", trial, {{swept, {}}});
    made.problem("paper/monotone/exp2", trial, {{b, {.time_s = 1e-6}}});
  }
  const Summary summary = summarize(made.store());
  const auto situations = report::decide(summary);
  ASSERT_EQ(situations[0].sets.size(), 1U);
  EXPECT_EQ(summary.sets[situations[0].sets[0]].name, "paper/monotone/exp1");
  ASSERT_TRUE(situations[0].recommended.has_value());
  EXPECT_EQ(summary.solvers[situations[0].contenders[0].solver].name, "a");
}

TEST(DecisionTest, NothingSolvedRecommendsNothing) {
  const ScratchFolder folder;
  SyntheticStore made(folder / "s.db");
  const auto bad = made.solver("bad");
  for (std::int64_t trial = 0; trial < 10; ++trial) {
    made.problem("paper/monotone/exp1", trial, {{bad, {.error = 1, .criterion = false}}});
  }
  const auto situations = report::decide(summarize(made.store()));
  EXPECT_FALSE(situations[0].recommended.has_value());
  EXPECT_EQ(situations[0].contenders[0].verdict, "said solved and was wrong on 100 %");
}

TEST(LabelTest, LabelsOfCrowdedPointsDoNotOverlap) {
  std::vector<report::LabelledPoint> points;
  for (int i = 0; i < 9; ++i) points.push_back({300.0 + 4 * (i % 3), 200.0 + 4 * (i / 3), 120});
  const Box area{0, 0, 800, 400};
  const std::vector<Box> obstacles{{0, 250, 800, 254}};
  const auto placed = report::place_labels(points, obstacles, area, 15);
  for (std::size_t i = 0; i < placed.size(); ++i) {
    EXPECT_TRUE(area.contains(placed[i].box));
    EXPECT_EQ(placed[i].box.overlap(obstacles[0]), 0);
    for (std::size_t j = 0; j < i; ++j) EXPECT_EQ(placed[i].box.overlap(placed[j].box), 0) << i << " and " << j;
  }
}

TEST(LabelTest, LabelAtTheEdgeStaysInside) {
  const std::vector<report::LabelledPoint> points{{798, 2, 100}};
  EXPECT_TRUE((Box{0, 0, 800, 400}.contains(report::place_labels(points, {}, {0, 0, 800, 400}, 15)[0].box)));
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
  EXPECT_EQ(report::duration_range(2.7e-4, 2.9e-4), "270–290 µs");
  EXPECT_EQ(report::duration_range(5.1e-5, 2.74e-3), "51.0 µs–2.74 ms");
  EXPECT_EQ(report::speed(0.025), "40.0× faster");
  EXPECT_EQ(report::speed(2.5), "2.50× slower");
  EXPECT_EQ(report::speed(1.02), "same time");
  EXPECT_EQ(report::factor(12345), "12300");
  EXPECT_EQ(report::factor(0.00891), "0.0089");
  EXPECT_EQ(report::scientific(std::numeric_limits<double>::infinity()), "no number");
}

TEST(TextTest, EscapesMarkupAndMendsBrokenText) {
  EXPECT_EQ(report::escape("<a href=\"x\">&'"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(report::escape("µ→"), "µ→");
  EXPECT_EQ(report::escape("a\xff\x01z"), "a\uFFFD\uFFFDz");
  EXPECT_EQ(report::escape("\xed\xa0\x80"), "\uFFFD\uFFFD\uFFFD");
}

TEST(CsvTest, QuotesWhatNeedsItAndKeepsEmptyFirstFields) {
  const auto records =
      nlohmann::ordered_json::parse(R"([{"a": "", "b": {"c": 0.1}}, {"a": "x,\"y\"", "b": {"c": null}}])");
  EXPECT_EQ(csv_table(records[0], records), "a,b.c\n,0.1\n\"x,\"\"y\"\"\",\n");
  EXPECT_EQ(csv_table(records[0], nlohmann::ordered_json::array()), "a,b.c\n");
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
  EXPECT_EQ(csv_table(records[0], records), "'=a,number,whole\n'=b,-1.5,-3\n");
}

}  // namespace
}  // namespace lcpbench
