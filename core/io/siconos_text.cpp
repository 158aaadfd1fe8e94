#include <limits>
#include <optional>
#include <vector>

#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/text_tokens.h"

// Siconos' dense text: words separated by white space. An LCP is
//
//   n, storage (0 = dense), rows, cols, and for dense storage rows and cols again;
//   M, rows * cols numbers in column-major order; q, n numbers; whatever follows is a comment, unless it is 2 n numbers:
//   the bounds of a relay problem.
//
// A mixed LCP has n equations and m rows with z >= 0:
//
//   1 if M and q follow, 1 if A, B, C, D, a, b follow, n, m;
//   of M and q the first row of each block, ending with n + m; for each block 1 if its rows have z >= 0, else 0; and
//   then what an LCP has after its n; A (n x n), B (m x m), C (n x m), D (m x n) row by row, a, b, with M = [A C; D B]
//   and q = [a; b].

namespace lcpbench {
namespace {

void check_dense_storage(TextTokens& tokens) {
  switch (tokens.count("storage", 9)) {
    case 0: return;
    case 1: tokens.fail("storage", "1 (sparse blocks) is not read; only 0 (dense) is");
    case 2: tokens.fail("storage", "2 (compressed sparse columns) is not read; only 0 (dense) is");
    default: tokens.fail("storage", "unknown kind; only 0 (dense) is read");
  }
}

void read_order(TextTokens& tokens, std::string_view field, std::int64_t n) {
  const std::int64_t value = tokens.count(field, kMaxDenseOrder);
  if (value != n)
    tokens.fail(field, std::to_string(value) + ", expected " + std::to_string(n) + " as in the first line");
}

void expect(const TextTokens& tokens, std::int64_t n) {
  const auto needed = static_cast<std::size_t>(n * n + n);
  if (needed <= tokens.numbers_left()) return;
  tokens.fail("M", "truncated: " + std::to_string(needed) + " numbers of M and q cannot fit the rest of the file");
}

/// What follows the order n.
Lcp read_matrix(TextTokens& tokens, std::int64_t n) {
  check_dense_storage(tokens);
  for (const char* field : {"rows of M", "columns of M", "rows of M, repeated", "columns of M, repeated"}) {
    read_order(tokens, field, n);
  }
  expect(tokens, n);
  Lcp lcp;
  lcp.M.resize(n, n);
  lcp.q.resize(n);
  for (Index column = 0; column < n; ++column) {
    for (Index row = 0; row < n; ++row) lcp.M(row, column) = tokens.real("M");
  }
  for (Index i = 0; i < n; ++i) lcp.q(i) = tokens.real("q");
  return lcp;
}

void set_free(Lcp& lcp, Index begin, Index count) {
  lcp.bounds.lower.segment(begin, count).setConstant(-std::numeric_limits<double>::infinity());
}

Lcp read_blocks(TextTokens& tokens, std::int64_t n) {
  std::vector<Index> begins{tokens.count("first row of block 0", 0)};
  while (begins.back() < n) {
    begins.push_back(tokens.count("first row of a block", n));
    if (begins.back() <= begins[begins.size() - 2]) tokens.fail("first row of a block", "the rows do not ascend");
  }
  std::vector<bool> is_free;
  for (std::size_t block = 0; block + 1 < begins.size(); ++block)
    is_free.push_back(tokens.count("kind of a block", 1) == 0);
  Lcp lcp = read_matrix(tokens, n);
  lcp.bounds = LcpBounds::nonnegative(n);
  for (std::size_t block = 0; block < is_free.size(); ++block) {
    if (is_free[block]) set_free(lcp, begins[block], begins[block + 1] - begins[block]);
  }
  return lcp;
}

Lcp read_parts(TextTokens& tokens, std::int64_t equations, std::int64_t others) {
  const std::int64_t n = equations + others;
  expect(tokens, n);
  Lcp lcp{Matrix(n, n), Vector(n), LcpBounds::nonnegative(n)};
  struct Part {
    const char* name;
    Index row, column, rows, columns;
  };
  for (const Part& part : {Part{"A", 0, 0, equations, equations}, Part{"B", equations, equations, others, others},
                           Part{"C", 0, equations, equations, others}, Part{"D", equations, 0, others, equations}}) {
    for (Index i = 0; i < part.rows; ++i) {
      for (Index j = 0; j < part.columns; ++j) lcp.M(part.row + i, part.column + j) = tokens.real(part.name);
    }
  }
  for (Index i = 0; i < n; ++i) lcp.q(i) = tokens.real(i < equations ? "a" : "b");
  set_free(lcp, 0, equations);
  return lcp;
}

/// Whether a text begins as that of a mixed LCP. "1 0 n m" is also an LCP of one row, whose fifth number is 1.
bool is_mixed(std::string_view text, const std::string& origin) {
  TextTokens tokens(text, origin);
  const std::string_view first = tokens.next();
  const std::string_view second = tokens.next();
  if ((first == "1" || first == "0") && second == "1") return true;
  if (first != "1" || second != "0") return false;
  tokens.next();
  tokens.next();
  return tokens.next() == "0";
}

Lcp read_mixed(TextTokens& tokens) {
  const bool has_matrix = tokens.count("whether M follows", 1) == 1;
  tokens.count("whether A, B, C, D follow", 1);
  const std::int64_t equations = tokens.count("n", kMaxDenseOrder);
  const std::int64_t others = tokens.count("m", kMaxDenseOrder - equations);
  Lcp lcp = has_matrix ? read_blocks(tokens, equations + others) : read_parts(tokens, equations, others);
  lcp.bounds.simplify();
  return lcp;
}

/// A relay problem has the lower and the upper bounds of its n rows after q, and no mark of its own.
void refuse_relay(TextTokens& tokens, std::int64_t n) {
  std::vector<double> bounds;
  for (std::string_view word = tokens.next(); !word.empty(); word = tokens.next()) {
    const std::optional<double> number = parse_decimal(word);
    if (!number || std::ssize(bounds) == 2 * n) return;
    bounds.push_back(*number);
  }
  if (n == 0 || std::ssize(bounds) != 2 * n) return;
  for (auto lower = bounds.begin(); lower != bounds.begin() + n; ++lower) {
    if (!(*lower <= *(lower + n))) return;
  }
  tokens.fail("q", "lower and upper bounds follow it: a relay problem, which is not read. Write it as a mixed LCP with "
                   "lower and upper (docs/reference/problem-file.md)");
}

Lcp read_lcp(TextTokens& tokens) {
  const std::int64_t n = tokens.count("n", kMaxDenseOrder);
  Lcp lcp = read_matrix(tokens, n);
  refuse_relay(tokens, n);
  return lcp;
}

}  // namespace

Problem parse_siconos_lcp(std::string_view text, const std::string& origin) {
  TextTokens tokens(text, origin);
  return Problem(problem_name_of_file(origin),
                 is_mixed(text, origin) ? read_mixed(tokens) : read_lcp(tokens));
}

}  // namespace lcpbench
