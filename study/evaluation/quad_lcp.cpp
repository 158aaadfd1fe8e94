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

/// Whether nobody knows its sign.
bool is_lost_in_rounding(const Bounded& x) { return !x.exact() && !(std::abs(x.high) > 8 * x.error); }

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
  if (estimate_.count > kLargestEstimate) return nullptr;
  estimate_.make_room(size());
  row.begin = estimate_.count;
  fill_row(representing, row, estimate_);
  row.end = estimate_.count;
  row.known = true;
  return &row;
}

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
      represented_(memory),
      mu_(memory),
      normal_of_cone_(memory),
      friction_of_cone_(memory),
      lambda_of_(memory) {
  for (const double v : problem.v) {
    if (!(std::abs(v) <= largest_speed_)) largest_speed_ = std::isnan(v) ? INFINITY : std::abs(v);
  }
  add_columns(problem);
  list_cones(problem, layout_);

  q_.reserve(impulses() + normal_of_cone_.size());
  for (std::size_t i = 0; i < impulses(); ++i) {
    q_.push_back(is_twin(i) ? -q_[twin_[i]] : speed_before(i, problem.v) + offset(i));
  }
  q_.resize(impulses() + normal_of_cone_.size(), 0);
}

/// A direction of friction is compared with the one that the problem says to be its negative.
template <class Real>
void ContactLcp<Real>::add_columns(const ContactProblem& problem) {
  const auto columns = static_cast<std::size_t>(problem.nc() + cols(problem.D));
  const std::size_t nonzeros = count_nonzeros(problem.N) + count_nonzeros(problem.D);
  begin_.reserve(columns + 1);
  twin_.reserve(columns);
  sizes_.reserve(columns);
  represented_.reserve(columns);
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
  represented_.push_back(1);
}

