#include "study/evaluation/quad_lcp.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace lcpbench {
namespace {

std::size_t count_nonzeros(const Jacobian& J) {
  const auto* const dense = std::get_if<Matrix>(&J);
  return static_cast<std::size_t>(dense != nullptr ? (dense->array() != 0).count()
                                                   : std::get<SparseMatrix>(J).nonZeros());
}

bool is_same(const Bounded& a, const Bounded& b) {
  return a.exact() && b.exact() && a.high == b.high && a.low == b.low;
}
bool is_same(Quad a, Quad b) { return a == b; }

template <class Real>
std::vector<double> rounded(const std::vector<Real>& x) {
  std::vector<double> doubles(x.size());
  std::transform(x.begin(), x.end(), doubles.begin(), [](const Real& value) { return to_double(value); });
  return doubles;
}

}  // namespace

template <class Real>
void EvaluatedLcp<Real>::fill_rows(std::span<const std::size_t> rows, const std::vector<Real>& z,
                                   const std::vector<Real>& u, std::vector<Real>& w) const {
  for (const std::size_t i : rows) w[i] = row(i, z, u);
}

template <class Real>
std::vector<Real> EvaluatedLcp<Real>::all_rows(const std::vector<Real>& z, const std::vector<Real>& u) const {
  std::vector<std::size_t> rows(size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  std::vector<Real> w(size());
  fill_rows(rows, z, u, w);
  return w;
}

template <class Real>
const MagnitudeEstimate::Row* EvaluatedLcp<Real>::estimated_row(std::size_t i) {
  if (estimate_.rows.empty()) {
    estimate_.rows.resize(size());
    estimate_.column_scale.reserve(size());
    for (std::size_t j = 0; j < size(); ++j) estimate_.column_scale.push_back(column_scale(j));
  }
  const std::size_t representing = representative(i);
  MagnitudeEstimate::Row& row = estimate_.rows[representing];
  if (row.known) return &row;
  if (estimate_.entries.size() > kLargestEstimate) return nullptr;
  row.begin = estimate_.entries.size();
  fill_row(representing, row, estimate_);
  row.end = estimate_.entries.size();
  row.known = true;
  return &row;
}

BareQuadLcp::BareQuadLcp(const Lcp& lcp) : lcp_(lcp) { q_.assign(lcp.q.begin(), lcp.q.end()); }

QuadVector BareQuadLcp::response(const QuadVector& z) {
  QuadVector w = q_;
  for (std::size_t j = 0; j < size(); ++j) remove(j, -z[j], w);
  return w;
}

void BareQuadLcp::respond(std::span<const std::size_t> rows, const QuadVector& z, QuadVector& u) {
  for (const std::size_t i : rows) {
    u[i] = q_[i];
    for (const std::size_t j : rows) {
      if (z[j] != 0) u[i] -= M(i, j) * -z[j];
    }
  }
}

void BareQuadLcp::remove(std::size_t j, Quad value, QuadVector& u) {
  if (value == 0) return;
  for (std::size_t i = 0; i < size(); ++i) u[i] -= M(i, j) * value;
}

Quad BareQuadLcp::row(std::size_t i, const QuadVector&, const QuadVector& u) const { return u[i]; }

Quad BareQuadLcp::diagonal(std::size_t i) { return M(i, i); }

Quad BareQuadLcp::abs_row_times(std::size_t i, const QuadVector& z, std::span<const std::size_t> support) {
  Quad sum = 0;
  for (const std::size_t j : support) sum += abs(M(i, j) * z[j]);
  return sum;
}

Quad BareQuadLcp::abs_row_sum(std::size_t i) {
  Quad sum = 0;
  for (std::size_t j = 0; j < size(); ++j) sum += abs(Quad{M(i, j)});
  return sum;
}

std::vector<double> BareQuadLcp::estimate_w(const QuadVector&, const QuadVector& u,
                                            std::span<const std::size_t> rows) const {
  std::vector<double> w(size(), 0.0);
  for (const std::size_t i : rows) w[i] = to_double(u[i]);
  return w;
}

void BareQuadLcp::fill_row(std::size_t i, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) {
  for (std::size_t j = 0; j < size(); ++j) {
    if (M(i, j) == 0) continue;
    estimate.add(j, std::abs(M(i, j)));
    row.sum += std::abs(M(i, j));
  }
  row.diagonal = M(i, i);
}

template <class Real>
ContactLcp<Real>::ContactLcp(const ContactProblem& problem, const Inertia& inertia)
    : inertia_(inertia),
      v_(problem.v.begin(), problem.v.end()),
      b_(problem.b.begin(), problem.b.end()),
      contacts_(static_cast<std::size_t>(problem.nc())) {
  const ContactLayout layout = contact_layout(problem);
  begin_.reserve(static_cast<std::size_t>(layout.lambda_offset()) + 1);
  const std::size_t nonzeros = count_nonzeros(problem.N) + count_nonzeros(problem.D);
  rows_.resize(nonzeros);
  values_.resize(nonzeros);
  for (const Jacobian* const J : {&problem.N, &problem.D}) {
    for (Index j = 0; j < cols(*J); ++j) add_column(*J, j);
  }
  list_cones(problem, layout);
  find_opposite_columns();

  q_.assign(impulses() + normal_of_cone_.size(), 0);
  for (std::size_t i = 0; i < impulses(); ++i) q_[i] = twin_[i] == i ? project(i, v_) + offset(i) : -q_[twin_[i]];
}

template <class Real>
void ContactLcp<Real>::add_column(const Jacobian& J, Index column) {
  std::size_t end = begin_.back();
  std::size_t* const rows = rows_.data();
  double* const values = values_.data();
  const auto append = [&](Index row, double value) {
    if (value == 0) return;
    rows[end] = static_cast<std::size_t>(row);
    values[end++] = value;
  };
  if (const auto* dense = std::get_if<Matrix>(&J)) {
    const double* const entries = dense->col(column).data();
    for (Index i = 0; i < dense->rows(); ++i) append(i, entries[i]);
  } else {
    for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(J), column); entry; ++entry) {
      append(entry.row(), entry.value());
    }
  }
  begin_.push_back(end);
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
bool ContactLcp<Real>::opposite(std::size_t i, std::size_t j) const {
  const std::size_t count = begin_[i + 1] - begin_[i];
  if (begin_[j + 1] - begin_[j] != count) return false;
  for (std::size_t e = 0; e < count; ++e) {
    if (rows_[begin_[i] + e] != rows_[begin_[j] + e] || !(values_[begin_[i] + e] == -values_[begin_[j] + e])) {
      return false;
    }
  }
  return true;
}

