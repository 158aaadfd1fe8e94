#include "study/evaluation/contact_lcp.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lcpbench {
namespace {

std::size_t count_nonzeros(const Jacobian& J) {
  const auto* const dense = std::get_if<Matrix>(&J);
  return static_cast<std::size_t>(dense != nullptr ? (dense->array() != 0).count()
                                                   : std::get<SparseMatrix>(J).nonZeros());
}

/// Whether column j is the negative of column i, entry by entry.
bool are_opposite(const Jacobian& J, Index i, Index j) {
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    const double* const a = dense->col(i).data();
    const double* const b = dense->col(j).data();
    return std::equal(a, a + dense->rows(), b, [](double x, double y) { return x == -y; });
  }
  SparseMatrix::InnerIterator a(std::get<SparseMatrix>(J), i), b(std::get<SparseMatrix>(J), j);
  while (a && b && a.row() == b.row() && a.value() == -b.value()) {
    ++a;
    ++b;
  }
  return !a && !b;
}

bool is_same(const Bounded& a, const Bounded& b) {
  return a.exact() && b.exact() && a.high == b.high && a.low == b.low;
}
bool is_same(Quad a, Quad b) { return a == b; }

/// Whether its error bound leaves its sign open.
bool is_lost_in_rounding(const Bounded& x) { return !x.exact() && !(std::abs(x.high) > 8 * x.error); }

}  // namespace

template <class Real>
ContactLcp<Real>::ContactLcp(const ContactProblem& problem, const Inertia& inertia, std::pmr::memory_resource* memory)
    : inertia_(inertia),
      v_(problem.v.begin(), problem.v.end()),
      b_(problem.b.begin(), problem.b.end()),
      contacts_(static_cast<std::size_t>(problem.nc())),
      layout_(contact_layout(problem)),
      begin_(1, 0, memory),
      rows_(memory),
      values_(memory),
      twin_(memory),
      sizes_(memory),
      mu_(memory),
      normal_of_cone_(memory),
      friction_of_cone_(memory),
      lambda_of_(memory) {
  for (const double v : problem.v) {
    if (!(std::abs(v) <= largest_speed_)) largest_speed_ = std::isnan(v) ? INFINITY : std::abs(v);
  }
  add_columns(problem);
  list_cones(problem, layout_);
  if (problem.is_soft()) soften(problem);

  q_.reserve(impulses() + normal_of_cone_.size());
  for (std::size_t i = 0; i < impulses(); ++i) {
    q_.push_back(is_twin(i) ? -q_[twin_[i]] : sum_of(i, v_) + offset(i));
  }
  q_.resize(impulses() + normal_of_cone_.size(), 0);
}

template <class Real>
void ContactLcp<Real>::soften(const ContactProblem& problem) {
  soft_.emplace(problem, layout_);
  if (problem.offset_t.size() == 0) return;
  b_.resize(impulses(), 0);
  for (std::size_t i = contacts_; i < impulses(); ++i) {
    const auto [contact, direction] = friction_of_row(i);
    b_[i] = soft_->along(contact, direction, soft_->offset(contact));
  }
}

/// The contact of a friction row, and its number among the contact's directions.
template <class Real>
std::pair<Index, Index> ContactLcp<Real>::friction_of_row(std::size_t i) const {
  const std::size_t cone = lambda_of_[i] - impulses();
  return {layout_.cone_contact[cone], static_cast<Index>(i - friction_of_cone_[cone])};
}

template <class Real>
Real ContactLcp<Real>::yielding(std::size_t i, const RealVector& z) const {
  if (i < contacts_) return soft_->normal(static_cast<Index>(i)) * z[i];
  const auto [contact, direction] = friction_of_row(i);
  const auto impulse = [&](Index j) { return z[static_cast<std::size_t>(j)]; };
  return soft_->along(contact, direction, soft_->yielding(contact, impulse));
}

/// A direction of friction is compared with the one that the problem says to be its negative.
template <class Real>
void ContactLcp<Real>::add_columns(const ContactProblem& problem) {
  const auto columns = static_cast<std::size_t>(problem.nc() + cols(problem.D));
  const std::size_t nonzeros = count_nonzeros(problem.N) + count_nonzeros(problem.D);
  begin_.reserve(columns + 1);
  twin_.reserve(columns);
  sizes_.reserve(columns);
  rows_.resize(nonzeros);
  values_.resize(nonzeros);
  for (Index j = 0; j < cols(problem.N); ++j) add_column(problem.N, j);
  Index direction = 0;
  for (const int edges : problem.edges) {
    const Index half = edges / 2;
    for (Index j = direction; j < direction + edges; ++j) {
      if (j >= direction + half && are_opposite(problem.D, j - half, j)) {
        add_twin(contacts_ + static_cast<std::size_t>(j - half));
      } else {
        add_column(problem.D, j);
      }
    }
    direction += edges;
  }
}

