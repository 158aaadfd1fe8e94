#include "native/proofs/farkas_support.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/entries.h"
#include "core/exact_matrix.h"

namespace lcpbench {
namespace {

/// Normals above which nothing is tried: a system of so many equations takes a tenth of a second.
constexpr Index kMostNormals = 64;
/// Integers in the same proportion as u are looked for up to the first; the second is relative.
constexpr double kLargestInteger = 0x1p20;
constexpr Quad kNearInteger = 0x1p-40;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// A', a row for each normal.
ExactMatrix reached(const ContactProblem& contact, const FarkasSupport::ConstMatrixMap* X,
                    const std::vector<Index>& normals) {
  ExactMatrix A(static_cast<Index>(normals.size()), X != nullptr ? X->cols() : contact.ngc());
  for (Index j = 0; j < A.rows; ++j) {
    for_each_entry(contact.N, normals[at(j)], [&](Index i, double entry) {
      if (X == nullptr) A(j, i) = Dyadic(entry);
      for (Index k = 0; X != nullptr && k < A.cols; ++k) {
        if ((*X)(i, k) != 0) A(j, k) += Dyadic(entry) * Dyadic((*X)(i, k));
      }
    });
  }
  return A;
}

}  // namespace

bool FarkasSupport::proves_unsolvable(const ContactProblem& contact, const ConstMatrixMap* X, const double* v,
                                      const std::vector<Index>& normals) {
  const auto order = static_cast<Index>(normals.size());
  if (order == 0 || order > kMostNormals) return false;
  const ExactMatrix A = reached(contact, X, normals);
  const std::optional<std::vector<Index>> rows = independent_columns(A);
  if (!rows || static_cast<Index>(rows->size()) + 1 != order) return false;
  ExactMatrix system(order, order);
  std::vector<Dyadic> right(at(order));
  for (Index j = 0; j < order; ++j) {
    for (Index r = 0; r + 1 < order; ++r) system(r, j) = A(j, (*rows)[at(r)]);
    system(order - 1, j) = Dyadic(1.0);
  }
  right.back() = Dyadic(1.0);
  const std::optional<ExactSolution> u = solve_exactly(system, right);
  if (!u || u->denominator.is_zero()) return false;
  Dyadic approach;
  const Dyadic* least = &u->numerators.front();
  for (Index j = 0; j < order; ++j) {
    const Dyadic& share = u->numerators[at(j)];
    if (share.sign() <= 0) return false;
    if (share < *least) least = &share;
    Dyadic q(contact.offset(normals[at(j)]));
    for_each_entry(contact.N, normals[at(j)], [&](Index i, double entry) { q += Dyadic(entry) * Dyadic(v[i]); });
    approach += q * share;
  }
  if (approach.sign() >= 0) return false;
  normals_ = normals;
  ratios_.clear();
  for (const Dyadic& share : u->numerators) ratios_.push_back(quotient(share, *least));
  return true;
}

void FarkasSupport::write_proof(Eigen::Ref<Vector> u) const {
  u.setZero();
  for (std::size_t j = 0; j < normals_.size(); ++j) {
    const double near = std::round(to_double(ratios_[j]));
    const bool is_integer =
        near <= kLargestInteger && abs(ratios_[j] - static_cast<Quad>(near)) <= kNearInteger * ratios_[j];
    u(normals_[j]) = is_integer ? near : to_double(ratios_[j]);
  }
}

}  // namespace lcpbench