template <class Real>
void ContactLcp<Real>::find_opposite_columns() {
  twin_.resize(impulses());
  represented_.assign(impulses(), 1);
  for (std::size_t i = 0; i < impulses(); ++i) twin_[i] = i;
  for (std::size_t cone = 0; cone < normal_of_cone_.size(); ++cone) {
    const std::size_t half = (friction_of_cone_[cone + 1] - friction_of_cone_[cone]) / 2;
    for (std::size_t i = friction_of_cone_[cone] + half; i < friction_of_cone_[cone + 1]; ++i) {
      if (!opposite(i, i - half)) continue;
      twin_[i] = i - half;
      represented_[i - half] = 2;
    }
  }
}

template <class Real>
void ContactLcp<Real>::list_columns_of_rows() {
  row_begin_.assign(v_.size() + 1, 0);
  for (std::size_t j = 0; j < impulses(); ++j) {
    if (twin_[j] != j) continue;
    for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) ++row_begin_[rows_[e] + 1];
  }
  for (std::size_t row = 0; row < v_.size(); ++row) row_begin_[row + 1] += row_begin_[row];
  columns_of_row_.resize(row_begin_.back());
  std::vector<std::size_t> next = row_begin_;
  for (std::size_t j = 0; j < impulses(); ++j) {
    if (twin_[j] != j) continue;
    for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) columns_of_row_[next[rows_[e]]++] = j;
  }
  visited_.assign(impulses(), 0);
}

template <class Real>
Real ContactLcp<Real>::project(std::size_t i, const RealVector& x) const {
  if constexpr (std::is_same_v<Real, Bounded>) {
    static const BoundedDot dot = bounded_dot_of_level();
    return dot(values_.data() + begin_[i], rows_.data() + begin_[i], begin_[i + 1] - begin_[i], x.data());
  } else {
    Real sum = 0;
    for (std::size_t e = begin_[i]; e < begin_[i + 1]; ++e) sum += values_[e] * x[rows_[e]];
    return sum;
  }
}

template <class Real>
Real ContactLcp<Real>::formation_error(std::size_t i) const {
  if (i >= impulses()) return 0;
  const std::size_t terms = begin_[i + 1] - begin_[i] + (surely_equal(offset(i), 0) ? 0 : 1);
  using Number = decltype(leading(Real{}));
  using std::abs, lcpbench::abs;
  Number magnitude = abs(leading(offset(i)));
  for (std::size_t e = begin_[i]; e < begin_[i + 1]; ++e) magnitude += abs(values_[e] * leading(v_[rows_[e]]));
  const Number error = static_cast<double>(terms + 1) * (0x1p-53 * magnitude + 0x1p-1074);
  if constexpr (std::is_same_v<Real, Bounded>) {
    return {error, 0, 2 * static_cast<double>(terms + 4) * bounded::kRoundoff * error + bounded::kLost};
  } else {
    return error;
  }
}

