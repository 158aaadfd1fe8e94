#include "core/answer/contact_lcp.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/answer/measures.h"
#include "core/islands.h"

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

}  // namespace

ContactLcp::ContactLcp(const ContactProblem& problem, const RefinedInertia& inertia)
    : problem_(problem),
      inertia_(inertia),
      b_(problem.b.begin(), problem.b.end()),
      contacts_(static_cast<std::size_t>(problem.nc())),
      layout_(contact_layout(problem)),
      first_bounded_(static_cast<std::size_t>(layout_.row_offset())) {
  set_velocity(problem.v);
  add_columns();
  if (problem.is_soft()) soften();
}

void ContactLcp::set_velocity(const Vector& v) {
  velocity_ = v;
  v_.assign(v.begin(), v.end());
}

void ContactLcp::soften() {
  soft_.emplace(problem_, layout_);
  if (problem_.offset_t.size() == 0) return;
  b_.resize(impulses(), 0);
  for (std::size_t i = contacts_; i < impulses(); ++i) {
    const auto [contact, direction] = friction_of_row(i);
    b_[i] = soft_->along(contact, direction, soft_->offset(contact));
  }
}

/// The contact of a friction row, and its number among the contact's directions.
std::pair<Index, Index> ContactLcp::friction_of_row(std::size_t i) const {
  const Index contact = contact_of_[i - contacts_];
  return {contact, static_cast<Index>(i - contacts_) - layout_.friction_begin[static_cast<std::size_t>(contact)]};
}

Quad ContactLcp::yielding(std::size_t i, const QuadVector& z) const {
  if (is_bounded(i)) return Quad{problem_.rows.yields(number_of(i))} * z[i];
  if (i < contacts_) return soft_->normal(static_cast<Index>(i)) * z[i];
  const auto [contact, direction] = friction_of_row(i);
  const auto impulse = [&](Index j) { return z[static_cast<std::size_t>(j)]; };
  return soft_->along(contact, direction, soft_->yielding(contact, impulse));
}

/// A direction of friction is compared with the one that the problem says to be its negative.
void ContactLcp::add_columns() {
  const auto columns = static_cast<std::size_t>(problem_.nc() + cols(problem_.D) + problem_.rows.size());
  const std::size_t of_rows = problem_.has_rows() ? count_nonzeros(problem_.rows.R) : 0;
  const std::size_t nonzeros = count_nonzeros(problem_.N) + count_nonzeros(problem_.D) + of_rows;
  begin_.reserve(columns + 1);
  twin_.reserve(columns);
  rows_.resize(nonzeros);
  values_.resize(nonzeros);
  for (Index j = 0; j < cols(problem_.N); ++j) add_column(problem_.N, j);
  Index direction = 0;
  for (Index contact = 0; contact < problem_.nc(); ++contact) {
    const Index edges = problem_.edges[static_cast<std::size_t>(contact)], half = edges / 2;
    for (Index j = direction; j < direction + edges; ++j) {
      if (j >= direction + half && are_opposite(problem_.D, j - half, j)) {
        add_twin(contacts_ + static_cast<std::size_t>(j - half));
      } else {
        add_column(problem_.D, j);
      }
      contact_of_.push_back(contact);
    }
    direction += edges;
  }
  for (Index j = 0; j < problem_.rows.size(); ++j) add_column(problem_.rows.R, j);
}

void ContactLcp::add_column(const Jacobian& J, Index column) {
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
  twin_.push_back(begin_.size() - 1);
  begin_.push_back(end);
}

void ContactLcp::add_twin(std::size_t of) {
  twin_.push_back(of);
  begin_.push_back(begin_.back());
}

Quad ContactLcp::sum_of(std::size_t i, const QuadVector& x) const {
  const Entries of = entries(i);
  Quad sum = 0;
  for (std::size_t e = 0; e < of.count; ++e) sum += of.values[e] * x[of.rows[e]];
  return sum;
}

Quad ContactLcp::project(std::size_t i, const QuadVector& x) const {
  const Quad sum = sum_of(i, x);
  return is_twin(i) ? -sum : sum;
}

template <class Number>
ContactScale<Number> ContactLcp::scale_in(std::span<const std::size_t> rows, std::size_t& fastest) const {
  ContactScale<Number> scale;
  for (const std::size_t row : rows) {
    if (row >= impulses()) break;  // cone rows have no velocity
    if (is_twin(row)) continue;    // of the same magnitudes
    const Number velocity = add_velocity_before(row, Number{1}, scale);
    if (row >= contacts_) continue;
    const Number q = velocity + static_cast<Number>(offset(row));
    if (-q > scale.without) fastest = row;
    scale.add_approach(q);
  }
  return scale;
}

