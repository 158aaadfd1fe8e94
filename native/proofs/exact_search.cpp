#include "native/proofs/exact_search.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/timed_solve.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// Multiplies rows and columns by powers of two, which bring the largest entry of each to between 1 and 2. Each entry
/// is rounded once, below the least normal number only.
template <class Block>
void scale(Block& A) {
  std::vector<int> of_row(at(A.rows()), 0);
  for (Index i = 0; i < A.rows(); ++i) {
    int largest = kNoExponent;
    for (Index j = 0; j < A.cols(); ++j) largest = std::max(largest, exponent_of(A(i, j)));
    if (largest != kNoExponent) of_row[at(i)] = -largest;
  }
  for (Index j = 0; j < A.cols(); ++j) {
    int largest = kNoExponent;
    for (Index i = 0; i < A.rows(); ++i) {
      if (A(i, j) != 0) largest = std::max(largest, exponent_of(A(i, j)) + of_row[at(i)]);
    }
    for (Index i = 0; i < A.rows() && largest != kNoExponent; ++i) A(i, j) = scaled(A(i, j), of_row[at(i)] - largest);
  }
}

}  // namespace

void ExactSearch::load(const Lcp& lcp) {
  lcp_ = &lcp;
  M_ = ExactMatrix(lcp.M);
  q_.clear();
  for (const double q : lcp.q) q_.emplace_back(q);
}

void ExactSearch::start(std::vector<Index> support) {
  support_ = std::move(support);
  others_.clear();
  for (Index i = 0; i < lcp_->size(); ++i) {
    if (!std::binary_search(support_.begin(), support_.end(), i)) others_.push_back(i);
  }
  rows_ = support_;
}

/// The rank of M in rows_ and the columns of the support; `with_q`: with q as one more column. -1 where that takes too
/// many digits, which ends the search.
Index ExactSearch::rank(bool with_q) {
  ExactMatrix transposed(static_cast<Index>(support_.size()) + (with_q ? 1 : 0), static_cast<Index>(rows_.size()));
  for (Index r = 0; r < transposed.cols; ++r) {
    for (Index j = 0; j < transposed.rows; ++j) {
      transposed(j, r) = at(j) < support_.size() ? M_(rows_[at(r)], support_[at(j)]) : q_[at(rows_[at(r)])];
    }
  }
  const auto independent = independent_columns(transposed);
  if (!independent) stopped_ = End::kSystemLimit;
  return independent ? static_cast<Index>(independent->size()) : -1;
}

/// Whether double proves that the block B of rows_ and the support is regular, and that B z = -q has a negative z, or w
/// outside of the support. If R is about the inverse of B and |I - R B| < 1 in the maximum norm, the computed z is off
/// by at most |R| |q + B z| / (1 - |I - R B|). @pre as many rows as the support has
/// [Rump 2010, "Verification methods", Acta Numerica 19]
bool ExactSearch::is_ruled_out() const {
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxSize, kMaxSize + 1>;
  using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxSize, 1>;
  constexpr double kRoundoff = 32 * 0x1p-53;  // of sums of up to 13 products, and of their bounds
  constexpr double kLost = 0x1p-900;          // more than underflow takes of numbers up to two
  if (rows_.empty()) return false;
  const auto order = static_cast<Index>(support_.size());
  Block all(lcp_->size(), order + 1);  // M on the support, and q
  for (Index j = 0; j < order; ++j) all.col(j) = lcp_->M.col(support_[at(j)]);
  all.col(order) = lcp_->q;
  scale(all);
  const Block B = all.leftCols(order)(rows_, Eigen::all);
  const Column q = all.col(order)(rows_);
  const Block R = B.partialPivLu().inverse();
  const Column z = -(R * q);
  const double size = 1 + z.cwiseAbs().sum();
  const double norm = R.cwiseAbs().rowwise().sum().maxCoeff();
  const double off_unit = (Block::Identity(order, order) - R * B).cwiseAbs().rowwise().sum().maxCoeff() +
                          kRoundoff * (R.cwiseAbs() * B.cwiseAbs()).rowwise().sum().maxCoeff() + kLost * norm;
  const Column terms = q.cwiseAbs() + B.cwiseAbs() * z.cwiseAbs();
  const double left = (q + B * z).cwiseAbs().maxCoeff() + kRoundoff * terms.maxCoeff() + kLost * size;
  if (!(off_unit < 0.5) || !(norm > 0x1p-100)) return false;
  const double off = 2 * norm * left * (1 + 0x1p-40);
  if (!(off < 0x1p100)) return false;
  if ((z.array() < -off).any()) return true;
  return std::any_of(others_.begin(), others_.end(), [&](Index row) {
    const Column m = all.row(row).head(order).transpose();
    const double magnitude = std::abs(all(row, order)) + m.cwiseAbs().dot(z.cwiseAbs());
    const double bound = m.cwiseAbs().sum() * off * (1 + 0x1p-40) + kRoundoff * magnitude + kLost * (size + off);
    return all(row, order) + m.dot(z) < -bound;
  });
}