template <class Real>
std::vector<Real> ContactLcp<Real>::generalized_impulse(const RealVector& z) const {
  RealVector impulse(v_.size(), 0);
  for (std::size_t j = 0; j < impulses(); ++j) {
    if (surely_equal(z[j], 0)) continue;
    for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) impulse[rows_[e]] += values_[e] * z[j];
  }
  return impulse;
}

template <class Real>
std::vector<Real> ContactLcp<Real>::generalized_impulse_scale(const RealVector& z) const {
  RealVector scale(v_.size(), 0);
  for (std::size_t j = 0; j < impulses(); ++j) {
    if (surely_equal(z[j], 0)) continue;
    for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) scale[rows_[e]] += abs(values_[e] * z[j]);
  }
  return scale;
}

template <class Real>
std::vector<Real> ContactLcp<Real>::response(const RealVector& z) {
  RealVector u = generalized_impulse(z);
  inertia_.solve(u);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += v_[i];
  return u;
}

template <class Real>
void ContactLcp<Real>::respond(std::span<const std::size_t> rows, const RealVector& z, RealVector& u) {
  scratch_.resize(v_.size(), 0);
  std::vector<std::size_t> pattern;
  for (const std::size_t j : rows) {
    if (j >= impulses()) break;
    for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) {
      if (twin_[j] == j) pattern.push_back(rows_[e]);
      if (!surely_equal(z[j], 0)) scratch_[rows_[e]] += values_[e] * z[j];
    }
  }
  std::sort(pattern.begin(), pattern.end());
  pattern.erase(std::unique(pattern.begin(), pattern.end()), pattern.end());
  inertia_.solve(scratch_, pattern);
  for (const std::size_t row : pattern) {
    u[row] = scratch_[row] + v_[row];
    scratch_[row] = 0;
  }
}

template <class Real>
void ContactLcp<Real>::remove(std::size_t j, Real value, RealVector& u) {
  if (j >= impulses() || surely_equal(value, 0)) return;
  const Response& response = response_of(j);
  const Real signed_value = twin_[j] == j ? value : -value;
  for (std::size_t e = 0; e < response.pattern.size(); ++e) u[response.pattern[e]] -= response.values[e] * signed_value;
}

template <class Real>
Real ContactLcp<Real>::cone_row(std::size_t cone, const RealVector& z) const {
  Real slack = mu_[cone] * z[normal_of_cone_[cone]];
  for (std::size_t t = friction_of_cone_[cone]; t < friction_of_cone_[cone + 1]; ++t) slack -= z[t];
  return slack;
}

template <class Real>
Real ContactLcp<Real>::row(std::size_t i, const RealVector& z, const RealVector& u) const {
  if (i >= impulses()) return cone_row(i - impulses(), z);
  const Real velocity = project(i, u);
  return i < contacts_ ? velocity + offset(i) : velocity + z[lambda_of_[i]];
}

template <class Real>
void ContactLcp<Real>::fill_rows(std::span<const std::size_t> rows, const RealVector& z, const RealVector& u,
                                 RealVector& w) const {
  const bool at_q =
      std::equal(u.begin(), u.end(), v_.begin(), [](const Real& a, const Real& b) { return is_same(a, b); });
  for (const std::size_t i : rows) {
    if (i >= impulses()) {
      w[i] = cone_row(i - impulses(), z);
    } else if (at_q) {
      w[i] = q_[i];
    } else {
      w[i] = twin_[i] == i ? project(i, u) + offset(i) : -w[twin_[i]];
    }
  }
  for (const std::size_t i : rows) {
    if (i >= contacts_ && i < impulses()) w[i] += z[lambda_of_[i]];
  }
}

template <class Real>
const typename ContactLcp<Real>::Response& ContactLcp<Real>::response_of(std::size_t column) {
  if (responses_.empty()) {
    responses_.resize(impulses());
    scratch_.resize(v_.size(), 0);
  }
  Response& response = responses_[twin_[column]];
  if (response.known) return response;
  const std::size_t j = twin_[column];
  response.pattern.reserve(begin_[j + 1] - begin_[j]);
  for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) {
    scratch_[rows_[e]] = values_[e];
    response.pattern.push_back(rows_[e]);
  }
  inertia_.solve(scratch_, response.pattern);
  response.values.reserve(response.pattern.size());
  for (const std::size_t row : response.pattern) response.values.push_back(scratch_[row]);
  response.diagonal = project(j, scratch_);
  gather(response);
  response.known = true;
  return response;
}

