#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test.h"

namespace lcpbench {
namespace {

using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
using IndexSet = std::uint32_t;  // bit i: index i is in the set

constexpr Index kMaxSize = 12;

struct EnumerationSettings {
  void visit(auto&&) {}
};

bool contains(IndexSet set, Index i) { return (set >> i & 1U) != 0; }

std::vector<Index> members(IndexSet set) {
  std::vector<Index> result;
  for (Index i = 0; i < kMaxSize; ++i) {
    if (contains(set, i)) result.push_back(i);
  }
  return result;
}

/// "{0,2}".
std::string text(const std::vector<Index>& set) {
  std::string result = "{";
  for (const Index i : set) result += (result.size() > 1 ? "," : "") + std::to_string(i);
  return result + "}";
}

/// x = mantissa * 2^exponent exactly, |mantissa| < 2^53; exponent is left alone for x = 0.
std::int64_t mantissa_of(double x, int& exponent) {
  if (x == 0) return 0;
  const double fraction = std::frexp(x, &exponent);
  exponent -= std::numeric_limits<double>::digits;
  return static_cast<std::int64_t>(std::ldexp(fraction, std::numeric_limits<double>::digits));
}

/// The rows [M q], each multiplied by the power of two that makes it integers. Scaling a row scales its w alone, so
/// solutions stay what they are.
std::vector<std::vector<Integer>> integer_rows(const Lcp& lcp) {
  const Index n = lcp.size();
  std::vector<std::vector<Integer>> rows(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    const auto entry = [&](Index j) { return j < n ? lcp.M(i, j) : lcp.q(i); };
    int smallest = std::numeric_limits<int>::max();
    for (Index j = 0; j <= n; ++j) {
      int exponent = std::numeric_limits<int>::max();
      mantissa_of(entry(j), exponent);
      smallest = std::min(smallest, exponent);
    }
    for (Index j = 0; j <= n; ++j) {
      int exponent = smallest;
      const std::int64_t mantissa = mantissa_of(entry(j), exponent);
      rows[static_cast<std::size_t>(i)].push_back(Integer(mantissa) << static_cast<unsigned>(exponent - smallest));
    }
  }
  return rows;
}

/// numerator / denominator rounded once to the nearest double (twice when the result is subnormal). denominator != 0.
double nearest_double(const Integer& numerator, const Integer& denominator) {
  if (numerator == 0) return 0;
  Integer a = abs(numerator);
  Integer b = abs(denominator);
  // Scale so that the quotient has 63 or 64 bits; what the division drops is kept as a sticky last bit.
  const int shift = 63 + static_cast<int>(msb(b)) - static_cast<int>(msb(a));
  if (shift >= 0) {
    a <<= static_cast<unsigned>(shift);
  } else {
    b <<= static_cast<unsigned>(-shift);
  }
  Integer quotient, remainder;
  divide_qr(a, b, quotient, remainder);
  const auto bits = static_cast<std::uint64_t>(quotient) | (remainder != 0 ? 1U : 0U);
  const double magnitude = std::ldexp(static_cast<double>(bits), -shift);
  return (numerator < 0) != (denominator < 0) ? -magnitude : magnitude;
}

/// A system of linear equations that takes its rows one by one, exactly, by fraction-free elimination: every entry is a
/// determinant of the data, every division exact. O(rank columns) operations per row. [Bareiss 1968]
class ExactSystem {
 public:
  explicit ExactSystem(std::size_t columns) : columns_(columns) {}

  enum class Row { kIndependent, kDependent, kInconsistent };

  /// Takes in coefficients . x = right-hand side. @param row the coefficients, then the right-hand side
  Row add(std::vector<Integer> row) {
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const Integer factor = row[pivot_column_[r]];
      for (std::size_t j = 0; j <= columns_; ++j) {
        row[j] = (row[j] * pivot(r) - factor * rows_[r][j]) / (r > 0 ? pivot(r - 1) : Integer(1));
      }
    }
    for (std::size_t j = 0; j < columns_; ++j) {
      if (row[j] == 0) continue;
      rows_.push_back(std::move(row));
      pivot_column_.push_back(j);
      return Row::kIndependent;
    }
    return row[columns_] == 0 ? Row::kDependent : Row::kInconsistent;
  }