template <class Real>
void ContactLcp<Real>::add_column(const Jacobian& J, Index column) {
  std::size_t end = begin_.back();
  std::size_t* const rows = rows_.data();
  double* const values = values_.data();
  double size = 0;
  const auto append = [&](Index row, double value) {
    if (value == 0) return;
    rows[end] = static_cast<std::size_t>(row);
    values[end++] = value;
    size += std::abs(value);
  };
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    const double* const entries = dense->col(column).data();
    for (Index i = 0; i < dense->rows(); ++i) append(i, entries[i]);
  } else {
    for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(J), column); entry; ++entry) {
      append(entry.row(), entry.value());
    }
  }
  twin_.push_back(begin_.size() - 1);
  begin_.push_back(end);
  sizes_.push_back(size);
}

template <class Real>
void ContactLcp<Real>::add_twin(std::size_t of) {
  twin_.push_back(of);
  begin_.push_back(begin_.back());
  sizes_.push_back(sizes_[of]);
}

template <class Real>
void ContactLcp<Real>::list_cones(const ContactProblem& problem, const ContactLayout& layout) {
  const std::size_t lambda = impulses();
  lambda_of_.resize(impulses(), 0);
  mu_.reserve(layout.cone_contact.size());
  normal_of_cone_.reserve(layout.cone_contact.size());
  friction_of_cone_.reserve(layout.cone_contact.size() + 1);
  friction_of_cone_.push_back(contacts_);
  for (const Index contact : layout.cone_contact) {
    const std::size_t cone = normal_of_cone_.size();
    const std::size_t end =
        contacts_ + static_cast<std::size_t>(layout.friction_begin[static_cast<std::size_t>(contact) + 1]);
    std::fill(lambda_of_.begin() + static_cast<std::ptrdiff_t>(friction_of_cone_.back()),
              lambda_of_.begin() + static_cast<std::ptrdiff_t>(end), lambda + cone);
    friction_of_cone_.push_back(end);
    normal_of_cone_.push_back(static_cast<std::size_t>(contact));
    mu_.push_back(problem.mu(contact));
  }
}

template <class Real>
Real ContactLcp<Real>::sum_of(std::size_t i, const RealVector& x) const {
  const Entries of = entries(i);
  if constexpr (std::is_same_v<Real, Bounded>) {
    static const BoundedDot dot = bounded_dot_of_level();
    const Bounded sum = dot(of.values, of.rows, of.count, x.data());
    if (!is_lost_in_rounding(sum)) return sum;
    return exact_dot(of.values, of.rows, of.count, x.data()).value_or(sum);
  } else {
    Real sum = 0;
    for (std::size_t e = 0; e < of.count; ++e) sum += of.values[e] * x[of.rows[e]];
    return sum;
  }
}

template <class Real>
Real ContactLcp<Real>::project(std::size_t i, const RealVector& x) const {
  const Real sum = sum_of(i, x);
  return is_twin(i) ? -sum : sum;
}

/// The sum of the magnitudes of the terms of offset(i).
template <class Real>
Real ContactLcp<Real>::offset_size(std::size_t i) const {
  if (!soft_ || i < contacts_) return abs(offset(i));
  const auto [contact, direction] = friction_of_row(i);
  const auto of = soft_->offset(contact);
  const Real zero(0.0);
  return abs(soft_->along(contact, direction, {of[0], zero})) + abs(soft_->along(contact, direction, {zero, of[1]}));
}

/// How many terms q_i has in the rigid equivalent beside those of J_i'v.
template <class Real>
std::size_t ContactLcp<Real>::offset_terms(std::size_t i) const {
  if (i >= contacts_) {
    if (!soft_) return 0;
    const auto [contact, direction] = friction_of_row(i);
    return static_cast<std::size_t>(soft_->terms(contact, direction));
  }
  const bool yields = soft_ && !surely_equal(soft_->normal(static_cast<Index>(i)), 0);
  return (surely_equal(offset(i), 0) ? 0U : 1U) + (yields ? 1U : 0U);
}

template <class Real>
double ContactLcp<Real>::formation_limit(std::size_t i) const {
  if (i >= impulses()) return 0;
  const double magnitude = sizes_[i] * largest_speed_ + to_double(offset_size(i));
  return static_cast<double>(entries(i).count + 4) * (0x1p-53 * magnitude * (1 + 0x1p-20) + bounded::kLost);
}

