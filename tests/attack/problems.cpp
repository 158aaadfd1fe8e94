#include "tests/attack/problems.h"

#include <cmath>
#include <limits>

#include "core/error.h"
#include "generators/problem_checks.h"
#include "tests/attack/exact.h"

namespace lcpbench::attack {

const char* to_string(Family family) { return family == Family::kLcp ? "lcp" : "contact"; }

const std::vector<std::string>& kinds(Family family) { return family == Family::kLcp ? lcp_kinds() : contact_kinds(); }

double Draw::power_of_two(int low, int high) { return std::ldexp(1.0, static_cast<int>(integer(low, high))); }

double Draw::mantissa() {
  const auto bits = static_cast<double>(sequence_.word() >> 12);
  return sign() * (1 + bits * 0x1p-52);
}

double Draw::neighbour(double x) {
  if (x == 0) return x;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  return std::nextafter(x, chance(1, 2) ? kInfinity : -kInfinity);
}

double dot(const Vector& a, const Vector& b) {
  double sum = 0;
  for (Index i = 0; i < a.size(); ++i) sum += a(i) * b(i);
  return sum;
}

Matrix product(const Matrix& A, const Matrix& B) {
  Matrix C(A.rows(), B.cols());
  for (Index i = 0; i < A.rows(); ++i) {
    for (Index j = 0; j < B.cols(); ++j) {
      double sum = 0;
      for (Index k = 0; k < A.cols(); ++k) sum += A(i, k) * B(k, j);
      C(i, j) = sum;
    }
  }
  return C;
}

/// G whole or by blocks has to be positive definite without rounding too; G* and factors may be singular.
bool definite_where_given_whole(const Inertia& inertia) {
  const bool whole = std::holds_alternative<DenseInertia>(inertia) || std::holds_alternative<BlockInertia>(inertia);
  return !whole || positive_definite(exact(dense_inertia(inertia)));
}

Problem generate(Family family, std::uint64_t seed, std::uint64_t index) {
  const bool bare = family == Family::kLcp;
  const TrialKey key{stream_id(bare ? "attack/lcp" : "attack/contact"), seed, index};
  const std::size_t kind = index % kinds(family).size();
  const std::string name = "attack-" + kinds(family)[kind] + "-" + std::to_string(seed) + "-" + std::to_string(index);
  for (std::uint64_t attempt = 0;; ++attempt) {
    Draw draw(key, attempt);
    try {
      if (bare) {
        Lcp lcp = make_lcp_of_kind(kind, draw);
        check_lcp(lcp, name);
        return Problem(name, std::move(lcp));
      }
      ContactProblem contact = make_contact_of_kind(kind, draw);
      check_contact(contact, name);
      if (!definite_where_given_whole(contact.inertia)) continue;
      return Problem(name, std::move(contact));
    } catch (const InputError&) {
      // What a problem file may not hold is no problem: not finite, not positive definite.
    }
  }
}

}  // namespace lcpbench::attack
