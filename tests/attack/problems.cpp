#include "tests/attack/problems.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/attack/exact.h"

namespace lcpbench::attack {

const char* to_string(Family family) {
  constexpr const char* kNames[] = {"lcp", "mixed", "contact", "soft", "doubtful", "rank", "rows", "limits"};
  return kNames[static_cast<std::size_t>(family)];
}

const std::vector<std::string>& kinds(Family family) {
  static const std::vector<std::string> soft = [] {
    std::vector<std::string> all = contact_kinds();
    all.insert(all.end(), doubtful_kinds().begin(), doubtful_kinds().end());
    return all;
  }();
  switch (family) {
    case Family::kContact: return contact_kinds();
    case Family::kSoft: return soft;
    case Family::kDoubtful: return doubtful_kinds();
    case Family::kRank: return rank_kinds();
    case Family::kRows: return row_kinds();
    case Family::kLimits: return limit_kinds();
    default: return lcp_kinds();
  }
}

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

namespace {

/// Cholesky's pivots in scalar code: what the reader of problem files tests, with the same result on every machine.
bool cholesky_succeeds(Matrix G) {
  for (Index k = 0; k < G.rows(); ++k) {
    if (!(G(k, k) > 0)) return false;
    const double pivot = std::sqrt(G(k, k));
    for (Index i = k; i < G.rows(); ++i) G(i, k) /= pivot;
    for (Index j = k + 1; j < G.rows(); ++j) {
      for (Index i = j; i < G.rows(); ++i) G(i, j) -= G(i, k) * G(j, k);
    }
  }
  return true;
}

/// G has to be positive definite, or in doubtful problems semidefinite, without rounding too; G* may be semidefinite,
/// or so but for rounding.
bool admissible(const Inertia& inertia, Family family) {
  if (std::holds_alternative<FactoredInertia>(inertia)) return true;
  if (const auto* given = std::get_if<InverseInertia>(&inertia)) {
    if (!given->Ginv.allFinite()) return false;
    Matrix shifted = given->Ginv;
    double largest = 0;
    for (Index i = 0; i < shifted.rows(); ++i) largest = std::max(largest, shifted(i, i));
    shifted.diagonal().array() += static_cast<double>(shifted.rows()) * 0x1p-52 * largest;
    return positive_semidefinite(exact(shifted));
  }
  const Matrix G = dense_inertia(inertia);
  const bool semidefinite = family == Family::kDoubtful || family == Family::kRank;
  return G.allFinite() && cholesky_succeeds(G) &&
         (semidefinite ? positive_semidefinite(exact(G)) : positive_definite(exact(G)));
}

bool admissible(const ContactProblem& contact, Family family) {
  return contact.v.allFinite() && contact.b.allFinite() && contact.mu.allFinite() && all_finite(contact.N) &&
         all_finite(contact.D) && admissible(contact.inertia, family);
}

bool admissible(const Lcp& lcp) { return lcp.M.allFinite() && lcp.q.allFinite(); }

ContactProblem make_contact(Family family, std::size_t kind, Draw& draw) {
  switch (family) {
    case Family::kDoubtful: return make_doubtful_of_kind(kind, draw);
    case Family::kRank: return make_rank_of_kind(kind, draw);
    case Family::kRows: return make_rows_of_kind(kind, draw);
    case Family::kLimits: return make_limit_of_kind(kind, draw);
    case Family::kSoft: {
      const std::size_t first = contact_kinds().size();
      ContactProblem contact =
          kind >= first ? make_doubtful_of_kind(kind - first, draw) : make_contact_of_kind(kind, draw);
      soften(contact, draw);
      return contact;
    }
    default: return make_contact_of_kind(kind, draw);
  }
}

}  // namespace

Problem generate(Family family, std::uint64_t seed, std::uint64_t index) {
  const bool mixed = family == Family::kMixed, bare = mixed || family == Family::kLcp;
  const TrialKey key{stream_id(std::string("attack/") + to_string(family)), seed, index};
  const std::size_t kind = index % kinds(family).size();
  const std::string name = std::string(mixed ? "attack-mixed-" : "attack-") + kinds(family)[kind] + "-" + std::to_string(seed) + "-" + std::to_string(index);
  for (std::uint64_t attempt = 0;; ++attempt) {
    Draw draw(key, attempt);
    if (bare) {
      Lcp lcp = mixed ? make_mixed_of_kind(kind, draw) : make_lcp_of_kind(kind, draw);
      if (admissible(lcp)) return Problem(name, std::move(lcp));
    } else {
      ContactProblem contact = make_contact(family, kind, draw);
      const bool doubtful = family == Family::kSoft && kind >= contact_kinds().size();
      if (admissible(contact, doubtful ? Family::kDoubtful : family)) return Problem(name, std::move(contact));
    }
  }
}

}  // namespace lcpbench::attack