template <class Real>
Real ContactLcp<Real>::formation_error(std::size_t i) const {
  if (i >= impulses()) return 0;
  const Entries of = entries(i);
  const std::size_t terms = of.count + offset_terms(i);
  using Number = decltype(leading(Real{}));
  using std::abs, lcpbench::abs;
  Number magnitude = leading(offset_size(i));
  for (std::size_t e = 0; e < of.count; ++e) magnitude += abs(of.values[e] * leading(v_[of.rows[e]]));
  const Number error = static_cast<double>(terms + 1) * (0x1p-53 * magnitude + 0x1p-1074);
  if constexpr (std::is_same_v<Real, Bounded>) {
    return {error, 0, 2 * static_cast<double>(terms + 4) * bounded::kRoundoff * error + bounded::kLost};
  } else {
    return error;
  }
}

template <class Real>
bool ContactLcp<Real>::at_rest(const RealVector& z) const {
  return std::all_of(z.begin(), z.begin() + static_cast<std::ptrdiff_t>(impulses()),
                     [](const Real& impulse) { return surely_equal(impulse, 0); });
}

template <class Real>
std::vector<Real> ContactLcp<Real>::generalized_impulse(const RealVector& z) const {
  RealVector impulse(v_.size(), 0);
  for (std::size_t j = 0; j < impulses(); ++j) {
    if (surely_equal(z[j], 0)) continue;
    const Entries of = entries(j);
    const Real factor = is_twin(j) ? -z[j] : z[j];
    for (std::size_t e = 0; e < of.count; ++e) impulse[of.rows[e]] += of.values[e] * factor;
  }
  return impulse;
}

template <class Real>
std::vector<Real> ContactLcp<Real>::generalized_impulse_scale(const RealVector& z) const {
  RealVector scale(v_.size(), 0);
  for (std::size_t j = 0; j < impulses(); ++j) {
    if (surely_equal(z[j], 0)) continue;
    const Entries of = entries(j);
    for (std::size_t e = 0; e < of.count; ++e) scale[of.rows[e]] += abs(of.values[e] * z[j]);
  }
  return scale;
}

template <class Real>
std::vector<Real> ContactLcp<Real>::response(const RealVector& z) const {
  if (at_rest(z)) return v_;
  RealVector u = generalized_impulse(z);
  inertia_.solve(u);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += v_[i];
  return u;
}

template <class Real>
Real ContactLcp<Real>::cone_row(std::size_t cone, const RealVector& z) const {
  Real slack = mu_[cone] * z[normal_of_cone_[cone]];
  for (std::size_t t = friction_of_cone_[cone]; t < friction_of_cone_[cone + 1]; ++t) {
    if (!surely_equal(z[t], 0)) slack -= z[t];
  }
  return slack;
}

template <class Real>
Real ContactLcp<Real>::row(std::size_t i, const RealVector& z, const RealVector& u) const {
  if (i >= impulses()) return cone_row(i - impulses(), z);
  Real velocity = project(i, u) + offset(i);
  if (soft_) velocity += yielding(i, z);
  return i < contacts_ ? velocity : velocity + z[lambda_of_[i]];
}

template <class Real>
std::vector<Real> ContactLcp<Real>::all_rows(const RealVector& z, const RealVector& u) const {
  const bool at_q =
      std::equal(u.begin(), u.end(), v_.begin(), [](const Real& a, const Real& b) { return is_same(a, b); });
  RealVector w(size());
  for (std::size_t i = 0; i < size(); ++i) {
    if (i >= impulses()) {
      w[i] = cone_row(i - impulses(), z);
    } else if (at_q) {
      w[i] = q_[i];
    } else {
      w[i] = is_twin(i) ? -w[twin_[i]] : sum_of(i, u) + offset(i);
    }
  }
  for (std::size_t i = 0; soft_ && i < impulses(); ++i) w[i] += yielding(i, z);
  for (std::size_t i = contacts_; i < impulses(); ++i) w[i] += z[lambda_of_[i]];
  return w;
}

template <class Real>
Real ContactLcp<Real>::diagonal(std::size_t i) {
  if (i >= impulses()) return 0;
  diagonals_.resize(impulses());
  scratch_.resize(v_.size(), 0);
  std::optional<Real>& diagonal = diagonals_[twin_[i]];
  if (diagonal) return *diagonal;
  const Entries of = entries(i);
  for (std::size_t e = 0; e < of.count; ++e) scratch_[of.rows[e]] = of.values[e];
  std::vector<std::size_t> pattern(of.rows, of.rows + of.count);
  inertia_.solve(scratch_, pattern);
  diagonal = sum_of(i, scratch_);
  if (soft_ && i < contacts_) *diagonal += soft_->normal(static_cast<Index>(i));
  if (soft_ && i >= contacts_) {
    const auto [contact, direction] = friction_of_row(i);
    *diagonal += soft_->diagonal(contact, direction);
  }
  for (const std::size_t row : pattern) scratch_[row] = 0;
  return *diagonal;
}

template class ContactLcp<Quad>;
template class ContactLcp<Bounded>;

}  // namespace lcpbench
