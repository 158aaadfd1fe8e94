#include "study/certify/reduction.h"

#include <utility>

#include "core/selection.h"
#include "study/certify/basis.h"
#include "study/certify/integer_solve.h"

namespace lcpbench::exact {
namespace {

/// Where each row stands in `rows`; -1 where it does not.
std::vector<Index> positions(const std::vector<Index>& rows, Index size) {
  std::vector<Index> position(index(size), -1);
  for (std::size_t i = 0; i < rows.size(); ++i) position[index(rows[i])] = static_cast<Index>(i);
  return position;
}

// [L_a; -S_Ba]
IntegerMatrix right_side(const ExactSystem& system, const std::vector<Index>& basis, Index a) {
  const Index k = system.potentials();
  IntegerMatrix b(k + static_cast<Index>(basis.size()), 1);
  for (Index i = 0; i < k; ++i) fmpz_set(b(i, 0), system.L(i, a));
  for (std::size_t r = 0; r < basis.size(); ++r) {
    for (const Term& term : system.S[index(basis[r])]) {
      if (term.column == a)
        fmpz_sub(b(k + static_cast<Index>(r), 0), b(k + static_cast<Index>(r), 0), term.value.get());
    }
  }
  return b;
}

// All columns over the determinant.
bool solve_columns(const ExactSystem& system, const Equations& e, const Deadline& deadline, ReducedSystem& result) {
  const Lifting lifting(e.A, deadline);
  if (!lifting.possible()) return false;
  const auto columns = static_cast<Index>(result.kept.size()) + 1;
  result.solution = IntegerMatrix(e.A.cols(), columns);
  IntegerVector denominators(index(columns));
  for (Index j = 0; j < columns; ++j) {
    deadline.check();
    const IntegerMatrix b = j == 0 ? e.b : right_side(system, result.basis, result.kept[index(j - 1)]);
    IntegerMatrix x;
    if (!lifting.solve(b, x, denominators[index(j)])) return false;
    for (Index i = 0; i < x.rows(); ++i) fmpz_swap(result.solution(i, j), x(i, 0));
    fmpz_lcm(result.denominator.get(), result.denominator.get(), denominators[index(j)].get());
  }
  // Over the determinant the entries, and those that Lemke's method makes of them, are minors of the data.
  Integer factor = lifting.determinant_over(result.denominator);
  fmpz_mul(result.denominator.get(), result.denominator.get(), factor.get());
  for (Index j = 0; j < columns; ++j) {
    deadline.check();
    fmpz_divexact(factor.get(), result.denominator.get(), denominators[index(j)].get());
    for (Index i = 0; i < result.solution.rows(); ++i) {
      fmpz_mul(result.solution(i, j), result.solution(i, j), factor.get());
    }
  }
  return true;
}

/// The guess less what of its basis depends on the rest: that becomes unclear.
Guess independent_part(const ExactSystem& system, const Guess& guess, const Deadline& deadline) {
  const Index k = system.potentials();
  const Minor minor = independent_minor(basis_equations(system, guess.basis, guess.basis).A, deadline);
  Guess part;
  part.unclear = guess.unclear;
  std::vector<char> independent(guess.basis.size(), 0);
  for (const Index column : minor.columns) {
    if (column >= k) independent[index(column - k)] = 1;
  }
  for (std::size_t i = 0; i < guess.basis.size(); ++i) {
    (independent[i] != 0 ? part.basis : part.unclear).push_back(guess.basis[i]);
  }
  return part;
}

}  // namespace

std::optional<ReducedSystem> reduced(const ExactSystem& system, std::vector<Index> basis, std::vector<Index> kept,
                                     const Deadline& deadline) {
  const Index k = system.potentials();
  ReducedSystem result;
  result.basis = std::move(basis);
  result.kept = std::move(kept);
  if (!solve_columns(system, basis_equations(system, result.basis, result.basis), deadline, result)) {
    return std::nullopt;
  }
  const auto m = static_cast<Index>(result.kept.size());
  const std::vector<Index> basic = positions(result.basis, system.size());
  const std::vector<Index> own = positions(result.kept, system.size());
  IntegerMatrix values(m, m + 1);  // of w in the kept rows: the constant, then the columns
  for (Index i = 0; i < m; ++i) {
    const Index row = result.kept[index(i)];
    fmpz_mul(values(i, 0), system.q[index(row)].get(), result.denominator.get());
    for (Index j = 0; j <= m; ++j) {
      deadline.check();
      for (Index p = 0; p < k; ++p) fmpz_addmul(values(i, j), system.R(p, row), result.solution(p, j));
      for (const Term& term : system.S[index(row)]) {
        const Index position = basic[index(term.column)];
        if (position >= 0) fmpz_addmul(values(i, j), term.value.get(), result.solution(k + position, j));
      }
    }
    for (const Term& term : system.S[index(row)]) {
      const Index position = own[index(term.column)];
      if (position >= 0) fmpz_addmul(values(i, 1 + position), term.value.get(), result.denominator.get());
    }
  }
  result.lcp = {IntegerMatrix(m, m), IntegerVector(index(m)), result.denominator};
  for (Index i = 0; i < m; ++i) {
    fmpz_swap(result.lcp.q[index(i)].get(), values(i, 0));
    for (Index j = 0; j < m; ++j) fmpz_swap(result.lcp.M(i, j), values(i, 1 + j));
  }
  return result;
}

std::optional<ReducedSystem> without_potentials(const ExactSystem& system, const Deadline& deadline) {
  return reduced(system, {}, all_indices(system.size()), deadline);
}

ExactPoint expanded(const ReducedSystem& reduced, const ExactSystem& system, const IntegerVector& z,
                    const Integer& denominator) {
  const Index k = system.potentials();
  ExactPoint point{IntegerVector(index(k)), IntegerVector(index(system.size())), {}};
  for (Index i = 0; i < reduced.solution.rows(); ++i) {
    Integer& value = i < k ? point.p[index(i)] : point.z[index(reduced.basis[index(i - k)])];
    fmpz_mul(value.get(), reduced.solution(i, 0), denominator.get());
    for (std::size_t j = 0; j < z.size(); ++j) {
      fmpz_addmul(value.get(), reduced.solution(i, 1 + static_cast<Index>(j)), z[j].get());
    }
  }
  for (std::size_t j = 0; j < z.size(); ++j) {
    fmpz_mul(point.z[index(reduced.kept[j])].get(), z[j].get(), reduced.denominator.get());
  }
  fmpz_mul(point.denominator.get(), denominator.get(), reduced.denominator.get());
  return point;
}

std::optional<ExactPoint> settled_near(const ExactSystem& system, const Guess& guess, const Deadline& deadline,
                                       const std::function<bool(const ExactPoint&)>& accepts) {
  std::optional<ReducedSystem> small = reduced(system, guess.basis, guess.unclear, deadline);
  if (!small) {
    Guess part = independent_part(system, guess, deadline);
    if (part.basis.size() == guess.basis.size()) return std::nullopt;
    small = reduced(system, std::move(part.basis), std::move(part.unclear), deadline);
  }
  if (!small) return std::nullopt;
  const LemkeOutcome lemke = exact_lemke(small->lcp, deadline);
  if (lemke.ending != LemkeEnding::kSolution) return std::nullopt;
  ExactPoint point = expanded(*small, system, lemke.z, lemke.denominator);
  return accepts(point) ? std::optional(std::move(point)) : std::nullopt;
}

}  // namespace lcpbench::exact
