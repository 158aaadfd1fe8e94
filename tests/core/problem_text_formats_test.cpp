// Siconos LCP text and Matrix Market pairs: what a user of those libraries relies on when handing us their files.

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/problem_io.h"

namespace lcpbench::problem_text_formats_test {
namespace {

namespace fs = std::filesystem;

// Murty's second example of exponential pivoting, order 2, is lower triangular; the text holds its columns line by
// line.
const std::string kSiconos = "2\n0\n2\n2\n2\t2\n1 2\n0 1\n-1 -2.5e0\n\n# a comment, 7 8 9\n";

const std::string kM = "%%MatrixMarket matrix array real general\n% columns\n\n2 2\n1\n2\n0\n1\n";
const std::string kQ = "%%MatrixMarket matrix array real general\n2 1\n-1\n-2.5\n";

template <class Parse>
std::string error_of(const Parse& parse) {
  try {
    parse();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string siconos_error(const std::string& text) {
  return error_of([&] { parse_siconos_lcp(text, "a.dat"); });
}

std::string market_error(const std::string& M, const std::string& q = kQ) {
  return error_of([&] { parse_matrix_market(M, q, "a.M.mtx"); });
}

void expect_murty(const Problem& problem) {
  EXPECT_EQ(problem.lcp().M, (Matrix{{1, 0}, {2, 1}}));
  EXPECT_EQ(problem.lcp().q, (Vector{{-1, -2.5}}));
}

TEST(SiconosTextTest, TheMatrixIsColumnMajor) {
  const Problem problem = parse_siconos_lcp(kSiconos, "data/murty.dat");
  expect_murty(problem);
  EXPECT_EQ(problem.name(), "murty");
}

TEST(SiconosTextTest, ARelayProblemIsNoLcp) {
  const std::string lcp = "2\n0\n2\n2\n2 2\n1 2\n0 1\n-1 -2.5\n";
  EXPECT_EQ(siconos_error(lcp + "-1 -1\n1 1\n").rfind("a.dat: q: lower and upper bounds follow it: a relay problem, ", 0),
            0U)
      << siconos_error(lcp + "-1 -1\n1 1\n");
  for (const char* comment : {"", "-1 -1 1\n", "-1 -1 1 1 1\n", "1 1 -1 -1\n", "made in 2 2 2\n"}) {
    EXPECT_EQ(siconos_error(lcp + comment), "no error") << comment;
  }
}

// One equation, one complementarity row: M = [1 2; 3 4], q = (5, 6).
const std::string kBlocks = "0 1 2\n0 1\n0\n2\n2\n2\t2\n1 3\n2 4\n5 6\n";
const std::string kParts = "1\n4\n2\n3\n5\n6\n";

void expect_mlcp(const Problem& problem) {
  EXPECT_EQ(problem.lcp().M, (Matrix{{1, 2}, {3, 4}}));
  EXPECT_EQ(problem.lcp().q, (Vector{{5, 6}}));
  ASSERT_TRUE(problem.lcp().is_mixed());
  EXPECT_TRUE(problem.lcp().bounds.is_free(0));
  EXPECT_EQ(problem.lcp().bounds.lower(1), 0);
}

TEST(SiconosTextTest, AMixedLcpIsReadFromItsMatrixOrItsParts) {
  expect_mlcp(parse_siconos_lcp("1\n1\n1\n1\n" + kBlocks + kParts, "a.dat"));
  expect_mlcp(parse_siconos_lcp("1\n0\n1\n1\n" + kBlocks, "a.dat"));
  expect_mlcp(parse_siconos_lcp("0\n1\n1\n1\n" + kParts, "a.dat"));
  EXPECT_EQ(parse_siconos_lcp("1 0 1 1 1 1 7 8", "a.dat").lcp().M(0, 0), 7);  // an LCP of one row
  // Blocks need not begin with the equations; without any this is no mixed LCP.
  const Lcp turned = parse_siconos_lcp("1 0 1 1 0 1 2 1 0 0 2 2 2 2 1 3 2 4 5 6", "a.dat").lcp();
  EXPECT_TRUE(turned.bounds.is_free(1) && !turned.bounds.is_free(0));
  EXPECT_FALSE(parse_siconos_lcp("1 0 0 2 0 2 1 0 2 2 2 2 1 3 2 4 5 6", "a.dat").lcp().is_mixed());
  EXPECT_EQ(siconos_error("1 0 1 1 0 1 2 0 1 0 3 2 3 2"),
            "a.dat: rows of M: 3, expected 2 as in the first line (line 1, column 21)");  // rectangular
  EXPECT_EQ(siconos_error("1 0 1 1 0 1 1 0 1"),
            "a.dat: first row of a block: the rows do not ascend (line 1, column 13)");
  EXPECT_EQ(siconos_error("0 1 4000 4192 1"),
            "a.dat: m: expected an integer from 0 to 4191, found '4192' (line 1, column 10)");
  EXPECT_EQ(siconos_error("0 1 4000 4191 1"),
            "a.dat: M: truncated: 67100672 numbers of M and q cannot fit the rest of the file (line 1, column 10)");
  EXPECT_EQ(siconos_error("0 1 1 1 1 2 3 x 5 6"), "a.dat: D: expected a finite number, found 'x' (line 1, column 15)");
}

TEST(SiconosTextTest, Errors) {
  EXPECT_EQ(siconos_error("2\n1\n2 2"),
            "a.dat: storage: 1 (sparse blocks) is not read; only 0 (dense) is (line 2, column 1)");
  EXPECT_EQ(siconos_error("2\n2\n2 2"),
            "a.dat: storage: 2 (compressed sparse columns) is not read; only 0 (dense) is (line 2, column 1)");
  EXPECT_EQ(siconos_error("2 7"), "a.dat: storage: unknown kind; only 0 (dense) is read (line 1, column 3)");
  EXPECT_EQ(siconos_error("2 0 2 3"), "a.dat: columns of M: 3, expected 2 as in the first line (line 1, column 7)");
  EXPECT_EQ(siconos_error("-2"), "a.dat: n: expected an integer from 0 to 8191, found '-2' (line 1, column 1)");
  EXPECT_EQ(siconos_error("100000 0"),
            "a.dat: n: expected an integer from 0 to 8191, found '100000' (line 1, column 1)");
  EXPECT_EQ(siconos_error("2 0 2 2 2 2 1 x 0 1 -1 -1"),
            "a.dat: M: expected a finite number, found 'x' (line 1, column 15)");
  EXPECT_EQ(siconos_error("2 0 2 2 2 2 1 2 0 nan -1 -1"),
            "a.dat: M: expected a finite number, found 'nan' (line 1, column 19)");
  EXPECT_EQ(siconos_error("2 0 2 2 2 2 1 2 0 1 -1 1e999"),
            "a.dat: q: expected a finite number, found '1e999' (line 1, column 24)");
  EXPECT_EQ(siconos_error("2 0 2 2 2 2 1 2 0 1 -1111"), "a.dat: q: truncated: the file ends here (line 1, column 26)");
  EXPECT_EQ(siconos_error("2 0 2 2"), "a.dat: rows of M, repeated: truncated: the file ends here (line 1, column 8)");
  // Half a gigabyte must not be asked for because of thirty bytes.
  EXPECT_EQ(siconos_error("8191 0 8191 8191 8191 8191 1"),
            "a.dat: M: truncated: 67100672 numbers of M and q cannot fit the rest of the file (line 1, column 23)");
}

TEST(MatrixMarketTest, ArrayIsColumnMajor) {
  const Problem problem = parse_matrix_market(kM, kQ, "data/murty.M.mtx");
  expect_murty(problem);
  EXPECT_EQ(problem.name(), "murty");
}

TEST(MatrixMarketTest, CoordinatesCountFromOne) {
  expect_murty(parse_matrix_market("%%matrixmarket MATRIX Coordinate Real General\n2 2 3\n1 1 1\n2 2 1\n2 1 2\n",
                                   "%%MatrixMarket matrix coordinate real general\r\n2 1 2\r\n2 1 -2.5\r\n1 1 -1\r\n",
                                   "a.M.mtx"));
}

TEST(MatrixMarketTest, StoredTrianglesAreCompleted) {
  const Matrix symmetric{{1, 2}, {2, 3}};
  const Matrix skew{{0, -2}, {2, 0}};
  const auto M = [](const std::string& text) { return parse_matrix_market(text, kQ, "a.M.mtx").lcp().M; };
  EXPECT_EQ(M("%%MatrixMarket matrix array integer symmetric\n2 2\n1\n2\n3\n"), symmetric);
  EXPECT_EQ(M("%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 1\n2 1 2\n2 2 3\n"), symmetric);
  EXPECT_EQ(M("%%MatrixMarket matrix array real skew-symmetric\n2 2\n2\n"), skew);
  EXPECT_EQ(M("%%MatrixMarket matrix coordinate integer skew-symmetric\n2 2 1\n2 1 2\n"), skew);
}

TEST(MatrixMarketTest, Errors) {
  const std::string general = "%%MatrixMarket matrix array real general\n";
  const std::string coordinate = "%%MatrixMarket matrix coordinate real ";
  EXPECT_EQ(market_error(""), "a.M.mtx: header: expected '%%MatrixMarket' (line 1, column 1)");
  EXPECT_EQ(market_error("%%MatrixMarket vector array real general\n"),
            "a.M.mtx: header: 'vector' is not read; expected matrix (line 1, column 1)");
  EXPECT_EQ(market_error("%%MatrixMarket matrix array complex general\n"),
            "a.M.mtx: header: 'complex' is not read; expected one of: real, integer (line 1, column 1)");
  EXPECT_EQ(market_error("%%MatrixMarket matrix array real hermitian\n"),
            "a.M.mtx: header: 'hermitian' is not read; expected one of: general, symmetric, skew-symmetric (line 1, "
            "column 1)");
  EXPECT_EQ(market_error(general), "a.M.mtx: rows: truncated: the file ends here (line 2, column 1)");
  EXPECT_EQ(market_error(general + "2 2\n1\n2\n"),
            "a.M.mtx: entries: truncated: 4 entries cannot fit the rest of the file (line 2, column 3)");
  EXPECT_EQ(market_error(general + "2 2\n1\n2\n0\n1\n9\n"),
            "a.M.mtx: end: expected no more entries, found '9' (line 7, column 1)");
  EXPECT_EQ(market_error(general + "2 2\n1\nnan\n0\n1\n"),
            "a.M.mtx: entry: expected a finite number, found 'nan' (line 4, column 1)");
  EXPECT_EQ(market_error(general + "2 1\n1\n2\n"), "a.M.mtx: M: 2 x 1, expected a square matrix");
  EXPECT_EQ(market_error(general + "1 1\n1\n"), "a.q.mtx: q: 2 x 1, expected 1 x 1");
  EXPECT_EQ(market_error("%%MatrixMarket matrix array integer general\n1 1\n1.5\n"),
            "a.M.mtx: entry: expected an integer (line 3, column 1)");
  EXPECT_EQ(market_error("%%MatrixMarket matrix array real symmetric\n2 1\n1\n"),
            "a.M.mtx: columns: a symmetric or skew-symmetric matrix must be square, found 2 x 1 (line 2, column 3)");
  EXPECT_EQ(market_error(coordinate + "general\n2 2 1\n0 1 5\n"),
            "a.M.mtx: row of an entry: 0, but Matrix Market counts from 1 (line 3, column 1)");
  EXPECT_EQ(market_error(coordinate + "general\n2 2 1\n3 1 5\n"),
            "a.M.mtx: row of an entry: expected an integer from 0 to 2, found '3' (line 3, column 1)");
  EXPECT_EQ(market_error(coordinate + "general\n2 2 2\n1 1 5\n1 1 6\n"),
            "a.M.mtx: entry: (1, 1) given twice (line 4, column 3)");
  EXPECT_EQ(market_error(coordinate + "symmetric\n2 2 1\n1 2 5\n"),
            "a.M.mtx: entry: outside the stored triangle of a symmetric or skew-symmetric matrix (line 3, column 3)");
  EXPECT_EQ(market_error(coordinate + "skew-symmetric\n2 2 1\n1 1 5\n"),
            "a.M.mtx: entry: outside the stored triangle of a symmetric or skew-symmetric matrix (line 3, column 3)");
  EXPECT_EQ(market_error(coordinate + "general\n8191 8191 67092481\n1 1 5\n"),
            "a.M.mtx: entries: truncated: 67092481 entries cannot fit the rest of the file (line 2, column 11)");
}

TEST(MatrixMarketTest, EitherFileNamesThePair) {
  const fs::path folder = fs::path(::testing::TempDir()) / ("matrix_market_test-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "murty.M.mtx") << kM;
  const auto missing = error_of([&] { read_problem(folder / "murty.M.mtx"); });
  EXPECT_EQ(missing, (folder / "murty.q.mtx").string() + ": no such file");
  std::ofstream(folder / "murty.q.mtx") << kQ;
  expect_murty(read_problem(folder / "murty.M.mtx"));
  expect_murty(read_problem(folder / "murty.q.mtx"));
  std::ofstream(folder / "murty.dat") << kSiconos;
  expect_murty(read_problem(folder / "murty.dat"));
  const auto unpaired = error_of([&] { read_problem(folder / "murty.mtx"); });
  EXPECT_EQ(unpaired, (folder / "murty.mtx").string() +
                          ": a Matrix Market problem is a pair of files, NAME.M.mtx and NAME.q.mtx");
  fs::remove_all(folder);
}

TEST(TextNumbersTest, AreCorrectlyRoundedAtTheEndsOfTheRange) {
  const auto q = [](const std::string& number) {
    return parse_siconos_lcp("1 0 1 1 1 1 1 " + number, "a.dat").lcp().q(0);
  };
  EXPECT_EQ(q("+1.5"), 1.5);
  EXPECT_EQ(q(".5"), 0.5);
  EXPECT_EQ(q("4.9406564584124654e-324"), 5e-324);
  EXPECT_EQ(q("1e-400"), 0.0);
  EXPECT_TRUE(std::signbit(q("-1e-400")));
  EXPECT_EQ(q("0." + std::string(400, '0') + "1"), 0.0);
  EXPECT_EQ(q("123456789e-340"), 0.0);
  EXPECT_EQ(q("0." + std::string(400, '0') + "1e401"), 1.0);
  const auto refused = [](const std::string& number) { return siconos_error("1 0 1 1 1 1 1 " + number) != "no error"; };
  for (const char* number :
       {"1e309", "1e400", "-1e999999999999999999999", "12e9223372036854775807", "+-1", "--1", "0x10", "1d3", "1,5",
        "inf", "1e", "1..2"}) {
    EXPECT_TRUE(refused(number)) << number;
  }
  EXPECT_TRUE(refused(std::string(400, '9')));
  EXPECT_TRUE(refused(std::string(700, '9') + "e-300"));
  EXPECT_EQ(q("1e-99999999999999999999"), 0.0);
}

}  // namespace
}  // namespace lcpbench::problem_text_formats_test