/// @returns J_i'v
template <class Number>
Number ContactLcp::add_velocity_before(std::size_t row, Number lever, ContactScale<Number>& scale) const {
  const Entries of = entries(row);
  Number velocity = 0, terms = 0;
  for (std::size_t e = 0; e < of.count; ++e) {
    const Number term = Number{of.values[e]} * velocity_(static_cast<Index>(of.rows[e]));
    velocity += term;
    terms += term < 0 ? -term : term;
  }
  scale.add_row(lever * velocity, lever * terms, static_cast<double>(of.count));
  return velocity;
}

/// Bounded rows count by what they leave of their conditions without impulses.
void ContactLcp::add_bounded_rows(std::span<const std::size_t> rows, ContactScale<Quad>& scale) {
  const QuadVector none(size(), 0);
  for (auto row = rows.rbegin(); row != rows.rend() && is_bounded(*row); ++row) {
    const Quad factor = lever(*row), q = add_velocity_before(*row, factor, scale) + offset(*row);
    scale.add_approach(-factor * bounded_residual(*row, none, q));
  }
}

/// In double, and again in 113 bits where a floor or rounding may decide.
Quad ContactLcp::scale(std::span<const std::size_t> rows, std::optional<Quad> without) {
  std::size_t fastest = 0;
  if (is_bounded(rows.back())) {
    auto scale = scale_in<Quad>(rows, fastest);
    add_bounded_rows(rows, scale);
    if (without) scale.without = *without;
    return scale.value();
  }
  const auto rough = scale_in<double>(rows, fastest);
  const double largest = without ? to_double(*without) : rough.without;
  const bool is_clear = largest > 2 * rough.floor() && rough.rounding < 0x1p-40 * largest && std::isfinite(largest);
  if (is_clear) return without ? *without : -q(fastest);
  auto scale = scale_in<Quad>(rows, fastest);
  if (without) scale.without = *without;
  return scale.value();
}

bool ContactLcp::at_rest(const QuadVector& z) const {
  const auto is_zero = [](Quad impulse) { return impulse == 0; };
  return std::all_of(z.begin(), z.begin() + static_cast<std::ptrdiff_t>(impulses()), is_zero) &&
         std::all_of(z.begin() + static_cast<std::ptrdiff_t>(first_bounded_), z.end(), is_zero);
}

Quad ContactLcp::offset_work(const QuadVector& z) const {
  Quad work = 0;
  for (std::size_t i = 0; i < b_.size(); ++i) work += b_[i] * z[i];
  for (std::size_t i = first_bounded_; i < size(); ++i) work += offset(i) * z[i];
  return work;
}

/// What each sum rounds off is added at the end. [Knuth 1998, 4.2.2]
void ContactLcp::sum_impulses(const QuadVector& z, QuadVector& impulse) const {
  impulse.assign(v_.size(), 0);
  lost_.assign(v_.size(), 0);
  for_each_impulse(z, [&](std::size_t j) {
    const Entries of = entries(j);
    const Quad factor = is_twin(j) ? -z[j] : z[j];
    for (std::size_t e = 0; e < of.count; ++e) {
      const std::size_t row = of.rows[e];
      const Quad before = impulse[row], term = of.values[e] * factor, sum = before + term, added = sum - before;
      lost_[row] += (before - (sum - added)) + (term - added);
      impulse[row] = sum;
    }
  });
  for (std::size_t row = 0; row < lost_.size(); ++row) {
    if (is_finite(lost_[row])) impulse[row] += lost_[row];
  }
}

QuadVector ContactLcp::generalized_impulse_scale(const QuadVector& z) const {
  QuadVector scale(v_.size(), 0);
  for_each_impulse(z, [&](std::size_t j) {
    const Entries of = entries(j);
    for (std::size_t e = 0; e < of.count; ++e) scale[of.rows[e]] += abs(of.values[e] * z[j]);
  });
  return scale;
}

void ContactLcp::respond(const QuadVector& z, QuadVector& u) const {
  if (at_rest(z)) {
    u = v_;
    return;
  }
  sum_impulses(z, u);
  inertia_.solve(u);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += v_[i];
}

QuadVector ContactLcp::response_error(const QuadVector& z) const {
  return at_rest(z) || !inertia_.has_error() ? QuadVector() : inertia_.solve_error(generalized_impulse(z));
}

