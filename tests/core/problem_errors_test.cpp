// What a user is told about a file that cannot be used: one line with file, field and cause. Messages are compared
// whole, because people and scripts read them.

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"

namespace lcpbench::problem_errors_test {
namespace {

const std::string kLcp = R"({"format": "lcpbench-problem", "version": 1, "name": "two", "kind": "lcp",)"
                         R"( "M": [[2, 1], [1, 2]], "q": [-5, -6]})";

// One free coordinate pair, two contacts; the second has a friction pyramid.
const std::string kContact = R"({"format": "lcpbench-problem", "version": 1, "name": "pair", "kind": "contact",)"
                             R"( "v": [1, -2], "N": [[1, 0], [0.5, 1]], "D": [[1, 0, -1, 0], [0.25, 1, -0.25, -1]],)"
                             R"( "edges": [0, 4], "mu": [0, 0.5], "G": [[2, 0.5], [0.5, 1]]})";

// A hinge without bounds, a limit, and friction of its load.
const std::string kRows = R"({"format": "lcpbench-problem", "version": 1, "name": "arm", "kind": "contact",)"
                          R"( "v": [1, -2], "N": [[1], [0.5]], "G": [[2, 0.5], [0.5, 1]],)"
                          R"( "rows": {"R": [[1, 0, 1], [0, 1, 1]], "lower": [null, 0, null],)"
                          R"( "upper": [null, null, null], "b": [0, 1, 0], "compliance": [0.5, 0, 0],)"
                          R"( "friction_of": [null, null, 1], "mu": [null, null, 0.25], "unit": ["m", "rad", "m"],)"
                          R"( "names": ["hinge", "stop", ""]}})";

const std::string kScene =
    R"({"format": "lcpbench-problem", "version": 1, "name": "ball", "kind": "scene",)"
    R"( "bodies": [{"mass": 2, "inertia": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "position": [0, 0, 1],)"
    R"( "linear_velocity": [0, 0, -1], "angular_velocity": [0, 0, 0]}],)"
    R"( "contacts": [{"body_a": 0, "body_b": -1, "point": [0, 0, 0], "normal": [0, 0, 1],)"
    R"( "tangent": [1, 0, 0], "mu": 0.5, "edges": 4}]})";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << "the test replaces what is not there: " << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string error_of(const std::string& text) {
  try {
    parse_problem_json(text, "box.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

struct BadFile {
  std::string text;
  std::string message;
};

void expect_errors(const std::vector<BadFile>& files) {
  for (const BadFile& file : files)
    EXPECT_EQ(error_of(file.text), "box.json: " + file.message) << file.text.substr(0, 400);
}

TEST(ProblemErrorsTest, TheUnchangedFilesAreGood) {
  for (const std::string& text : {kLcp, kContact, kRows, kScene}) EXPECT_EQ(error_of(text), "no error");
}

TEST(ProblemErrorsTest, Header) {
  expect_errors({
      {replaced(kLcp, R"("format": "lcpbench-problem", )", ""), 
       "format: missing; a problem file has format, version, name and kind, and the fields of its kind"},
      {replaced(kLcp, "lcpbench-problem", "other"), "format: 'other', expected 'lcpbench-problem'"},
      {replaced(kLcp, R"("version": 1)", R"("version": 2)"), "version: 2 is not known; this program reads version 1"},
      {replaced(kLcp, "two", std::string(1001, 'x')), "name: 1001 bytes long, at most 1000 are allowed"},
      {replaced(kLcp, "two", "a\\u0085b"), "name: has a control character"},
      {replaced(kLcp, R"("kind": "lcp")", R"("kind": "qp")"), "kind: 'qp', expected 'lcp', 'contact' or 'scene'"},
      {replaced(kLcp, R"("q": )", R"("M": [], "q": )"), "M: given twice"},
      {replaced(kLcp, R"("q": )", R"("v": [1, 2], "q": )"), "unknown field 'v' of kind 'lcp'"},
  });
}

TEST(ProblemErrorsTest, Types) {
  expect_errors({
      {"[1, 2]", "expected an object, found a list"},
      {"1e999", "'1e999' is beyond the range of double"},
      {replaced(kLcp, "[-5, -6]", "7"), "q: expected a list of numbers, found a number"},
      {replaced(kLcp, "[-5, -6]", "[-5, null]"), "q[1]: expected a finite number, found null"},
      {replaced(kLcp, "[1, 2]]", "[1, [2]]]"), "M[1][1]: expected a finite number, found a list"},
      {replaced(kContact, R"("G": [[2, 0.5], [0.5, 1]])", R"("G_factors": [1])"),
       "G_factors: expected an object, found a list"},
      {replaced(kScene, R"("contacts": [{)", R"("contacts": [3, {)"),
       "contacts[0]: expected an object, found a number"},
      {replaced(kScene, R"("mass": 2)", R"("mass": [2])"), "bodies[0].mass: expected a number, found a list"},
      {replaced(kScene, "[0, 0, 1], \"lin", "[0, 0, {}], \"lin"),
       "bodies[0].position[2]: expected a finite number, found an object"},
  });
}

TEST(ProblemErrorsTest, Numbers) {
  expect_errors({
      {replaced(kLcp, "-6", "1e999"), "q[1]: '1e999' is beyond the range of double"},
      {replaced(kLcp, "-6", "NaN"), "line 1, column 109: not valid JSON: unexpected 'N' (in q[1])"},
      {replaced(kLcp, "-6", std::string(5000, '1')),
       "q[1]: '" + std::string(60, '1') + "...' is beyond the range of double"},
      {replaced(kContact, "[0, 4]", "[0, 4.5]"), "edges[1] is 4.5, expected an integer"},
      {replaced(kContact, "[0, 4]", "[0, 1e300]"), "edges[1] is 1e+300, expected an integer"},
      {replaced(kScene, R"("body_a": 0)", R"("body_a": 0.5)"), "contacts[0].body_a is 0.5, expected an integer"},
  });
}

TEST(ProblemErrorsTest, Shapes) {
  expect_errors({
      {replaced(kLcp, R"( "M": [[2, 1], [1, 2]],)", ""), "M: missing"},
      {replaced(kLcp, "[2, 1], [1, 2]", "[2, 1]"), "M: 1 row, expected 2"},
      {replaced(kLcp, "[-5, -6]", "[-5]"), "M: 2 rows, expected 1"},
      {replaced(kContact, "[0.5, 1]], \"D\"", "[0.5]], \"D\""), "N: row 1 has 1 entry, expected 2"},
      {replaced(kContact, R"( "D": [[1, 0, -1, 0], [0.25, 1, -0.25, -1]],)", R"( "D": [[1, 0, -1, 0]],)"),
       "D: 1 row, expected 2"},
      {replaced(kContact, "[0, 4]", "[0, 6]"), "D: row 0 has 4 entries, expected 6"},
      {replaced(kContact, R"("edges")", R"("b": [1], "edges")"), "b: 1 entry, expected 2"},
      {replaced(kScene, R"("edges": 4)", R"("edges": 4, "b": [1])"), "contacts[0].b: expected a number, found a list"},
      {replaced(kContact, R"( "edges": [0, 4],)", ""), "edges: missing; it belongs to D"},
      {replaced(kContact, R"(, "G": [[2, 0.5], [0.5, 1]])", ""), "G: missing (or G_blocks, G_factors or Ginv)"},
      {replaced(kScene, "[0, 0, 1], \"lin", "[0, 1], \"lin"), "bodies[0].position: 2 entries, expected 3"},
      {replaced(kScene, ", [0, 0, 1]], \"pos", "], \"pos"), "bodies[0].inertia: 2 rows, expected 3"},
  });
}

TEST(ProblemErrorsTest, Bounds) {
  const auto with = [](const std::string& fields) {
    return replaced(kLcp, R"("q": [-5, -6])", R"("q": [-5, -6], )" + fields);
  };
  EXPECT_EQ(error_of(with(R"("lower": [null, -1], "upper": [0, null])")), "no error");
  EXPECT_EQ(error_of(with(R"("friction_of": [null, 0], "mu": [null, 0.5])")), "no error");
  expect_errors({
      {with(R"("lower": [0])"), "lower: 1 entry, expected 2"},
      {with(R"("lower": ["0", 0])"), "lower[0]: expected a finite number or null, found a text"},
      {with(R"("lower": [0, 2], "upper": [1, 1])"), "lower[1] is 2, expected at most upper, 1"},
      {with(R"("upper": [-1, 1])"), "lower[0] is 0, expected at most upper, -1"},
      {with(R"("mu": [0, 0.5])"), "friction_of: missing; it belongs to mu"},
      {with(R"("friction_of": [null, 0])"), "mu: missing"},
      {with(R"("friction_of": [null, 0], "mu": [0, -0.5])"), "mu[1] is -0.5, expected >= 0"},
      {with(R"("friction_of": [null, 1], "mu": [0, 1])"), "friction_of[1] is 1, expected the index of another row"},
      {with(R"("friction_of": [null, 2], "mu": [0, 1])"), "friction_of[1] is 2, expected the index of another row"},
      {with(R"("friction_of": [null, -2], "mu": [0, 1])"),
       "friction_of[1] is -2, expected the index of another row, or null"},
      {with(R"("friction_of": [null, 0.5], "mu": [0, 1])"), "friction_of[1] is 0.5, expected an integer"},
      {with(R"("friction_of": [1, 0], "mu": [1, 1])"), "friction_of[0]: row 1 needs a lower bound >= 0 of its own"},
      {with(R"("friction_of": [null, 0], "mu": [0, 1], "lower": [null, null])"),
       "friction_of[1]: row 0 needs a lower bound >= 0 of its own"},
      {with(R"("friction_of": [null, 0], "mu": [0, 1], "upper": [null, 3])"),
       "upper[1]: given, but friction_of bounds this row"},
  });
}

TEST(ProblemErrorsTest, BoundedRows) {
  const auto with = [](const std::string& from, const std::string& to) { return replaced(kRows, from, to); };
  const std::string lower = R"("lower": [null, 0, null])", upper = R"("upper": [null, null, null])";
  const std::string friction_of = R"("friction_of": [null, null, 1])";
  EXPECT_EQ(error_of(with(lower, R"("lower": [-1e20, -0, null])")), "no error");
  expect_errors({
      {with(R"("rows": {)", R"("rows": [{}], "r": {)"), "unknown field 'r' of kind 'contact'"},
      {with(R"("rows": {)", R"("rows": {"N": [], )"), "rows: unknown field 'N'"},
      {with(R"("R": [[1, 0, 1], [0, 1, 1]], )", ""), "rows.R: missing"},
      {with(lower + ",", ""), "rows.lower: missing"},
      {with(upper + ",", ""), "rows.upper: missing"},
      {with("[0, 1, 1]", "[0, 1]"), "rows.R: row 1 has 2 entries, expected 3"},
      {with(", [0, 1, 1]]", "]"), "rows.R: 1 row, expected 2"},
      {with("[[1, 0, 1], [0, 1, 1]]", R"({"starts": [0, 1, 2, 3], "rows": [0, 2, 1], "values": [1, 1, 1]})"),
       "rows.R.rows[1] is 2, expected 0 to 1"},
      {with(lower, R"("lower": [null, 0])"), "rows.lower: 2 entries, expected 3"},
      {with(lower, R"("lower": [null, 0.5, null])"), "rows.lower[1] (stop) is 0.5, expected at most 0"},
      {with(upper, R"("upper": [-2, null, null])"), "rows.upper[0] (hinge) is -2, expected at least 0"},
      {with(upper, R"("upper": [null, 0, null])"),
       "rows.lower[1] (stop) and the upper bound are 0: the row has no effect, leave it out"},
      {with(upper, R"("upper": [null, null, 3])"), "rows.upper[2]: given, but friction_of bounds this row"},
      {with(lower, R"("lower": [null, 0, -1])"), "rows.lower[2]: given, but friction_of bounds this row"},
      {with(lower, R"("lower": [null, -1, null])"),
       "rows.friction_of[2]: row 1 needs a lower bound >= 0 of its own"},
      {with(friction_of, R"("friction_of": [null, null, 3])"),
       "rows.friction_of[2] is 3, expected the index of another row"},
      {with(friction_of, R"("friction_of": [null, null, 2])"),
       "rows.friction_of[2] is 2, expected the index of another row"},
      {with(friction_of, R"("friction_of": [2, null, 1])"),
       "rows.friction_of[0]: row 2 needs a lower bound >= 0 of its own"},
      {with(friction_of + ", ", ""), "rows.friction_of: missing; it belongs to mu"},
      {with(R"("mu": [null, null, 0.25], )", ""), "rows.mu: missing"},
      {with("0.25]", "-0.25]"), "rows.mu[2] is -0.25, expected >= 0"},
      {with("[0, 1, 0]", "[0, 1]"), "rows.b: 2 entries, expected 3"},
      {with("[0.5, 0, 0]", "[0.5]"), "rows.compliance: 1 entry, expected 3"},
      {with("[0.5, 0, 0]", "[0.5, -1, 0]"), "rows.compliance[1] is -1, expected a number >= 0"},
      {with(R"("rad")", R"("deg")"), "rows.unit[1]: 'deg', expected 'm' or 'rad'"},
      {with(R"("unit": ["m", )", R"("unit": [)"), "rows.unit: 2 entries, expected 3"},
      {with(R"("stop", "")", R"("stop")"), "rows.names: 2 entries, expected 3"},
      {with("stop", std::string(1001, 'x')), "rows.names[1]: 1001 bytes long, at most 1000 are allowed"},
      {with("stop", "st\\u0007op"), "rows.names[1]: has a control character"},
      {with(R"("kind": "contact")", R"("kind": "lcp")"), "unknown field 'v' of kind 'lcp'"},
  });
}

TEST(ProblemErrorsTest, Friction) {
  expect_errors({
      {replaced(kContact, "[0, 4]", "[0, 3]"), "edges[1] is 3, expected an even number >= 0"},
      {replaced(kContact, "[0, 0.5]", "[0, -0.5]"), "mu[1] is -0.5, expected >= 0"},
      {replaced(kContact, "[0, 0.5]", "[0.25, 0.5]"),
       "mu[0] is 0.25 but the contact has no edges: its friction would be ignored"},
      {replaced(kContact, "-0.25, -1]", "-0.25, -0.5]"),
       "D: contact 1: column 3 is not the negative of column 1 (row 1)"},
      {replaced(kScene, R"("edges": 4)", R"("edges": 6)"), "contacts[0].edges is 6, expected 0 or 4"},
      {replaced(kScene, R"("edges": 4)", R"("edges": 0)"), "contacts[0].tangent: given, but the contact has no edges"},
      {replaced(kScene, R"("tangent": [1, 0, 0], "mu": 0.5, "edges": 4)", R"("mu": 0.5)"),
       "contacts[0].mu is 0.5 but the contact has no edges: its friction would be ignored"},
      // Nothing but this limit bounds the columns of a D without rows.
      {R"({"format": "lcpbench-problem", "version": 1, "name": "box", "kind": "contact", "v": [], "N": [], "D": [],
           "edges": [2147483646], "mu": [0.5], "G": []})",
       "edges: more than 67108864 friction directions"},
  });
}

TEST(ProblemErrorsTest, Inertia) {
  const std::string G = R"("G": [[2, 0.5], [0.5, 1]])";
  expect_errors({
      {replaced(kContact, "[0.5, 1]]}", "[0.25, 1]]}"), "G: not symmetric: entry (1, 0) is 0.25, entry (0, 1) is 0.5"},
      {replaced(kContact, G, R"("G": [[1, 2], [2, 1]])"), "G: not positive definite (Cholesky factorization fails)"},
      {replaced(kContact, G, R"("G": [[0, 0], [0, 1]])"), "G: not positive definite (Cholesky factorization fails)"},
      {replaced(kContact, G, R"("G": [[1e308, 1e308], [1e308, 1e-308]])"),
       "G: not positive definite (Cholesky factorization fails)"},
      {replaced(kContact, G, G + R"(, "G_factors": {"X": [[1], [2]], "alpha": [1]})"),
       "G and G_factors: only one may be given"},
      {replaced(kContact, G, G + R"(, "Ginv": [[1, 0], [0, 1]])"),
       "Ginv: given beside G; it may only replace it"},
      {replaced(kContact, G, R"("G_factors": {"X": [[1], [2]], "alpha": [0]})"),
       "G_factors.alpha[0] is 0, expected > 0"},
      {replaced(kContact, G, R"("G_factors": {"X": [[1], [2]], "alpha": [1, 2]})"),
       "G_factors.X: row 0 has 1 entry, expected 2"},
      {replaced(kContact, G, R"("Ginv": [[1, 1], [0, 1]])"),
       "Ginv: not symmetric: entry (1, 0) is 0, entry (0, 1) is 1"},
      {replaced(kContact, G, R"("Ginv": [[1, 2], [2, 1]])"), "Ginv: not positive semidefinite"},
      {replaced(kContact, G, R"("Ginv": [[1, 1.00000002], [1.00000002, 1]])"),
       "Ginv: not positive semidefinite: its least eigenvalue is -2e-08, its largest 2; if its entries are rounded to "
       "few digits, add 2.2e-08 to each on its diagonal"},
      {replaced(kScene, "[[1, 0, 0]", "[[1, 0, 0.5]"),
       "bodies[0].inertia: not symmetric: entry (2, 0) is 0, entry (0, 2) is 0.5"},
  });
}

TEST(ProblemErrorsTest, RigidContacts) {
  expect_errors({
      {replaced(kScene, R"("body_a": 0)", R"("body_a": 1)"),
       "contacts[0].body_a is 1, expected one of the 1 bodies, counted from 0"},
      {replaced(kScene, R"("body_a": 0, "body_b": -1)", R"("body_a": -1, "body_b": 0)"),
       "contacts[0].body_a is -1, the world, which has to be body_b: swap the bodies and turn the normal"},
      {replaced(kScene, R"("body_b": -1)", R"("body_b": -2)"),
       "contacts[0].body_b is -2, expected -1 (world) or one of the 1 bodies, counted from 0"},
      {replaced(kScene, R"("body_b": -1)", R"("body_b": 0)"),
       "contacts[0].body_b is body_a: a contact needs two bodies"},
      {replaced(kScene, R"("normal": [0, 0, 1])", R"("normal": [0, 0, 2])"),
       "contacts[0].normal has length 2, expected 1"},
      {replaced(kScene, R"("tangent": [1, 0, 0])", R"("tangent": [0.6, 0, 0.8])"),
       "contacts[0].tangent is not orthogonal to the normal: their scalar product is 0.8"},
      {replaced(kScene, R"("point": [0, 0, 0])", R"("point": [1.7e308, 0, 0])"),
       "contacts[0].point: the distance to body 0 overflows"},
  });
}

TEST(ProblemErrorsTest, BrokenText) {
  expect_errors({
      {"", "empty file"},
      {"   \n ", "truncated: the file ends at line 2, column 2"},
      {"{\n  \"format\" \"x\"}", "line 2, column 14: not valid JSON: unexpected '\"' (in format)"},
      {kLcp + "x", "line 1, column " + std::to_string(kLcp.size() + 1) + ": not valid JSON: unexpected 'x'"},
      {replaced(kLcp, "-5, -6", "-5,, -6"), "line 1, column 108: not valid JSON: unexpected ',' (in q[1])"},
      {replaced(kLcp, "two", "tw\xff"), "line 1, column 57: not valid JSON, or not UTF-8 (in name)"},
      {std::string("\xff\xfe{", 3), "line 1, column 1: not valid JSON, or not UTF-8"},
      {std::string("{\0\"\0", 4), "line 1, column 2: a NUL byte: not a text file"},
      {kLcp.substr(0, 104), "truncated: the file ends at line 1, column 105 (in q[0])"},
  });
}

TEST(ProblemErrorsTest, EveryTruncationIsToldAsSuch) {
  for (const std::string& whole : {kLcp, kContact, kRows, kScene}) {
    for (std::size_t length = 1; length < whole.size(); ++length) {
      const std::string error = error_of(whole.substr(0, length));
      EXPECT_TRUE(error.starts_with("box.json: truncated: the file ends at "))
          << error << "\nafter " << length << " bytes";
    }
  }
}

TEST(ProblemErrorsTest, DeepNestingIsRefusedAtTheFirstLevelTooMany) {
  const std::string lists(1'000'000, '[');
  std::string objects;
  for (int i = 0; i < 100'000; ++i) objects += R"({"G_factors":)";
  for (const std::string& text : {lists, R"({"M": )" + lists, objects}) {
    EXPECT_EQ(error_of(text), "box.json: more than 10 levels of lists and objects");
  }
  EXPECT_EQ(error_of(replaced(kLcp, "[-5, -6]", "[-5, [[[6]]]]")),
            "box.json: q[1]: expected a finite number, found a list");
}

TEST(ProblemErrorsTest, AnObjectOfVeryManyFieldsIsRefused) {
  std::string text = "{";
  for (int i = 0; i < 1000; ++i) text += "\"f" + std::to_string(i) + "\": 0, ";
  EXPECT_EQ(error_of(text), "box.json: f100: more than 100 fields in an object");
}

TEST(ProblemErrorsTest, MoreNumbersThanTheLimitAreRefusedWhileReading) {
  std::string text = R"({"q": [)";
  text.reserve(text.size() + 2 * kMaxNumbers + 4);
  for (std::size_t i = 0; i <= kMaxNumbers; ++i) text += "0,";
  EXPECT_EQ(error_of(text), "box.json: q[67108864]: more than 67108864 numbers in the file");
}

TEST(ProblemErrorsTest, TheMessageIsOneLineWhateverTheFileIsCalled) {
  try {
    parse_problem_json("[]", "two\nlines");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "two?lines: expected an object, found a list");
  }
}

}  // namespace
}  // namespace lcpbench::problem_errors_test
