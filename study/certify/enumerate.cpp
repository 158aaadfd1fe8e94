#include "study/certify/enumerate.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace lcpbench::exact {
namespace {

std::size_t index(Index i) { return static_cast<std::size_t>(i); }

bool contradicts(const IntegerMatrix& A, const IntegerVector& b, const IntegerVector& y) {
  Integer sum;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (y[i].sign() < 0) return false;
    fmpz_addmul(sum.get(), b[i].get(), y[i].get());
  }
  if (sum.sign() >= 0) return false;
  for (Index j = 0; j < A.cols(); ++j) {
    fmpz_zero(sum.get());
    for (Index i = 0; i < A.rows(); ++i) fmpz_addmul(sum.get(), A(i, j), y[index(i)].get());
    if (sum.sign() > 0) return false;
  }
  return true;
}

enum class Imposed { kNothing, kZeroZ, kZeroW };

class Search {
 public:
  Search(const IntegerLcp& lcp, const std::vector<slong>& w_exponent, const Deadline& deadline)
      : lcp_(lcp), w_exponent_(w_exponent), deadline_(deadline), imposed_(index(lcp.size()), Imposed::kNothing) {}

  EnumerationOutcome run() {
    EnumerationOutcome outcome = search();
    if (outcome.ending == EnumerationEnding::kNone) outcome.proof = std::move(proof_);
    return outcome;
  }

 private:
  EnumerationOutcome search() {
    FeasibilityOutcome node = relaxation();
    if (node.feasibility == Feasibility::kUnknown) return {};
    if (node.feasibility == Feasibility::kInfeasible) {
      if (!w_exponent_.empty()) proof_.push_back({-1, multipliers(node.point)});
      return {.ending = EnumerationEnding::kNone};
    }
    const IntegerVector z = whole(node.point);
    const Index violated = violated_pair(z, node.denominator);
    if (violated < 0) return {EnumerationEnding::kSolution, z, node.denominator, {}};
    proof_.push_back({violated, {}});
    EnumerationOutcome outcome;
    for (const Imposed side : {Imposed::kZeroW, Imposed::kZeroZ}) {
      imposed_[index(violated)] = side;
      outcome = search();
      if (outcome.ending != EnumerationEnding::kNone) break;
    }
    imposed_[index(violated)] = Imposed::kNothing;
    return outcome;
  }

  // Of the rows, in the units of the problem, from those of the inequalities.
  std::vector<Multiplier> multipliers(IntegerVector y) const {
    std::size_t closed = imposed_.size();
    const slong largest = *std::max_element(w_exponent_.begin(), w_exponent_.end());
    std::vector<Multiplier> of_rows;
    for (std::size_t i = 0; i < imposed_.size(); ++i) {
      if (imposed_[i] == Imposed::kZeroW) fmpz_sub(y[i].get(), y[i].get(), y[closed++].get());
      if (y[i].sign() == 0) continue;
      fmpz_mul_2exp(y[i].get(), y[i].get(), static_cast<ulong>(largest - w_exponent_[i]));
      of_rows.push_back({static_cast<Index>(i), text(y[i])});
    }
    return of_rows;
  }

  // The inequalities in the z that are not imposed to be zero: w >= 0, and -w_i >= 0 where w_i = 0 is imposed.
  FeasibilityOutcome relaxation() const {
    const Index n = lcp_.size();
    std::vector<Index> free;
    std::vector<Index> closed;
    for (Index i = 0; i < n; ++i) {
      if (imposed_[index(i)] != Imposed::kZeroZ) free.push_back(i);
      if (imposed_[index(i)] == Imposed::kZeroW) closed.push_back(i);
    }
    IntegerMatrix A(n + static_cast<Index>(closed.size()), static_cast<Index>(free.size()));
    IntegerVector b = lcp_.q;
    for (const Index row : closed) {
      b.emplace_back();
      fmpz_neg(b.back().get(), lcp_.q[index(row)].get());
    }
    for (Index j = 0; j < A.cols(); ++j) {
      for (Index i = 0; i < n; ++i) fmpz_set(A(i, j), lcp_.M(i, free[index(j)]));
      for (std::size_t c = 0; c < closed.size(); ++c) {
        fmpz_neg(A(n + static_cast<Index>(c), j), lcp_.M(closed[c], free[index(j)]));
      }
    }
    return feasible_point(A, b, deadline_);
  }

  IntegerVector whole(const IntegerVector& free) const {
    IntegerVector z(imposed_.size());
    std::size_t next = 0;
    for (std::size_t i = 0; i < z.size(); ++i) {
      if (imposed_[i] != Imposed::kZeroZ) z[i] = free[next++];
    }
    return z;
  }

  // The first i with z_i > 0 and w_i > 0, or -1.
  Index violated_pair(const IntegerVector& z, const Integer& denominator) const {
    Integer w;
    for (Index i = 0; i < lcp_.size(); ++i) {
      if (z[index(i)].sign() == 0) continue;
      fmpz_mul(w.get(), lcp_.q[index(i)].get(), denominator.get());
      for (Index j = 0; j < lcp_.size(); ++j) fmpz_addmul(w.get(), lcp_.M(i, j), z[index(j)].get());
      if (w.sign() != 0) return i;
    }
    return -1;
  }

  const IntegerLcp& lcp_;
  const std::vector<slong>& w_exponent_;
  const Deadline& deadline_;
  std::vector<Imposed> imposed_;
  std::vector<ProofNode> proof_;
};

}  // namespace

FeasibilityOutcome feasible_point(const IntegerMatrix& A, const IntegerVector& b, const Deadline& deadline) {
  const Index columns = A.cols();
  const Index rows = A.rows();
  IntegerLcp lcp{IntegerMatrix(columns + rows, columns + rows), IntegerVector(index(columns + rows))};
  for (Index i = 0; i < rows; ++i) {
    lcp.q[index(columns + i)] = b[index(i)];
    for (Index j = 0; j < columns; ++j) {
      fmpz_set(lcp.M(columns + i, j), A(i, j));
      fmpz_neg(lcp.M(j, columns + i), A(i, j));
    }
  }
  LemkeOutcome lemke = exact_lemke(lcp, deadline);
  const auto middle = lemke.z.begin() + std::min<std::ptrdiff_t>(columns, static_cast<std::ptrdiff_t>(lemke.z.size()));
  if (lemke.ending == LemkeEnding::kSolution) {
    return {Feasibility::kFeasible, IntegerVector(lemke.z.begin(), middle), lemke.denominator};
  }
  if (lemke.ending == LemkeEnding::kRay) {
    IntegerVector y(middle, lemke.z.end());
    if (contradicts(A, b, y)) return {Feasibility::kInfeasible, std::move(y), Integer(1)};
  }
  return {};
}

EnumerationOutcome enumerate_cones(const IntegerLcp& lcp, const std::vector<slong>& w_exponent,
                                   const Deadline& deadline) {
  return Search(lcp, w_exponent, deadline).run();
}

}  // namespace lcpbench::exact