  bool full_rank() const { return rows_.size() == columns_; }

  /// The solution as numerators over one common positive denominator. @pre full_rank()
  void solve(std::vector<Integer>& numerators, Integer& denominator) const {
    denominator = rows_.empty() ? Integer(1) : pivot(rows_.size() - 1);
    numerators.assign(columns_, 0);
    for (std::size_t r = rows_.size(); r-- > 0;) {
      Integer sum = rows_[r][columns_] * denominator;
      for (std::size_t later = r + 1; later < rows_.size(); ++later) {
        sum -= rows_[r][pivot_column_[later]] * numerators[pivot_column_[later]];
      }
      numerators[pivot_column_[r]] = sum / pivot(r);
    }
    if (denominator > 0) return;
    denominator = -denominator;
    for (Integer& numerator : numerators) numerator = -numerator;
  }

 private:
  const Integer& pivot(std::size_t r) const { return rows_[r][pivot_column_[r]]; }

  std::size_t columns_;
  std::vector<std::vector<Integer>> rows_;  // row r is zero in the pivot columns of the rows before it
  std::vector<std::size_t> pivot_column_;
};

/// Decides LCP(q, M), n <= 12, in exact integer arithmetic by going through all 2^n supports of z.
///
/// For a support S the points z_S >= 0, w_S = 0, w >= 0 form a polyhedron without lines, so when it is not empty it has
/// a vertex: a point at which z vanishes outside some S' in S and the rows of S' together with further rows w_j = 0
/// determine z_S'. These points are all tried, so singular principal submatrices are decided like the others.
/// Supports come in the order of the number whose bit i says that i is in S; the first solution found is returned, each
/// entry rounded once. 2^n systems of order <= n when no principal submatrix is singular, at most 3^n otherwise.
/// [Cottle, Pang, Stone 1992, section 1.3: complementary cones]
class Enumeration final : public Solver {
 public:
  explicit Enumeration(const EnumerationSettings&) {}
  const Capabilities& capabilities() const override;

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  bool find_with_support(IndexSet support);
  bool complete(const ExactSystem& system, Index first_row);
  bool is_solution(const ExactSystem& system);
  std::vector<Integer> equation(Index row) const;
  void report_solution(Answer& answer);
  void report_none(Answer& answer) const;

  Index n_ = 0;
  std::vector<std::vector<Integer>> rows_;  // n rows [M_i q_i], scaled to integers