Quad ContactLcp::project_magnitudes(std::size_t i, const QuadVector& x) const {
  const Entries of = entries(i);
  Quad sum = 0;
  for (std::size_t e = 0; e < of.count; ++e) sum += abs(of.values[e] * x[of.rows[e]]);
  return sum;
}

/// How far diagonal() may be off.
Quad ContactLcp::diagonal_error(std::size_t i) const {
  const Entries of = entries(i);
  QuadVector column(v_.size(), 0);
  for (std::size_t e = 0; e < of.count; ++e) column[of.rows[e]] = of.values[e];
  return project_magnitudes(i, inertia_.solve_error(column));
}

Quad ContactLcp::residual_error(std::size_t i, const QuadVector& z, Quad w, const QuadVector& off) {
  if (is_bounded(i)) {  // f - lower and f - upper are no larger than this, if they are finite
    const auto [lower, upper] = bounds(i, z);
    const Quad largest = abs(z[i]) + (is_finite(lower) ? -lower : 0) + (is_finite(upper) ? upper : 0);
    return lever(i) * (project_magnitudes(i, off) + (largest == 0 ? largest : largest * diagonal_error(i)));
  }
  if (i >= impulses()) return w == 0 ? w : abs(w) * diagonal_error(normal_of_cone(i));
  return project_magnitudes(i, off) + (z[i] == 0 ? z[i] : abs(z[i]) * diagonal_error(i));
}

/// The lower one comes first also where a load is below zero.
std::pair<Quad, Quad> ContactLcp::bounds(std::size_t i, const QuadVector& z) const {
  const LcpBounds& bounds = problem_.rows.bounds;
  const Index row = number_of(i);
  const int of = bounds.friction_of[static_cast<std::size_t>(row)];
  if (of < 0) return {bounds.lower(row), bounds.upper(row)};
  const Quad limit = abs(bounds.mu(row) * z[first_bounded_ + static_cast<std::size_t>(of)]);
  return {-limit, limit};
}

Quad ContactLcp::bounded_residual(std::size_t i, const QuadVector& z, Quad w) {
  const auto [lower, upper] = bounds(i, z);
  if (w == 0 && lower <= z[i] && z[i] <= upper) return 0;  // whatever M_ii is, which takes a solve
  if (!is_finite(lower) && !is_finite(upper)) return abs(w);
  const Quad to_lower = is_finite(lower) ? diagonal(i) * (z[i] - lower) : -lower;
  const Quad to_upper = is_finite(upper) ? diagonal(i) * (z[i] - upper) : -upper;
  const Quad least = w < to_lower ? w : to_lower;
  return abs(least > to_upper ? least : to_upper);
}

Quad ContactLcp::lever(std::size_t i) {
  if (problem_.rows.is_angle[static_cast<std::size_t>(number_of(i))] == 0) return 1;
  if (levers_.empty()) find_levers();
  return levers_[static_cast<std::size_t>(number_of(i))];
}

/// Of column i of J in this row.
double ContactLcp::entry_of(std::size_t i, std::size_t row) const {
  const Entries of = entries(i);
  const std::size_t* const found = std::lower_bound(of.rows, of.rows + of.count, row);
  return of.values[found - of.rows];
}

