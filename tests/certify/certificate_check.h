#pragma once

#include <cstddef>
#include <vector>

#include <boost/multiprecision/cpp_int.hpp>
#include <gtest/gtest.h>

#include "core/compliance.h"
#include "core/problem.h"
#include "study/certify/certificate.h"

// What study/certify/certificate.h says of a certificate, checked from the problem's doubles in rational arithmetic by
// code that shares nothing with the certifier.

namespace lcpbench::testing {

using Rational = boost::multiprecision::cpp_rational;
using RationalVector = std::vector<Rational>;

inline RationalVector rationals(const ExactVector& x) {
  RationalVector result;
  for (const std::string& numerator : x.numerators) {
    result.emplace_back(boost::multiprecision::cpp_int(numerator), boost::multiprecision::cpp_int(x.denominator));
  }
  return result;
}

inline RationalVector rationals(const Vector& x) { return RationalVector(x.begin(), x.end()); }

inline RationalVector times(const Matrix& A, const RationalVector& x) {
  RationalVector y(static_cast<std::size_t>(A.rows()));
  for (Index j = 0; j < A.cols(); ++j) {
    const Rational& x_j = x[static_cast<std::size_t>(j)];
    if (x_j.is_zero()) continue;
    for (Index i = 0; i < A.rows(); ++i) {
      if (A(i, j) != 0) y[static_cast<std::size_t>(i)] += Rational(A(i, j)) * x_j;
    }
  }
  return y;
}

inline RationalVector transposed_times(const Matrix& A, const RationalVector& x) { return times(A.transpose(), x); }

inline RationalVector plus(RationalVector a, const RationalVector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

inline bool all_zero(const RationalVector& x) {
  for (const Rational& value : x) {
    if (!value.is_zero()) return false;
  }
  return true;
}

/// Contact data with dense columns and the factors that count.
struct DenseContact {
  explicit DenseContact(const ContactProblem& contact) : problem(contact), layout(contact_layout(contact)) {
    C = Matrix(contact.ngc(), layout.nc + layout.friction);
    C << to_dense(contact.N), to_dense(contact.D);
    if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) {
      X = Matrix(contact.ngc(), (factors->alpha.array() != 0).count());
      for (Index j = 0, k = 0; j < factors->alpha.size(); ++j) {
        if (factors->alpha(j) == 0) continue;
        X.col(k++) = factors->X.col(j);
        alpha.emplace_back(factors->alpha(j));
      }
    }
  }

  bool factored() const { return std::holds_alternative<FactoredInertia>(problem.inertia); }
  bool inverse() const { return std::holds_alternative<InverseInertia>(problem.inertia); }

  /// C'u + [b; 0]
  RationalVector velocities(const RationalVector& u) const {
    RationalVector result = transposed_times(C, u);
    for (Index i = 0; i < problem.b.size(); ++i) result[static_cast<std::size_t>(i)] += Rational(problem.b(i));
    for (Index i = 0; i < problem.nc() && problem.offset_t.size() > 0; ++i) {
      const RationalVector along{Rational(problem.offset_t(2 * i)), Rational(problem.offset_t(2 * i + 1))};
      add_along(i, along, result);
    }
    return result;
  }

  /// w += C'x in the friction rows of a contact.
  void add_along(Index contact, const RationalVector& x, RationalVector& w) const {
    const auto [first, edges] = friction(contact);
    for (Index k = 0; k < edges; ++k) {
      const auto [cosine, sine] = edge_direction(k, edges);
      w[static_cast<std::size_t>(first + k)] += Rational(cosine) * x[0] + Rational(sine) * x[1];
    }
  }

  /// w += R f
  void add_yielding(const RationalVector& f, RationalVector& w) const {
    for (Index i = 0; i < problem.compliance_n.size(); ++i) {
      w[static_cast<std::size_t>(i)] += Rational(problem.compliance_n(i)) * f[static_cast<std::size_t>(i)];
    }
    for (Index i = 0; i < problem.compliance_t.size(); ++i) {
      RationalVector net{0, 0};
      const auto [first, edges] = friction(i);
      for (Index k = 0; k < edges; ++k) {
        const auto [cosine, sine] = edge_direction(k, edges);
        net[0] += Rational(cosine) * f[static_cast<std::size_t>(first + k)];
        net[1] += Rational(sine) * f[static_cast<std::size_t>(first + k)];
      }
      const Rational r(problem.compliance_t(i));
      add_along(i, {r * net[0], r * net[1]}, w);
    }
  }

  std::pair<Index, Index> friction(Index contact) const {
    const auto i = static_cast<std::size_t>(contact);
    return {layout.friction_offset() + layout.friction_begin[i],
            layout.friction_begin[i + 1] - layout.friction_begin[i]};
  }

  RationalVector change_of_velocity(const RationalVector& p) const { return factored() ? times(X, p) : p; }

  /// K p
  RationalVector inertia_times(const RationalVector& p) const {
    if (inverse()) return p;
    if (!factored()) return times(dense_inertia(problem.inertia), p);
    RationalVector weighted = transposed_times(X, times(X, p));
    for (std::size_t i = 0; i < weighted.size(); ++i) weighted[i] *= alpha[i];
    return transposed_times(X, times(X, weighted));
  }

  /// B f, or G* C f
  RationalVector forced(const RationalVector& f) const {
    const RationalVector impulse = times(C, f);
    if (factored()) return transposed_times(X, impulse);
    return inverse() ? times(std::get<InverseInertia>(problem.inertia).Ginv, impulse) : impulse;
  }

  const ContactProblem& problem;
  ContactLayout layout;
  Matrix C;
  Matrix X;
  RationalVector alpha;
};

inline void expect_complementary(const RationalVector& z, const RationalVector& w) {
  ASSERT_EQ(z.size(), w.size());
  for (std::size_t i = 0; i < z.size(); ++i) {
    EXPECT_GE(z[i], 0) << i;
    EXPECT_GE(w[i], 0) << i;
    EXPECT_TRUE(z[i].is_zero() || w[i].is_zero()) << i;
  }
}

inline void expect_contact_solution(const DenseContact& contact, const RationalVector& z, const RationalVector& p) {
  const ContactLayout& layout = contact.layout;
  const auto impulses = z.begin() + layout.lambda_offset();
  const RationalVector f(z.begin(), impulses);
  EXPECT_EQ(contact.inertia_times(p), contact.forced(f));
  RationalVector w = contact.velocities(plus(rationals(contact.problem.v), contact.change_of_velocity(p)));
  contact.add_yielding(f, w);
  for (Index c = 0; c < layout.cones; ++c) {
    const auto i = static_cast<std::size_t>(layout.cone_contact[static_cast<std::size_t>(c)]);
    Rational slack = Rational(contact.problem.mu(static_cast<Index>(i))) * f[i];
    for (Index t = layout.friction_begin[i]; t < layout.friction_begin[i + 1]; ++t) {
      const auto row = static_cast<std::size_t>(layout.friction_offset() + t);
      w[row] += z[static_cast<std::size_t>(layout.lambda_offset() + c)];
      slack -= f[row];
    }
    w.push_back(slack);
  }
  expect_complementary(z, w);
}

inline void expect_contact_contradiction(const DenseContact& contact, const RationalVector& u) {
  ASSERT_EQ(static_cast<Index>(u.size()), contact.C.cols());
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_GE(u[i], 0);
    EXPECT_TRUE(static_cast<Index>(i) < contact.layout.nc || u[i].is_zero());
    const bool yields =
        static_cast<Index>(i) < contact.layout.nc && contact.problem.normal_compliance(static_cast<Index>(i)) > 0;
    EXPECT_TRUE(!yields || u[i].is_zero());
  }
  EXPECT_TRUE(all_zero(contact.forced(u)));
  Rational work = 0;
  const RationalVector q = contact.velocities(rationals(contact.problem.v));
  for (std::size_t i = 0; i < u.size(); ++i) work += u[i] * q[i];
  EXPECT_LT(work, 0);
}