template <class Real>
void ContactLcp<Real>::scatter(const Response& response) {
  for (std::size_t e = 0; e < response.pattern.size(); ++e) scratch_[response.pattern[e]] = response.values[e];
}

template <class Real>
void ContactLcp<Real>::gather(const Response& response) {
  for (const std::size_t row : response.pattern) scratch_[row] = 0;
}

template <class Real>
Real ContactLcp<Real>::diagonal(std::size_t i) {
  return i < impulses() ? response_of(i).diagonal : Real{0};
}

template <class Real>
double ContactLcp<Real>::plain_row_times(std::size_t i, const RealVector& z) const {
  if (i < impulses()) {
    const double of_diagonal = surely_equal(z[i], 0) ? 0 : plain_least_diagonal(i) * to_double(z[i]);
    return i < contacts_ ? of_diagonal : to_double(z[lambda_of_[i]]) + of_diagonal;
  }
  const std::size_t cone = i - impulses();
  double sum = std::abs(to_double(mu_[cone])) * to_double(z[normal_of_cone_[cone]]);
  for (std::size_t t = friction_of_cone_[cone]; t < friction_of_cone_[cone + 1]; ++t) sum += to_double(z[t]);
  return sum;
}

template <class Real>
double ContactLcp<Real>::plain_row_sum(std::size_t i) const {
  if (i < impulses()) return represented_[twin_[i]] * plain_least_diagonal(i) + (i < contacts_ ? 0 : 1);
  const std::size_t cone = i - impulses();
  return std::abs(to_double(mu_[cone])) + static_cast<double>(friction_of_cone_[cone + 1] - friction_of_cone_[cone]);
}

template <class Real>
Real ContactLcp<Real>::abs_row_times(std::size_t i, const RealVector& z, std::span<const std::size_t> support) {
  if (i >= impulses()) {
    const std::size_t cone = i - impulses();
    Real sum = abs(mu_[cone] * z[normal_of_cone_[cone]]);
    for (std::size_t t = friction_of_cone_[cone]; t < friction_of_cone_[cone + 1]; ++t) sum += abs(z[t]);
    return sum;
  }
  Real sum = i < contacts_ ? Real{0} : abs(z[lambda_of_[i]]);
  if (std::none_of(support.begin(), support.end(), [this](std::size_t j) { return j < impulses(); })) return sum;
  const Response& response = response_of(i);
  scatter(response);
  for (const std::size_t j : support) {
    if (j < impulses()) sum += abs(project(j, scratch_) * z[j]);
  }
  gather(response);
  return sum;
}

template <class Real>
Real ContactLcp<Real>::abs_row_sum(std::size_t i) {
  if (i >= impulses()) {
    const std::size_t cone = i - impulses();
    return abs(mu_[cone]) + static_cast<double>(friction_of_cone_[cone + 1] - friction_of_cone_[cone]);
  }
  if (abs_row_sum_.empty()) {
    abs_row_sum_.resize(impulses());
    abs_row_sum_known_.resize(impulses(), false);
  }
  const std::size_t row = twin_[i];
  if (!abs_row_sum_known_[row]) {
    if (row_begin_.empty()) list_columns_of_rows();
    const Response& response = response_of(row);
    scatter(response);
    ++visit_;
    Real sum = row < contacts_ ? 0 : 1;
    for (const std::size_t r : response.pattern) {
      for (std::size_t e = row_begin_[r]; e < row_begin_[r + 1]; ++e) {
        const std::size_t j = columns_of_row_[e];
        if (visited_[j] == visit_) continue;
        visited_[j] = visit_;
        const Real entry = abs(project(j, scratch_));
        sum += represented_[j] == 1 ? entry : entry + entry;
      }
    }
    gather(response);
    abs_row_sum_[row] = sum;
    abs_row_sum_known_[row] = true;
  }
  return abs_row_sum_[row];
}

template <class Real>
double ContactLcp<Real>::project(std::size_t i, const std::vector<double>& x) const {
  double sum = 0;
  for (std::size_t e = begin_[i]; e < begin_[i + 1]; ++e) sum += values_[e] * x[rows_[e]];
  return sum;
}