  std::vector<Index> support_;
  std::vector<Index> others_;
  std::vector<Integer> numerators_;  // of z on the support
  Integer denominator_ = 1;          // > 0
  AnswerTest test_;
  double deadline_s_ = 0;
  bool out_of_time_ = false;
  Counters counters_;
};

void Enumeration::on_load(const Problem& problem) {
  const Lcp lcp = make_lcp(problem);
  n_ = lcp.size();
  rows_ = integer_rows(lcp);
  test_.load(problem);
}

/// Row `row` of M z + q = 0 on the support.
std::vector<Integer> Enumeration::equation(Index row) const {
  const std::vector<Integer>& full = rows_[static_cast<std::size_t>(row)];
  std::vector<Integer> result;
  result.reserve(support_.size() + 1);
  for (const Index j : support_) result.push_back(full[static_cast<std::size_t>(j)]);
  result.push_back(-full.back());
  return result;
}

bool Enumeration::is_solution(const ExactSystem& system) {
  ++counters_.factorizations;
  system.solve(numerators_, denominator_);
  if (std::any_of(numerators_.begin(), numerators_.end(), [](const Integer& z) { return z < 0; })) return false;
  return std::all_of(others_.begin(), others_.end(), [this](Index row) {
    const std::vector<Integer>& full = rows_[static_cast<std::size_t>(row)];
    Integer w = full.back() * denominator_;
    for (std::size_t j = 0; j < support_.size(); ++j) w += full[static_cast<std::size_t>(support_[j])] * numerators_[j];
    return w >= 0;
  });
}

/// Tries every point that `system` and rows w_j = 0, j >= first_row outside the support, determine.
bool Enumeration::complete(const ExactSystem& system, Index first_row) {
  out_of_time_ = out_of_time_ || !(wall_clock_s() < deadline_s_);
  if (out_of_time_) return false;
  if (system.full_rank()) return is_solution(system);
  for (const Index row : others_) {
    if (row < first_row || out_of_time_) continue;
    ExactSystem larger = system;
    if (larger.add(equation(row)) == ExactSystem::Row::kIndependent && complete(larger, row + 1)) return true;
  }
  return false;
}

bool Enumeration::find_with_support(IndexSet support) {
  support_ = members(support);
  others_ = members(~support & ((IndexSet{1} << n_) - 1));
  ExactSystem system(support_.size());
  for (const Index row : support_) {
    if (system.add(equation(row)) == ExactSystem::Row::kInconsistent) return false;
  }
  return complete(system, 0);
}

/// M of a contact problem is rounded when it is formed: its exact solution need not be one of the contacts.
void Enumeration::report_solution(Answer& answer) {
  for (std::size_t j = 0; j < support_.size(); ++j) {
    answer.z(support_[j]) = nearest_double(numerators_[j], denominator_);
  }
  answer.claim = answer.z.allFinite() ? Claim::kSolved : Claim::kNumericalFailure;
  answer.detail = "exact solution with z = 0 outside " + text(support_);
  if (answer.claim != Claim::kSolved) {
    answer.detail += " overflows double";
    return;
  }
  const std::string detail = answer.detail;
  if (test_.settle(answer, deadline_s_)) return;
  if (answer.claim == Claim::kTimeLimit) return;
  answer.detail = problem().contact() != nullptr
                      ? "the exact solution for M as rounded to double does not solve the contact problem"
                      : detail + ": rounded to double it solves the problem no more";
}

/// M of a contact problem is rounded when it is formed: that it has no solution proves nothing about the contacts.
void Enumeration::report_none(Answer& answer) const {
  const bool data_are_exact = problem().contact() == nullptr;
  answer.claim = data_are_exact ? Claim::kUnsolvable : Claim::kNumericalFailure;
  answer.detail = data_are_exact ? "every support of z ruled out in exact arithmetic"
                                 : "no solution for M as rounded to double; the contact problem may have one";
}

void Enumeration::on_solve(const SolveRequest& request, Answer& answer) {
  deadline_s_ = wall_clock_s() + request.time_limit_s;
  out_of_time_ = false;
  counters_ = {.iterations = 0, .pivots = -1, .factorizations = 0};
  bool found = false;
  for (IndexSet support = 0; support < IndexSet{1} << n_ && !found && !out_of_time_; ++support) {
    ++counters_.iterations;
    found = find_with_support(support);
  }
  if (found) {
    report_solution(answer);
  } else if (out_of_time_) {
    answer.claim = Claim::kTimeLimit;
  } else {
    report_none(answer);
  }
  answer.counters = counters_;
}

// Not allocation_free: integers of any size live on the heap.
constexpr Capabilities kCapabilities{
    .max_size = kMaxSize, .guarantees = "every (q, M) as rounded to double", .obeys_time_limit = true};

const Capabilities& Enumeration::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_enumeration() {
  return define_solver<Enumeration, EnumerationSettings>(
      {.name = "enumeration",
       .summary = "all 2^n complementary supports in exact integer arithmetic: an oracle for n <= 12",
       .source = "Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, section 1.3; Bareiss 1968",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
