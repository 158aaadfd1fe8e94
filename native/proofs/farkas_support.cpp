#include "native/proofs/farkas_support.h"

#include <algorithm>
#include <cmath>

#include "core/entries.h"
#include "core/quad_matrix.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Normals above which nothing is tried: a system of so many equations takes a tenth of a second.
constexpr Index kMostNormals = 64;
/// What rounding leaves of a sum that is zero, relative to its terms and for each of the normals.
constexpr double kNoise = 0x1p-106;
/// A pivot that is less, relative to the entries of its row, may be rounding.
constexpr double kGap = 0x1p-80;
/// Integers in the same proportion as u are looked for up to the first; the second is relative.
constexpr double kLargestInteger = 0x1p20;
constexpr Quad kNearInteger = 0x1p-40;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

/// A = X'N of the normals, without the rows that are zero, each scaled to terms of about one.
QuadMatrix reached(const ContactProblem& contact, const FarkasSupport::ConstMatrixMap* X,
                   const std::vector<Index>& normals) {
  const Index rows = X != nullptr ? X->cols() : contact.ngc();
  QuadMatrix A(at(rows), normals.size());
  QuadVector terms(at(rows), 0);
  const auto add = [&](Index k, std::size_t j, Quad term) {
    A(at(k), j) += term;
    terms[at(k)] = std::max(terms[at(k)], abs(term));
  };
  for (std::size_t j = 0; j < normals.size(); ++j) {
    for_each_entry(contact.N, normals[j], [&](Index i, double entry) {
      if (X == nullptr) return add(i, j, entry);
      for (Index k = 0; k < rows; ++k) add(k, j, Quad{entry} * Quad{(*X)(i, k)});
    });
  }
  QuadMatrix scaled_rows(0, normals.size());
  for (std::size_t k = 0; k < A.rows; ++k) {
    if (terms[k] == 0) continue;
    ++scaled_rows.rows;
    for (std::size_t j = 0; j < A.cols; ++j) scaled_rows.entries.push_back(A(k, j) / terms[k]);
  }
  return scaled_rows;
}

/// u with A u = 0 and sum u = 1, where only one is, up to rounding; empty where there is none or more.
QuadVector null_vector(QuadMatrix A) {
  const std::size_t n = A.cols;
  std::vector<std::size_t> order(n);  // of the unknowns: those that were eliminated first
  for (std::size_t j = 0; j < n; ++j) order[j] = j;
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t row = step, column = step;
    Quad largest = 0;
    for (std::size_t i = step; i < A.rows; ++i) {
      for (std::size_t j = step; j < n; ++j) {
        if (!(abs(A(i, order[j])) > largest)) continue;
        largest = abs(A(i, order[j]));
        row = i;
        column = j;
      }
    }
    if (step + 1 == n) {
      if (largest > Quad{kNoise * static_cast<double>(n)}) return {};
      break;
    }
    if (!(largest > Quad{kGap})) return {};
    std::swap(order[step], order[column]);
    for (std::size_t j = 0; j < n; ++j) std::swap(A(step, j), A(row, j));
    for (std::size_t i = step + 1; i < A.rows; ++i) {
      const Quad factor = A(i, order[step]) / A(step, order[step]);
      if (factor == 0) continue;
      for (std::size_t j = step; j < n; ++j) A(i, order[j]) -= factor * A(step, order[j]);
    }
  }
  QuadVector u(n, 0);
  u[order[n - 1]] = 1;
  Quad sum = 1;
  for (std::size_t step = n - 1; step-- > 0;) {
    Quad right = 0;
    for (std::size_t j = step + 1; j < n; ++j) right -= A(step, order[j]) * u[order[j]];
    u[order[step]] = right / A(step, order[step]);
    sum += u[order[step]];
  }
  for (Quad& share : u) share /= sum;
  return u;
}

}  // namespace

bool FarkasSupport::proves_unsolvable(const ContactProblem& contact, const ConstMatrixMap* X, const double* v,
                                      const std::vector<Index>& normals) {
  const auto order = static_cast<Index>(normals.size());
  if (order == 0 || order > kMostNormals) return false;
  const QuadVector u = null_vector(reached(contact, X, normals));
  if (u.empty()) return false;
  Quad approach = 0, terms = 0;
  const auto add = [&](Quad term) {
    approach += term;
    terms += abs(term);
  };
  for (std::size_t j = 0; j < u.size(); ++j) {
    if (!(u[j] > 0)) return false;
    add(Quad{contact.offset(normals[j])} * u[j]);
    for_each_entry(contact.N, normals[j], [&](Index i, double entry) { add(Quad{entry} * Quad{v[i]} * u[j]); });
  }
  if (!(approach < -Quad{kNoise * static_cast<double>(order)} * terms)) return false;
  normals_ = normals;
  ratios_.clear();
  const Quad least = *std::min_element(u.begin(), u.end());
  for (const Quad share : u) ratios_.push_back(share / least);
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
