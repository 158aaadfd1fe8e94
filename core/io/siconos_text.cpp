#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/text_tokens.h"

// Siconos' dense LCP text: words separated by white space.
//
//   n, storage (0 = dense), rows, cols, and for dense storage rows and cols again;
//   M, rows * cols numbers in column-major order; q, n numbers; whatever follows is a comment.

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

}  // namespace

Problem parse_siconos_lcp(std::string_view text, const std::string& origin) {
  TextTokens tokens(text, origin);
  const std::int64_t n = tokens.count("n", kMaxDenseOrder);
  check_dense_storage(tokens);
  for (const char* field : {"rows of M", "columns of M", "rows of M, repeated", "columns of M, repeated"}) {
    read_order(tokens, field, n);
  }
  const auto needed = static_cast<std::size_t>(n * n + n);
  if (needed > tokens.numbers_left()) {
    tokens.fail("M", "truncated: " + std::to_string(needed) + " numbers of M and q cannot fit the rest of the file");
  }
  Lcp lcp;
  lcp.M.resize(n, n);
  lcp.q.resize(n);
  for (Index column = 0; column < n; ++column) {
    for (Index row = 0; row < n; ++row) lcp.M(row, column) = tokens.real("M");
  }
  for (Index i = 0; i < n; ++i) lcp.q(i) = tokens.real("q");
  return Problem(problem_name_of_file(origin), std::move(lcp));
}

}  // namespace lcpbench
