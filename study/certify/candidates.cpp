#include "study/certify/candidates.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/registry.h"

namespace lcpbench::exact {
namespace {

/// What contact i may do: part, with or without a slip bound at work, slide along one friction column, or stick between
/// two neighbouring ones (one, where there are but two).
std::vector<std::vector<Index>> modes(const ContactLayout& layout, Index i) {
  const Index begin = layout.friction_offset() + layout.friction_begin[index(i)];
  const Index edges = layout.friction_begin[index(i) + 1] - layout.friction_begin[index(i)];
  std::vector<std::vector<Index>> result{{}};
  if (edges == 0) result.push_back({i});
  const Index lambda = layout.lambda_offset() + layout.lambda[index(i)];
  for (Index t = 0; t < edges; ++t) {
    result.push_back({begin + t, lambda});
    result.push_back({i, begin + t, lambda});
    result.push_back({i, begin + t});
    if (edges > 2) result.back().push_back(begin + (t + 1) % edges);
  }
  return result;
}

}  // namespace

const Answer& Candidates::answer(const std::string& spec, const Problem& problem, double time_limit_s) {
  Kept& kept = kept_[spec];
  if (kept.solver == nullptr) kept.solver = make_solver(parse_spec(spec));
  kept.solver->load(problem);
  kept.solver->solve({.start = nullptr, .time_limit_s = time_limit_s}, kept.answer);
  return kept.answer;
}

std::vector<Index> support(const Vector& z, Index n) {
  std::vector<Index> positive;
  if (z.size() != n || !z.allFinite()) return positive;
  for (Index i = 0; i < n; ++i) {
    if (z(i) > 0) positive.push_back(i);
  }
  std::stable_sort(positive.begin(), positive.end(), [&](Index a, Index b) { return z(a) > z(b); });
  return positive;
}

Guess classified(const Lcp& lcp, const Vector& z) {
  constexpr double kClear = 1e-9;
  constexpr double kTight = 1e-8;
  Guess guess;
  if (z.size() != lcp.size() || !z.allFinite()) return guess;
  const Vector w = lcp.q + lcp.M * z;
  const Vector terms = lcp.q.cwiseAbs() + lcp.M.cwiseAbs() * z.cwiseAbs();
  for (Index i = 0; i < z.size(); ++i) {
    double part = 0;  // of z_i in the rows that it moves
    for (Index j = 0; j < z.size(); ++j) {
      if (lcp.M(j, i) != 0 && terms(j) > 0) part = std::max(part, std::abs(lcp.M(j, i)) * z(i) / terms(j));
    }
    const bool pressed = part > kClear;
    const bool open = w(i) > kClear * terms(i);
    if (pressed && !open) guess.basis.push_back(i);
    if (pressed == open) guess.unclear.push_back(i);
    if (!(z(i) > 0) && std::abs(w(i)) <= kTight * terms(i)) guess.tight.push_back(i);
  }
  return guess;
}

Point point_on(const ExactSystem& system, const std::vector<Index>& basis, const Deadline& deadline,
               const std::function<std::vector<Index>()>& more_rows) {
  std::vector<Index> rows = range(0, system.potentials);
  std::vector<Index> columns = range(1, 1 + system.potentials);
  for (const Index i : basis) {
    rows.push_back(system.row_of(i));
    columns.push_back(system.column_of(i));
  }
  const IntegerMatrix A = part(system.rows, rows, columns);
  Integer denominator;
  IntegerMatrix x;
  if (std::ssize(independent_columns(A, deadline)) == A.cols()) {
    solve(A, part(system.rows, rows, {0}), x, denominator, deadline);
  } else {
    for (const Index i : more_rows()) rows.push_back(system.row_of(i));
    x = determined(part(system.rows, rows, columns), part(system.rows, rows, {0}), denominator, deadline);
  }
  Point point(system.rows.cols());
  fmpz_set(point(0), denominator.get());
  for (Index j = 0; j < x.rows(); ++j) fmpz_neg(point(columns[index(j)]), x(j));
  return point;
}

std::vector<Index> exchanged_basis(const ExactSystem& system, const Point& point, const IntegerMatrix& values) {
  std::vector<Index> basis;
  for (Index i = 0; i < system.size; ++i) {
    const int sign = point.sign(system.column_of(i));
    if (sign > 0 || (sign == 0 && values.sign(system.row_of(i)) < 0)) basis.push_back(i);
  }
  return basis;
}

std::vector<std::vector<Index>> combinations(const ContactProblem& contact, std::size_t limit) {
  const ContactLayout layout = contact_layout(contact);
  std::vector<std::vector<Index>> all{{}};
  for (Index i = 0; i < layout.nc; ++i) {
    const std::vector<std::vector<Index>> own = modes(layout, i);
    if (all.size() * own.size() > limit) return {};
    std::vector<std::vector<Index>> longer;
    for (const std::vector<Index>& basis : all) {
      for (const std::vector<Index>& mode : own) {
        longer.push_back(basis);
        longer.back().insert(longer.back().end(), mode.begin(), mode.end());
      }
    }
    all = std::move(longer);
  }
  return all;
}

Variant::Variant(const Lcp& original, Index number) : order(range(0, original.size())), unit(original.size()) {
  std::reverse(order.begin(), order.end());
  std::rotate(order.begin(), order.end() - number % original.size(), order.end());
  for (Index i = 0; i < unit.size(); ++i) {
    const auto mixed = static_cast<std::uint32_t>(order[index(i)] * 8 + number) * 2654435761U;
    unit(i) = number > 0 ? std::ldexp(1.0, static_cast<int>((mixed >> 16) % 13) - 6) : 1.0;
  }
  lcp.M = unit.asDiagonal() * original.M(order, order) * unit.asDiagonal();
  lcp.q = unit.cwiseProduct(original.q(order));
}

Vector Variant::of_original(const Vector& z) const {
  Vector result(z.size());
  result(order) = unit.cwiseProduct(z);
  return result;
}

}  // namespace lcpbench::exact
