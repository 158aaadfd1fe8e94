#include "study/certify/contact_variants.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/selection.h"
#include "study/certify/integers.h"

namespace lcpbench::exact {
namespace {

// What contact i may do: part, with or without a slip bound at work, slide along one friction column, or stick between
// two neighbouring ones (one, where there are but two).
std::vector<std::vector<Index>> modes(const ContactLayout& layout, Index i) {
  const auto at = index(i);
  const Index begin = layout.friction_offset() + layout.friction_begin[at];
  const Index edges = layout.friction_begin[at + 1] - layout.friction_begin[at];
  std::vector<std::vector<Index>> result{{}};
  if (edges == 0) result.push_back({i});
  const Index lambda = layout.lambda_offset() + layout.lambda[at];
  for (Index t = 0; t < edges; ++t) {
    result.push_back({begin + t, lambda});
    result.push_back({i, begin + t, lambda});
    result.push_back({i, begin + t});
    if (edges > 2) result.back().push_back(begin + (t + 1) % edges);
  }
  return result;
}

// splitmix64: every bit of the result depends on every bit of x.
std::uint64_t scrambled(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

}  // namespace

std::vector<std::vector<Index>> contact_modes(const ContactProblem& problem, std::size_t limit) {
  const ContactLayout layout = contact_layout(problem);
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

ContactVariant::ContactVariant(const ContactProblem& original, Index number)
    : order(all_indices(original.nc())), normal(original.nc()), friction(original.nc()) {
  std::reverse(order.begin(), order.end());
  std::rotate(order.begin(), order.end() - number % original.nc(), order.end());
  problem = select_contacts(original, order);
  const auto unit = [&](std::uint64_t draw) {
    return number > 0 ? std::ldexp(1.0, static_cast<int>(draw % 13) - 6) : 1.0;
  };
  std::vector<double> of_direction;
  for (Index i = 0; i < problem.nc(); ++i) {
    const auto contact = static_cast<std::uint64_t>(order[index(i)]);
    const std::uint64_t bits = scrambled(scrambled(static_cast<std::uint64_t>(number)) + contact);
    normal(i) = unit(bits >> 32);
    friction(i) = unit(bits & 0xffffffffU);
    const int edges = problem.edges[index(i)];
    of_direction.insert(of_direction.end(), index(edges), friction(i));
  }
  const auto scaled = [](const Jacobian& J, const Vector& by) { return Matrix(to_dense(J) * by.asDiagonal()); };
  problem.N = scaled(problem.N, normal);
  problem.D = scaled(problem.D, Vector::Map(of_direction.data(), std::ssize(of_direction)));
  problem.mu.array() *= normal.array() / friction.array();
  if (problem.has_offset()) problem.b.array() *= normal.array();
  if (problem.compliance_n.size() > 0) problem.compliance_n.array() *= normal.array().square();
  if (problem.compliance_t.size() > 0) problem.compliance_t.array() *= friction.array().square();
  for (Index k = 0; k < problem.offset_t.size(); ++k) problem.offset_t(k) *= friction(k / 2);
}

Vector ContactVariant::of_original(const Vector& z) const {
  const ContactLayout here = contact_layout(problem);
  std::vector<Index> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[index(order[i])] = static_cast<Index>(i);
  Vector result(z.size());
  Index friction_row = here.friction_offset();
  Index lambda_row = here.lambda_offset();
  for (std::size_t contact = 0; contact < place.size(); ++contact) {
    const Index i = place[contact];
    const auto at = index(i);
    result(static_cast<Index>(contact)) = normal(i) * z(i);
    for (Index t = here.friction_begin[at]; t < here.friction_begin[at + 1]; ++t) {
      result(friction_row++) = friction(i) * z(here.friction_offset() + t);
    }
    if (here.lambda[at] >= 0) result(lambda_row++) = z(here.lambda_offset() + here.lambda[at]) / friction(i);
  }
  return result;
}

}  // namespace lcpbench::exact
