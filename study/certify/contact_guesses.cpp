#include "study/certify/contact_guesses.h"

#include <cmath>
#include <cstdint>
#include <utility>

namespace lcpbench::exact {
namespace {

using Basis = std::vector<Index>;

// What contact i may do.
std::vector<Basis> modes(const ContactLayout& layout, Index i) {
  const auto at = static_cast<std::size_t>(i);
  const Index begin = layout.friction_offset() + layout.friction_begin[at];
  const Index edges = layout.friction_begin[at + 1] - layout.friction_begin[at];
  std::vector<Basis> result{{}};
  if (edges == 0) result.push_back({i});
  const Index lambda = layout.lambda_offset() + layout.lambda[at];
  for (Index t = 0; t < edges; ++t) {
    result.push_back({begin + t, lambda});
    result.push_back({i, begin + t, lambda});
    Basis stick{i, begin + t};
    if (edges > 2) stick.push_back(begin + (t + 1) % edges);
    result.push_back(stick);
  }
  return result;
}

constexpr int kLargestExponent = 6;

// splitmix64: every bit of the result depends on every bit of x.
std::uint64_t scrambled(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

struct Units {
  double normal = 1;
  double friction = 1;
};

Units units(Index number, Index contact) {
  if (number == 0) return {};
  const std::uint64_t bits =
      scrambled(scrambled(static_cast<std::uint64_t>(number)) + static_cast<std::uint64_t>(contact));
  const auto power = [](std::uint64_t draw) {
    return std::ldexp(1.0, static_cast<int>(draw % (2 * kLargestExponent + 1)) - kLargestExponent);
  };
  return {power(bits >> 32), power(bits & 0xffffffffU)};
}

}  // namespace

std::vector<Basis> contact_modes(const ContactProblem& problem, std::size_t limit) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Basis> all{{}};
  for (Index i = 0; i < layout.nc; ++i) {
    const std::vector<Basis> own = modes(layout, i);
    if (all.size() * own.size() > limit) return {};
    std::vector<Basis> longer;
    for (const Basis& basis : all) {
      for (const Basis& mode : own) {
        longer.push_back(basis);
        longer.back().insert(longer.back().end(), mode.begin(), mode.end());
      }
    }
    all = std::move(longer);
  }
  return all;
}

Vector ContactVariant::original(const Vector& z) const {
  Vector result(z.size());
  for (Index i = 0; i < z.size(); ++i) {
    result(from[static_cast<std::size_t>(i)]) = unit[static_cast<std::size_t>(i)] * z(i);
  }
  return result;
}

ContactVariant contact_variant(const ContactProblem& problem, Index number) {
  const ContactLayout layout = contact_layout(problem);
  const Matrix N = to_dense(problem.N);
  const Matrix D = to_dense(problem.D);
  Matrix new_N(N.rows(), N.cols());
  Matrix new_D(D.rows(), D.cols());
  ContactVariant variant{problem, std::vector<Index>(static_cast<std::size_t>(layout.size())),
                         std::vector<double>(static_cast<std::size_t>(layout.size()))};
  const auto place = [&](Index i, Index original, double unit) {
    variant.from[static_cast<std::size_t>(i)] = original;
    variant.unit[static_cast<std::size_t>(i)] = unit;
  };
  Index next_friction = 0;
  Index next_lambda = layout.lambda_offset();
  for (Index i = 0; i < layout.nc; ++i) {
    const Index contact = (number % layout.nc + layout.nc - 1 - i + layout.nc) % layout.nc;
    const auto at = static_cast<std::size_t>(contact);
    const Units unit = units(number, contact);
    variant.problem.edges[static_cast<std::size_t>(i)] = problem.edges[at];
    variant.problem.mu(i) = problem.mu(contact) * (unit.normal / unit.friction);
    new_N.col(i) = unit.normal * N.col(contact);
    if (problem.has_offset()) variant.problem.b(i) = unit.normal * problem.b(contact);
    if (problem.compliance_n.size() > 0) {
      variant.problem.compliance_n(i) = unit.normal * unit.normal * problem.compliance_n(contact);
    }
    if (problem.compliance_t.size() > 0) {
      variant.problem.compliance_t(i) = unit.friction * unit.friction * problem.compliance_t(contact);
    }
    if (problem.offset_t.size() > 0) {
      variant.problem.offset_t.segment<2>(2 * i) = unit.friction * problem.offset_t.segment<2>(2 * contact);
    }
    place(i, contact, unit.normal);
    for (Index t = layout.friction_begin[at]; t < layout.friction_begin[at + 1]; ++t) {
      new_D.col(next_friction) = unit.friction * D.col(t);
      place(layout.friction_offset() + next_friction++, layout.friction_offset() + t, unit.friction);
    }
    if (layout.lambda[at] >= 0) place(next_lambda++, layout.lambda_offset() + layout.lambda[at], 1 / unit.friction);
  }
  variant.problem.N = new_N;
  variant.problem.D = new_D;
  return variant;
}

}  // namespace lcpbench::exact