template <class Real>
std::vector<double> ContactLcp<Real>::estimate_w(const RealVector& z, const RealVector& u,
                                                 std::span<const std::size_t> rows) const {
  const std::vector<double> velocity = rounded(u);
  std::vector<double> w(q_.size(), 0.0);
  for (const std::size_t i : rows) {
    w[i] = i >= impulses() ? to_double(cone_row(i - impulses(), z))
                           : project(i, velocity) + to_double(i < contacts_ ? offset(i) : z[lambda_of_[i]]);
  }
  return w;
}

template <class Real>
double ContactLcp<Real>::estimate_response(std::size_t i) {
  std::vector<std::size_t>& pattern = estimate_pattern_;
  pattern.clear();
  if constexpr (std::is_same_v<Real, Bounded>) {
    for (std::size_t e = begin_[i]; e < begin_[i + 1]; ++e) {
      estimate_x_[rows_[e]] = values_[e];
      pattern.push_back(rows_[e]);
    }
    return inertia_.estimate(estimate_x_, pattern);
  } else {
    const Response& response = response_of(i);
    for (std::size_t e = 0; e < response.pattern.size(); ++e) {
      estimate_x_[response.pattern[e]] = to_double(response.values[e]);
      pattern.push_back(response.pattern[e]);
    }
    return 0;
  }
}

template <class Real>
void ContactLcp<Real>::fill_row(std::size_t i, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) {
  if (i >= impulses()) {
    fill_cone_row(i - impulses(), row, estimate);
    return;
  }
  if (row_begin_.empty()) list_columns_of_rows();
  if (estimate_x_.empty()) estimate_x_.assign(v_.size(), 0);
  const double error = estimate_response(i);
  double largest = 0;
  for (const std::size_t r : estimate_pattern_) largest = std::max(largest, std::abs(estimate_x_[r]));
  ++visit_;
  for (const std::size_t r : estimate_pattern_) {
    for (std::size_t e = row_begin_[r]; e < row_begin_[r + 1]; ++e) {
      const std::size_t j = columns_of_row_[e];
      if (visited_[j] == visit_) continue;
      visited_[j] = visit_;
      const double entry = std::abs(project(j, estimate_x_));
      estimate.add(j, entry);
      row.sum += represented_[j] * entry;
    }
  }
  row.diagonal = project(i, estimate_x_);
  if (i >= contacts_) {
    estimate.add(lambda_of_[i], 1);
    row.sum += 1;
  }
  for (const std::size_t r : estimate_pattern_) estimate_x_[r] = 0;
  // Each term of J_j'x is off by its own rounding and that of x: (nnz + 2) 2^-53 |J_j|'|x| at most, the count of which
  // is in the column's scale. The last summand covers what underflow may lose.
  row.error = 0x1p-53 * largest + error + 0x1p-1000;
}

template <class Real>
void ContactLcp<Real>::fill_cone_row(std::size_t cone, MagnitudeEstimate::Row& row, MagnitudeEstimate& estimate) const {
  const double mu = std::abs(to_double(mu_[cone]));
  estimate.add(normal_of_cone_[cone], mu);
  row.sum = mu + static_cast<double>(friction_of_cone_[cone + 1] - friction_of_cone_[cone]);
  for (std::size_t t = friction_of_cone_[cone]; t < friction_of_cone_[cone + 1]; ++t) {
    if (twin_[t] == t) estimate.add(t, 1);
  }
}

template <class Real>
double ContactLcp<Real>::column_scale(std::size_t j) const {
  double scale = 0x1p-30;
  if (j >= impulses()) return scale;
  for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) scale += std::abs(values_[e]);
  return scale * static_cast<double>(begin_[j + 1] - begin_[j] + 4);
}

template <class Real>
double ContactLcp<Real>::plain_least_diagonal(std::size_t i) const {
  if constexpr (std::is_same_v<Real, Bounded>) {
    const std::size_t count = begin_[i + 1] - begin_[i];
    return inertia_.least_energy(std::span(rows_).subspan(begin_[i], count), values_.data() + begin_[i]);
  }
  return 0;
}

template <class Real>
double ContactLcp<Real>::least_diagonal(std::size_t i) {
  const MagnitudeEstimate::Row* const row = this->estimated_row(i);
  if (row == nullptr) return 0;
  const double error = 2 * row->error * this->estimate().column_scale[twin_[i]];
  const double least = row->diagonal * (1 - 0x1p-30) - error;
  return std::isfinite(least) ? std::max(0.0, least) : 0;
}

template class EvaluatedLcp<Quad>;
template class EvaluatedLcp<Bounded>;
template class ContactLcp<Quad>;
template class ContactLcp<Bounded>;

}  // namespace lcpbench
