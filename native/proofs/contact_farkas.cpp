#include "native/proofs/contact_farkas.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/compliance.h"
#include "core/entries.h"
#include "core/timed_solve.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Of the scaled tableau: what counts as rounding, and what is more than any rounding.
constexpr double kNoise = 1e-11;
constexpr double kClear = 1e-7;

/// Null where G is given by its entries.
const Matrix* reach_of(const Inertia& inertia) {
  if (const auto* factored = std::get_if<FactoredInertia>(&inertia)) return &factored->X;
  const auto* inverse = std::get_if<InverseInertia>(&inertia);
  return inverse != nullptr ? &inverse->Ginv : nullptr;
}

Index factors_of(const ContactProblem& contact) {
  const Matrix* reach = reach_of(contact.inertia);
  return reach != nullptr ? reach->cols() : contact.ngc();
}

}  // namespace

bool may_be_singular(const ContactProblem& contact) { return reach_of(contact.inertia) != nullptr; }

bool may_be_unsolvable(const ContactProblem& contact) {
  if (every_contact_yields(contact)) return false;
  return may_be_singular(contact) || !(contact.b.array() >= 0).all();
}

void ContactFarkas::reserve(const ContactProblem& contact) {
  const auto rows = static_cast<std::size_t>(factors_of(contact)) + 1;
  const auto nc = static_cast<std::size_t>(contact.nc());
  normals_.reserve(nc);
  column_exponent_.reserve(nc);
  row_exponent_.reserve(rows);
  basis_.reserve(rows);
  support_.reserve(rows);
  const std::size_t room = (rows + 1) * (rows + nc + 1);
  if (room <= room_) return;
  room_ = room;
  tableau_ = std::make_unique_for_overwrite<double[]>(room);
}

void ContactFarkas::load(const ContactProblem& contact) {
  reserve(contact);
  contact_ = &contact;
  X_.reset();
  if (const Matrix* X = reach_of(contact.inertia)) X_.emplace(X->data(), X->rows(), X->cols());
  rows_ = factors_of(contact) + 1;
  normals_.clear();
  for (Index c = 0; c < contact.nc(); ++c) {
    if (!(contact.normal_compliance(c) > 0)) normals_.push_back(c);
  }
}

bool ContactFarkas::proves_unsolvable(const double* v, double deadline_s) {
  if (normals_.empty() || !(wall_clock_s() < deadline_s)) return false;
  fill();
  if (!pivot_to_end(deadline_s) || costs()[right()] < -kClear) return false;  // no u at all
  drop_artificial();
  start_second_phase(v);
  // The least value is negative, or zero to rounding: the exact proof decides.
  return pivot_to_end(deadline_s) && costs()[right()] > -kNoise && take_support() &&
         farkas_support_.proves_unsolvable(*contact_, X_ ? &*X_ : nullptr, v, support_);
}

/// The columns of X'N, scaled, with an artificial variable for each row as the basis.
void ContactFarkas::fill() {
  const Index size = rows_ - 1;
  std::fill_n(tableau_.get(), (rows_ + 1) * width(), 0.0);
  row_exponent_.clear();
  for (Index k = 0; k < size; ++k) {
    const double largest = X_ && X_->rows() > 0 ? X_->col(k).cwiseAbs().maxCoeff() : 1.0;
    row_exponent_.push_back(largest > 0 ? -exponent_of(largest) : 0);
  }
  column_exponent_.clear();
  for (Index j = 0; j < count(); ++j) {
    const Index contact = normals_[static_cast<std::size_t>(j)];
    for_each_entry(contact_->N, contact, [&](Index i, double entry) {
      if (!X_) row(i)[j] = entry;
      for (Index k = 0; k < size && X_; ++k) {
        row(k)[j] += entry * scaled((*X_)(i, k), row_exponent_[static_cast<std::size_t>(k)]);
      }
    });
    double largest = 0;
    for (Index k = 0; k < size; ++k) largest = std::max(largest, std::abs(row(k)[j]));
    const int exponent = largest > 0 ? -exponent_of(largest) : 0;
    column_exponent_.push_back(exponent);
    for (Index k = 0; k < size; ++k) row(k)[j] = scaled(row(k)[j], exponent);
    row(size)[j] = 1;
  }
  row(size)[right()] = 1;
  basis_.clear();
  for (Index r = 0; r < rows_; ++r) {
    row(r)[count() + r] = 1;
    basis_.push_back(count() + r);
  }
  for (Index r = 0; r < rows_; ++r) {
    for (Index j = 0; j < count(); ++j) costs()[j] -= row(r)[j];
  }
  costs()[right()] = -1;
}