void ContactLcp::find_levers() {
  const BoundedRows& bounded = problem_.rows;
  const auto count = static_cast<std::size_t>(bounded.size());
  levers_.assign(count, 1);
  const auto is_angle = [&](std::size_t row) { return bounded.is_angle[row] != 0; };
  IslandNumbers islands;
  islands.find(problem_);
  std::vector<QuadVector> of_contacts(static_cast<std::size_t>(islands.count)), of_rows = of_contacts;
  const auto add = [&](Index island, std::size_t i, std::vector<QuadVector>& to) {
    const Quad own = island < 0 ? Quad{0} : rigid_diagonal(i);
    if (own > 0) to[static_cast<std::size_t>(island)].push_back(own);
  };
  for (std::size_t c = 0; c < contacts_; ++c) add(islands.of_contact[c], c, of_contacts);
  for (std::size_t row = 0; row < count; ++row) {
    if (!is_angle(row)) add(islands.of_row[row], first_bounded_ + row, of_rows);
  }
  const auto median = [](QuadVector numbers) {
    std::sort(numbers.begin(), numbers.end());
    const std::size_t half = numbers.size() / 2;
    return numbers.size() % 2 == 1 ? numbers[half] : (numbers[half - 1] + numbers[half]) / 2;
  };
  std::vector<std::vector<std::size_t>> contacts_of(v_.size());  // by coordinate
  for (std::size_t c = 0; c < contacts_; ++c) {
    const Entries of = entries(c);
    for (std::size_t e = 0; e < of.count; ++e) contacts_of[of.rows[e]].push_back(c);
  }
  QuadVector moved;
  std::vector<std::size_t> near;
  QuadVector coupling(contacts_, 0);  // M_ci
  for (std::size_t row = 0; row < count; ++row) {
    const std::size_t i = first_bounded_ + row;
    const Quad own = is_angle(row) ? rigid_diagonal(i) : Quad{0};
    if (!(own > 0)) continue;
    const auto island = static_cast<std::size_t>(islands.of_row[row]);
    const Entries of = entries(i);
    near.clear();
    inertia_.for_each_response({of.rows, of.count}, of.values, [&](std::size_t coordinate, Quad velocity) {
      if (velocity == 0) return;
      for (const std::size_t c : contacts_of[coordinate]) {
        near.push_back(c);
        coupling[c] += entry_of(c, coordinate) * velocity;
      }
    });
    moved.clear();
    for (const std::size_t c : near) {  // a contact may be there several times, and then counts once
      const Quad of_contact = std::exchange(coupling[c], 0);
      const Quad of_both = rigid_diagonal(c) * own;
      if (of_contact * of_contact > Quad{kLeastCoupling * kLeastCoupling} * of_both) moved.push_back(rigid_diagonal(c));
    }
    const QuadVector& others = !moved.empty() ? moved : !of_contacts[island].empty() ? of_contacts[island] : of_rows[island];
    if (!others.empty()) levers_[row] = sqrt(median(others) / own);
  }
}

Quad ContactLcp::cone_row(std::size_t i, const QuadVector& z) const {
  const std::size_t contact = normal_of_cone(i);
  Quad slack = problem_.mu(static_cast<Index>(contact)) * z[contact];
  for (Index t = layout_.friction_begin[contact]; t < layout_.friction_begin[contact + 1]; ++t) {
    slack -= z[contacts_ + static_cast<std::size_t>(t)];
  }
  return slack;
}

void ContactLcp::complete(QuadVector& z, const QuadVector& u) const {
  for (std::size_t i = impulses(); i < first_bounded_; ++i) {
    const std::size_t contact = normal_of_cone(i);
    Quad largest = 0;
    for (Index t = layout_.friction_begin[contact]; t < layout_.friction_begin[contact + 1]; ++t) {
      const std::size_t row = contacts_ + static_cast<std::size_t>(t);
      if (is_twin(row)) continue;
      const Quad slip = abs(velocity(row, z, u));
      if (!(slip <= largest)) largest = slip;
    }
    z[i] = to_double(largest);
  }
}

void ContactLcp::write_rows(const QuadVector& z, const QuadVector& u, QuadVector& w) const {
  w.resize(size());
  for (std::size_t i = 0; i < impulses(); ++i) w[i] = is_twin(i) ? -w[twin_[i]] : sum_of(i, u) + offset(i);
  for (std::size_t i = impulses(); i < first_bounded_; ++i) w[i] = cone_row(i, z);
  for (std::size_t i = 0; soft_ && i < impulses(); ++i) w[i] += yielding(i, z);
  for (std::size_t i = contacts_; i < impulses(); ++i) w[i] += z[lambda_of(i)];
  for (std::size_t i = first_bounded_; i < size(); ++i) w[i] = velocity(i, z, u);
}

Quad ContactLcp::rigid_diagonal(std::size_t i) {
  diagonals_.resize(twin_.size());
  std::optional<Quad>& diagonal = diagonals_[twin_[column_of(i)]];
  const Entries of = entries(i);
  if (!diagonal) diagonal = inertia_.energy({of.rows, of.count}, of.values);
  return *diagonal;
}

Quad ContactLcp::diagonal(std::size_t i) {
  if (is_bounded(i)) return rigid_diagonal(i) + problem_.rows.yields(number_of(i));
  if (i >= impulses()) return 0;
  if (!soft_) return rigid_diagonal(i);
  if (i < contacts_) return rigid_diagonal(i) + soft_->normal(static_cast<Index>(i));
  const auto [contact, direction] = friction_of_row(i);
  return rigid_diagonal(i) + soft_->diagonal(contact, direction);
}

}  // namespace lcpbench
