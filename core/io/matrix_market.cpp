#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/io/problem_checks.h"
#include "core/io/problem_io.h"
#include "core/io/text_tokens.h"

// Matrix Market exchange format [Boisvert, Pozo, Remington 1996, NISTIR 5935]: a header line, comment lines, a size
// line, entries. Dense arrays are column-major; coordinates count from 1; of a symmetric matrix only the lower triangle
// is stored, of a skew-symmetric one only what is strictly below the diagonal.

namespace lcpbench {
namespace {

enum class Symmetry { kGeneral, kSymmetric, kSkewSymmetric };  // in the order of the words in read_header()

struct Header {
  bool coordinate = false;
  bool integer = false;
  Symmetry symmetry = Symmetry::kGeneral;
};

std::string lower_case(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return result;
}

/// The position of `word` in `choices`. @throws InputError, which lists them, for any other word
std::size_t choose(TextTokens& tokens, const std::string& word, std::span<const std::string_view> choices) {
  const auto it = std::find(choices.begin(), choices.end(), word);
  if (it != choices.end()) return static_cast<std::size_t>(it - choices.begin());
  std::string known;
  for (const std::string_view choice : choices) known += (known.empty() ? "" : ", ") + std::string(choice);
  tokens.fail("header", in_quotes(word) + " is not read; expected one of: " + known);
}

Header read_header(TextTokens& tokens, const std::string& origin) {
  constexpr std::array<std::string_view, 2> kFormats{"array", "coordinate"};
  constexpr std::array<std::string_view, 2> kFields{"real", "integer"};
  constexpr std::array<std::string_view, 3> kSymmetries{"general", "symmetric", "skew-symmetric"};
  TextTokens words(tokens.line(), origin);
  if (lower_case(words.next()) != "%%matrixmarket") tokens.fail("header", "expected '%%MatrixMarket'");
  if (const std::string object = lower_case(words.next()); object != "matrix") {
    tokens.fail("header", in_quotes(object) + " is not read; expected matrix");
  }
  Header header;
  header.coordinate = choose(tokens, lower_case(words.next()), kFormats) == 1;
  header.integer = choose(tokens, lower_case(words.next()), kFields) == 1;
  header.symmetry = static_cast<Symmetry>(choose(tokens, lower_case(words.next()), kSymmetries));
  return header;
}

class MatrixReader {
 public:
  MatrixReader(std::string_view text, const std::string& origin) : tokens_(text, origin), origin_(origin) {}

  Matrix read() {
    header_ = read_header(tokens_, origin_);
    tokens_.skip_comments('%');
    const std::int64_t rows = tokens_.count("rows", kMaxDenseOrder);
    const std::int64_t cols = tokens_.count("columns", kMaxDenseOrder);
    if (header_.symmetry != Symmetry::kGeneral && rows != cols) {
      tokens_.fail("columns",
                   "a symmetric or skew-symmetric matrix must be square, found " + std::to_string(rows) + " x " +
                       std::to_string(cols));
    }
    const std::int64_t entries = header_.coordinate ? tokens_.count("entries", rows * cols) : array_entries(rows, cols);
    const std::size_t numbers = static_cast<std::size_t>(entries) * (header_.coordinate ? 3 : 1);
    if (numbers > tokens_.numbers_left()) {
      tokens_.fail("entries", "truncated: " + std::to_string(entries) + " entries cannot fit the rest of the file");
    }
    matrix_ = Matrix::Zero(rows, cols);
    if (header_.coordinate) {
      read_coordinates(entries);
    } else {
      read_array();
    }
    if (const std::string_view rest = tokens_.next(); !rest.empty()) {
      tokens_.fail("end", "expected no more entries, found " + in_quotes(rest));
    }
    return std::move(matrix_);
  }

 private:
  /// The first row of a column that the file holds.
  Index first_row(Index column) const {
    if (header_.symmetry == Symmetry::kGeneral) return 0;
    return header_.symmetry == Symmetry::kSymmetric ? column : column + 1;
  }

  std::int64_t array_entries(Index rows, Index cols) const {
    std::int64_t entries = 0;
    for (Index column = 0; column < cols; ++column) entries += rows - first_row(column);
    return entries;
  }

  double value() {
    const double number = tokens_.real("entry");
    if (header_.integer && number != std::floor(number)) tokens_.fail("entry", "expected an integer");
    return number;
  }

  void set(Index row, Index column, double number) {
    matrix_(row, column) = number;
    if (row == column || header_.symmetry == Symmetry::kGeneral) return;
    matrix_(column, row) = header_.symmetry == Symmetry::kSymmetric ? number : -number;
  }

  void read_array() {
    for (Index column = 0; column < matrix_.cols(); ++column) {
      for (Index row = first_row(column); row < matrix_.rows(); ++row) set(row, column, value());
    }
  }

  Index index(std::string_view field, Index size) {
    const std::int64_t one_based = tokens_.count(field, size);
    if (one_based == 0) tokens_.fail(field, "0, but Matrix Market counts from 1");
    return one_based - 1;
  }

  void read_coordinates(std::int64_t entries) {
    std::vector<bool> given(static_cast<std::size_t>(matrix_.size()));
    for (std::int64_t i = 0; i < entries; ++i) {
      const Index row = index("row of an entry", matrix_.rows());
      const Index column = index("column of an entry", matrix_.cols());
      if (row < first_row(column)) {
        tokens_.fail("entry", "outside the stored triangle of a symmetric or skew-symmetric matrix");
      }
      const auto place = static_cast<std::size_t>(column * matrix_.rows() + row);
      if (given[place]) {
        tokens_.fail("entry", "(" + std::to_string(row + 1) + ", " + std::to_string(column + 1) + ") given twice");
      }
      given[place] = true;
      set(row, column, value());
    }
  }

  TextTokens tokens_;
  const std::string& origin_;
  Header header_;
  Matrix matrix_;
};

/// The name of the file of q in errors.
std::string q_file_of(const std::string& M_file) {
  const auto extension = M_file.rfind(".M.mtx");
  return extension == std::string::npos ? M_file + " (q)" : M_file.substr(0, extension) + ".q.mtx";
}

}  // namespace

Problem parse_matrix_market(std::string_view M_text, std::string_view q_text, const std::string& origin) {
  const std::string q_origin = q_file_of(origin);
  Lcp lcp;
  lcp.M = MatrixReader(M_text, origin).read();
  if (lcp.M.rows() != lcp.M.cols()) {
    throw input_error(origin, "M: " + std::to_string(lcp.M.rows()) + " x " + std::to_string(lcp.M.cols()) +
                                  ", expected a square matrix");
  }
  const Matrix q = MatrixReader(q_text, q_origin).read();
  if (q.cols() != 1 || q.rows() != lcp.M.rows()) {
    throw input_error(q_origin, "q: " + std::to_string(q.rows()) + " x " + std::to_string(q.cols()) + ", expected " +
                                    std::to_string(lcp.M.rows()) + " x 1");
  }
  lcp.q = q.col(0);
  return Problem(problem_name_of_file(origin), std::move(lcp));
}

}  // namespace lcpbench