/// The reduced costs of (N'v + b)'u, scaled.
void ContactFarkas::start_second_phase(const double* v) {
  std::fill_n(costs(), width(), 0.0);
  double largest = 0;
  for (Index j = 0; j < count(); ++j) {
    const Index contact = normals_[static_cast<std::size_t>(j)];
    const int exponent = column_exponent_[static_cast<std::size_t>(j)];
    double& cost = costs()[j];
    cost = scaled(contact_->offset(contact), exponent);
    double terms = std::abs(cost);
    for_each_entry(contact_->N, contact, [&](Index i, double entry) {
      const double term = scaled(entry * v[i], exponent);
      cost += term;
      terms += std::abs(term);
    });
    largest = std::max(largest, terms);
  }
  const int exponent = largest > 0 ? -exponent_of(largest) : 0;
  for (Index j = 0; j < count(); ++j) costs()[j] = scaled(costs()[j], exponent);
  for (Index r = 0; r < rows_; ++r) {
    const Index basic = basis_[static_cast<std::size_t>(r)];
    const double factor = basic < count() ? costs()[basic] : 0;
    if (factor == 0) continue;
    for (Index j = 0; j < width(); ++j) costs()[j] -= factor * row(r)[j];
    costs()[basic] = 0;
  }
}

/// Pivots until no reduced cost is negative. Almost all vertices are degenerate: after the usual number of pivots by
/// Dantzig's rule, Bland's rule takes over, which cannot cycle. @returns whether it came to an end
bool ContactFarkas::pivot_to_end(double deadline_s) {
  const Index usual = 4 * (rows_ + count());
  for (Index pivots = 0; pivots < 8 * usual; ++pivots) {
    if (pivots % 16 == 15 && !(wall_clock_s() < deadline_s)) return false;
    const bool by_number = pivots >= usual;
    const double* const reduced = costs();
    Index entering = -1;
    for (Index j = 0; j < count(); ++j) {
      if (!std::isfinite(reduced[j])) return false;
      if (reduced[j] >= -kNoise) continue;
      if (entering < 0 || (!by_number && reduced[j] < reduced[entering])) entering = j;
    }
    if (entering < 0) return true;
    Index leaving = -1;
    double least = 0;
    for (Index r = 0; r < rows_; ++r) {
      const double pivot = row(r)[entering];
      if (!(pivot > kNoise)) continue;
      const double ratio = row(r)[right()] <= kNoise ? 0.0 : row(r)[right()] / pivot;
      const auto number = [&](Index of_row) { return basis_[static_cast<std::size_t>(of_row)]; };
      const bool wins_tie =
          leaving >= 0 && ratio == least && (by_number ? number(r) < number(leaving) : pivot > row(leaving)[entering]);
      if (leaving >= 0 && !(ratio < least) && !wins_tie) continue;
      leaving = r;
      least = ratio;
    }
    if (leaving < 0) return false;  // but for rounding, sum u = 1 bounds all
    exchange(leaving, entering);
  }
  return false;
}

/// Artificial variables that are zero leave the basis where their row is not zero as well.
void ContactFarkas::drop_artificial() {
  for (Index r = 0; r < rows_; ++r) {
    if (basis_[static_cast<std::size_t>(r)] < count()) continue;
    const double* const entries = row(r);
    const double* const largest =
        std::max_element(entries, entries + count(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    if (!(std::abs(*largest) > kClear)) continue;
    row(r)[right()] = 0;
    exchange(r, largest - entries);
  }
}

void ContactFarkas::exchange(Index leaving, Index entering) {
  double* const pivot_row = row(leaving);
  const double inverse = 1 / pivot_row[entering];
  for (Index j = 0; j < width(); ++j) pivot_row[j] *= inverse;
  pivot_row[entering] = 1;
  for (Index i = 0; i <= rows_; ++i) {
    double* const other = row(i);
    const double factor = other[entering];
    if (i == leaving || factor == 0) continue;
    for (Index j = 0; j < width(); ++j) other[j] -= factor * pivot_row[j];
    other[entering] = 0;
  }
  basis_[static_cast<std::size_t>(leaving)] = entering;
}

/// support_ := the contacts whose u, as the last basis gives it, is more than rounding. @returns whether there are any
bool ContactFarkas::take_support() {
  support_.clear();
  for (Index r = 0; r < rows_; ++r) {
    const Index j = basis_[static_cast<std::size_t>(r)];
    if (j < count() && row(r)[right()] > kNoise) support_.push_back(normals_[static_cast<std::size_t>(j)]);
  }
  return !support_.empty();
}

}  // namespace lcpbench