/// Whether the point that rows_ determine solves the LCP; then z_ is that point, rounded. All of w is tested, because
/// rows_ may lack rows of the support.
bool ExactSearch::is_solution(const ExactSolution& solution) {
  for (const Dyadic& z : solution.numerators) {
    if (z.sign() < 0) return false;
  }
  for (Index i = 0; i < lcp_->size(); ++i) {
    Dyadic w = q_[at(i)] * solution.denominator;
    for (std::size_t j = 0; j < support_.size(); ++j) w += M_(i, support_[j]) * solution.numerators[j];
    const bool vanishes = std::binary_search(support_.begin(), support_.end(), i);
    if (vanishes ? w.sign() != 0 : w.sign() < 0) return false;
  }
  z_ = Vector::Zero(lcp_->size());
  for (std::size_t j = 0; j < support_.size(); ++j) {
    z_(support_[j]) = to_double(quotient(solution.numerators[j], solution.denominator));
  }
  return true;
}

/// The point that rows_ determine. kSingular also where it takes too many digits, which ends the search.
ExactSearch::Point ExactSearch::try_rows() {
  ++systems_;
  if (is_ruled_out()) return Point::kNone;
  const auto order = static_cast<Index>(support_.size());
  ExactMatrix block(order, order);
  std::vector<Dyadic> right;
  for (Index i = 0; i < order; ++i) {
    for (Index j = 0; j < order; ++j) block(i, j) = M_(rows_[at(i)], support_[at(j)]);
    right.push_back(-q_[at(rows_[at(i)])]);
  }
  const std::optional<ExactSolution> solution = solve_exactly(block, right);
  if (!solution) stopped_ = End::kSystemLimit;
  if (!solution || solution->denominator.is_zero()) return Point::kSingular;
  return is_solution(*solution) ? Point::kSolution : Point::kNone;
}

/// Tries every point that rows_ and further rows w_j = 0, of others_ from first_other on, determine. Leaves rows_ as
/// they were. @returns whether one solves the LCP @pre rows_ are independent
bool ExactSearch::complete(std::size_t first_other) {
  if (stopped_ == End::kNone && !(wall_clock_s() < deadline_s_)) stopped_ = End::kTimeLimit;
  if (stopped_ == End::kNone && systems_ >= most_systems_) stopped_ = End::kSystemLimit;
  if (stopped_ != End::kNone) return false;
  if (rows_.size() == support_.size()) return try_rows() == Point::kSolution;
  for (std::size_t k = first_other; k < others_.size() && stopped_ == End::kNone; ++k) {
    rows_.push_back(others_[k]);
    const bool found = rank(false) == static_cast<Index>(rows_.size()) && complete(k + 1);
    rows_.pop_back();
    if (found) return true;
  }
  return false;
}

/// Tries all points of the header's comment that belong to this support.
bool ExactSearch::find_with_support() {
  if (const Point point = try_rows(); point != Point::kSingular) return point == Point::kSolution;
  const Index of_rows = rank(false);
  if (stopped_ != End::kNone || rank(true) != of_rows) return false;  // the equations contradict each other
  std::vector<Index> independent;
  for (const Index row : support_) {
    rows_ = independent;
    rows_.push_back(row);
    if (rank(false) == static_cast<Index>(rows_.size())) independent = rows_;
  }
  rows_ = independent;
  return complete(0);
}

bool ExactSearch::solves_with(const std::vector<Index>& support) {
  start(support);
  return try_rows() == Point::kSolution;
}

ExactSearch::End ExactSearch::run(double deadline_s, std::int64_t most_systems) {
  deadline_s_ = deadline_s;
  most_systems_ = most_systems;
  stopped_ = End::kNone;
  systems_ = 0;
  for (std::uint32_t set = 0; set < std::uint32_t{1} << lcp_->size() && stopped_ == End::kNone; ++set) {
    if (!(wall_clock_s() < deadline_s_)) return End::kTimeLimit;
    if (systems_ >= most_systems_) return End::kSystemLimit;
    std::vector<Index> support;
    for (Index i = 0; i < lcp_->size(); ++i) {
      if ((set >> i & 1U) != 0) support.push_back(i);
    }
    start(std::move(support));
    if (find_with_support()) return End::kFound;
  }
  return stopped_;
}

}  // namespace lcpbench