inline void expect_solvability_proof(const DenseContact& contact, const RationalVector& d) {
  const RationalVector w = contact.velocities(plus(rationals(contact.problem.v), contact.change_of_velocity(d)));
  for (std::size_t i = 0; i < contact.problem.edges.size(); ++i) {
    if (contact.problem.normal_compliance(static_cast<Index>(i)) > 0) continue;
    EXPECT_GE(w[i], 0);
    if (contact.problem.tangential_compliance(static_cast<Index>(i)) > 0 && contact.problem.edges[i] <= 4) continue;
    for (Index t = contact.layout.friction_begin[i]; t < contact.layout.friction_begin[i + 1]; ++t) {
      const Rational mu(contact.problem.mu(static_cast<Index>(i)));
      EXPECT_GE(w[i] + mu * w[static_cast<std::size_t>(contact.layout.friction_offset() + t)], 0);
    }
  }
}

inline void expect_contact_proof(const ContactProblem& problem, const Certificate& certificate) {
  const DenseContact contact(problem);
  switch (certificate.proof) {
    case ProofKind::kExactBasis: {
      const RationalVector p = rationals(certificate.exact_potential);
      expect_contact_solution(contact, rationals(certificate.exact_z), p);
      EXPECT_EQ(rationals(certificate.exact_velocity), plus(rationals(problem.v), contact.change_of_velocity(p)));
      if (certificate.velocity_unique.value_or(true)) return;
      const RationalVector other = rationals(certificate.exact_other_potential);
      expect_contact_solution(contact, rationals(certificate.exact_other_z), other);
      EXPECT_NE(contact.change_of_velocity(p), contact.change_of_velocity(other));
      return;
    }
    case ProofKind::kFarkas: return expect_contact_contradiction(contact, rationals(certificate.exact_farkas));
    case ProofKind::kLp: return expect_solvability_proof(contact, rationals(certificate.exact_farkas));
    case ProofKind::kNone: return;
  }
}

inline void expect_bare_proof(const Lcp& lcp, const Certificate& certificate) {
  if (certificate.proof == ProofKind::kExactBasis) {
    const RationalVector z = rationals(certificate.exact_z);
    expect_complementary(z, plus(rationals(lcp.q), times(lcp.M, z)));
  }
  if (certificate.proof == ProofKind::kFarkas) {
    const RationalVector y = rationals(certificate.exact_farkas);
    Rational work = 0;
    for (std::size_t i = 0; i < y.size(); ++i) {
      EXPECT_GE(y[i], 0);
      work += y[i] * Rational(lcp.q(static_cast<Index>(i)));
    }
    EXPECT_LT(work, 0);
    for (const Rational& value : transposed_times(lcp.M, y)) EXPECT_LE(value, 0);
  }
}

/// Everything that the certificate's exact vectors claim. A certificate without a proof claims nothing.
inline void expect_proof(const Problem& problem, const Certificate& certificate) {
  if (problem.contact() != nullptr) return expect_contact_proof(*problem.contact(), certificate);
  expect_bare_proof(problem.lcp(), certificate);
}

}  // namespace lcpbench::testing