template <class Real>
void ContactLcp<Real>::add_twin(std::size_t of) {
  twin_.push_back(of);
  begin_.push_back(begin_.back());
  sizes_.push_back(sizes_[of]);
  represented_[of] = 2;
  represented_.push_back(1);
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
void ContactLcp<Real>::list_columns_of_rows() {
  row_begin_.assign(v_.size() + 1, 0);
  for (std::size_t e = 0; e < begin_.back(); ++e) ++row_begin_[rows_[e] + 1];
  for (std::size_t row = 0; row < v_.size(); ++row) row_begin_[row + 1] += row_begin_[row];
  columns_of_row_.resize(row_begin_.back());
  std::vector<std::size_t> next = row_begin_;
  for (std::size_t j = 0; j < impulses(); ++j) {
    for (std::size_t e = begin_[j]; e < begin_[j + 1]; ++e) columns_of_row_[next[rows_[e]]++] = j;
  }
  visited_.assign(impulses(), 0);
  twin_from_.resize(impulses());
  for (std::size_t j = 0; j < impulses(); ++j) twin_from_[j] = twin_from_[twin_[j]] = j;
}

template <class Real>
template <class Visit>
void ContactLcp<Real>::for_each_column_at(const std::vector<std::size_t>& pattern, Visit&& visit) {
  if (row_begin_.empty()) list_columns_of_rows();
  ++visit_;
  for (const std::size_t row : pattern) {
    for (std::size_t e = row_begin_[row]; e < row_begin_[row + 1]; ++e) {
      const std::size_t j = columns_of_row_[e];
      if (visited_[j] == visit_) continue;
      visited_[j] = visit_;
      visit(j);
    }
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
Real ContactLcp<Real>::speed_before(std::size_t i, const Vector& v) const {
  const Entries of = entries(i);
  if constexpr (std::is_same_v<Real, Bounded>) {
    static const BoundedDotOfDoubles dot = bounded_dot_of_doubles_of_level();
    const Bounded sum = dot(of.values, of.rows, of.count, v.data());
    if (!is_lost_in_rounding(sum)) return sum;
    return exact_dot(of.values, of.rows, of.count, v_.data()).value_or(sum);
  } else {
    Real sum = 0;
    for (std::size_t e = 0; e < of.count; ++e) sum += of.values[e] * Real{v.data()[of.rows[e]]};
    return sum;
  }
}

template <class Real>
Real ContactLcp<Real>::project(std::size_t i, const RealVector& x) const {
  const Real sum = sum_of(i, x);
  return is_twin(i) ? -sum : sum;
}

template <class Real>
double ContactLcp<Real>::formation_limit(std::size_t i) const {
  if (i >= impulses()) return 0;
  const double magnitude = sizes_[i] * largest_speed_ + std::abs(to_double(offset(i)));
  return static_cast<double>(entries(i).count + 2) * (0x1p-53 * magnitude * (1 + 0x1p-20) + bounded::kLost);
}

template <class Real>
Real ContactLcp<Real>::formation_error(std::size_t i) const {
  if (i >= impulses()) return 0;
  const Entries of = entries(i);
  const std::size_t terms = of.count + (surely_equal(offset(i), 0) ? 0 : 1);
  using Number = decltype(leading(Real{}));
  using std::abs, lcpbench::abs;
  Number magnitude = abs(leading(offset(i)));
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
std::vector<Real> ContactLcp<Real>::response(const RealVector& z) {
  if (at_rest(z)) return v_;
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
    const Entries of = entries(j);
    const bool twin = is_twin(j), zero = surely_equal(z[j], 0);
    const Real factor = twin ? -z[j] : z[j];
    for (std::size_t e = 0; e < of.count; ++e) {
      if (!twin) pattern.push_back(of.rows[e]);
      if (!zero) scratch_[of.rows[e]] += of.values[e] * factor;
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
  const Real signed_value = is_twin(j) ? -value : value;
  for (std::size_t e = 0; e < response.pattern.size(); ++e) u[response.pattern[e]] -= response.values[e] * signed_value;
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
      w[i] = is_twin(i) ? -w[twin_[i]] : sum_of(i, u) + offset(i);
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
  const Entries of = entries(j);
  for (std::size_t e = 0; e < of.count; ++e) scratch_[of.rows[e]] = of.values[e];
  response.pattern.assign(of.rows, of.rows + of.count);
  inertia_.solve(scratch_, response.pattern);
  response.values.reserve(response.pattern.size());
  for (const std::size_t row : response.pattern) response.values.push_back(scratch_[row]);
  response.diagonal = sum_of(j, scratch_);
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
  for_each_column_at(response.pattern, [&](std::size_t j) {
    const bool moves = !surely_equal(z[j], 0);
    const std::size_t twin = twin_from_[j];
    const bool twin_moves = twin != j && !surely_equal(z[twin], 0);
    if (!moves && !twin_moves) return;
    const Real entry = sum_of(j, scratch_);
    if (moves) sum += abs(entry * z[j]);
    if (twin_moves) sum += abs(entry * z[twin]);
  });
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
    const Response& response = response_of(row);
    scatter(response);
    Real sum = row < contacts_ ? 0 : 1;
    for_each_column_at(response.pattern, [&](std::size_t j) {
      const Real entry = abs(sum_of(j, scratch_));
      sum += represented_[j] == 1 ? entry : entry + entry;
    });
    gather(response);
    abs_row_sum_[row] = sum;
    abs_row_sum_known_[row] = true;
  }
  return abs_row_sum_[row];
}

/// In two sums, which do not wait for each other.
template <class Real>
inline double ContactLcp<Real>::sum_of_entries(std::size_t begin, std::size_t end, const double* x) const {
  const std::size_t* const rows = rows_.data();
  const double* const values = values_.data();
  double even = 0, odd = 0;
  std::size_t e = begin;
  for (; e + 1 < end; e += 2) {
    even += values[e] * x[rows[e]];
    odd += values[e + 1] * x[rows[e + 1]];
  }
  return e < end ? even + odd + values[e] * x[rows[e]] : even + odd;
}

template <class Real>
std::vector<double> ContactLcp<Real>::estimate_w(const RealVector& z, const RealVector& u,
                                                 std::span<const std::size_t> rows) const {
  const std::vector<double> velocity = rounded(u);
  std::vector<double> w(q_.size(), 0.0);
  for (const std::size_t i : rows) {
    if (i >= impulses()) {
      w[i] = to_double(cone_row(i - impulses(), z));
    } else {
      const double sum = sum_of_entries(begin_[twin_[i]], begin_[twin_[i] + 1], velocity.data());
      w[i] = (is_twin(i) ? -sum : sum) + to_double(i < contacts_ ? offset(i) : z[lambda_of_[i]]);
    }
  }
  return w;
}

template <class Real>
double ContactLcp<Real>::estimate_response(std::size_t i) {
  std::vector<std::size_t>& pattern = estimate_pattern_;
  pattern.clear();
  if constexpr (std::is_same_v<Real, Bounded>) {
    const Entries of = entries(i);
    for (std::size_t e = 0; e < of.count; ++e) estimate_x_[of.rows[e]] = of.values[e];
    pattern.assign(of.rows, of.rows + of.count);
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
  if (estimate_x_.empty()) estimate_x_.assign(v_.size(), 0);
  const double error = estimate_response(i);
  double largest = 0;
  for (const std::size_t r : estimate_pattern_) largest = std::max(largest, std::abs(estimate_x_[r]));
  const auto add = [&](std::size_t j) {
    const double entry = std::abs(sum_of_entries(begin_[j], begin_[j + 1], estimate_x_.data()));
    if (entry == 0) return;  // which may be off by the error, as any other; a twin's
    estimate.add(j, entry);
    row.sum += represented_[j] * entry;
  };
  if (8 * estimate_pattern_.size() >= v_.size()) {  // to list the columns that have entries there costs more
    for (std::size_t j = 0; j < impulses(); ++j) add(j);
  } else {
    for_each_column_at(estimate_pattern_, add);
  }
  row.diagonal = sum_of_entries(begin_[i], begin_[i + 1], estimate_x_.data());
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
  if (j >= impulses()) return 0x1p-30;
  return (0x1p-30 + sizes_[j]) * static_cast<double>(entries(j).count + 4);
}

template <class Real>
double ContactLcp<Real>::plain_least_diagonal(std::size_t i) const {
  if constexpr (std::is_same_v<Real, Bounded>) {
    constexpr double kUnknown = -1;
    if (least_diagonals_.empty()) least_diagonals_.assign(impulses(), kUnknown);
    double& least = least_diagonals_[twin_[i]];
    if (least == kUnknown) least = inertia_.least_energy(rows(i), entries(i).values);
    return least;
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
