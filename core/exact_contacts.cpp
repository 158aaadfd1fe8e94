#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/compliance.h"
#include "core/entries.h"
#include "core/exact_inertia.h"
#include "core/islands.h"

namespace lcpbench {
namespace {

std::size_t place(Index i) { return static_cast<std::size_t>(i); }

}  // namespace

ExactContacts::Fraction& ExactContacts::Fraction::operator+=(const Fraction& x) {
  if (compare_magnitudes(denominator, x.denominator) == 0) {  // both are positive
    numerator += x.numerator;
  } else {
    numerator = numerator * x.denominator + x.numerator * denominator;
    denominator = denominator * x.denominator;
  }
  return *this;
}

ExactContacts::ExactContacts(const ContactProblem& problem, ExactResponse response)
    : problem_(problem), layout_(contact_layout(problem)), response_(std::move(response)) {
  for (const Jacobian* J : {&problem.N, &problem.D}) {
    for (Index j = 0; j < cols(*J); ++j) {
      Column& column = columns_.emplace_back();
      for_each_entry(*J, j, [&](Index row, double entry) { column.push_back({row, Dyadic(entry)}); });
    }
  }
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    Dyadic sum;
    for (const Entry& entry : columns_[j]) sum += entry.value * Dyadic(problem.v(entry.row));
    sum += offset(static_cast<Index>(j));
    q_.push_back(std::move(sum));
  }
}

/// The contact of a friction row, and which of its directions the row is.
ExactContacts::Direction ExactContacts::direction_of(Index row) const {
  const auto& begin = layout_.friction_begin;
  const auto own = std::upper_bound(begin.begin(), begin.end(), row - layout_.nc) - 1;
  return {own - begin.begin(), row - layout_.nc - *own};
}

/// What q has in the row beside the velocity before.
Dyadic ExactContacts::offset(Index row) const {
  if (row < layout_.nc) return Dyadic(problem_.offset(row));
  if (problem_.offset_t.size() == 0) return {};
  const SoftRows<Dyadic> soft(problem_, layout_);
  const auto [contact, k] = direction_of(row);
  return soft.along(contact, k, soft.offset(contact));
}

/// The numerators of G* x.
std::vector<Dyadic> ExactContacts::respond(std::vector<Dyadic> x) const {
  std::vector<Dyadic> y(x.size());
  for (const ExactResponse::Block& block : response_.blocks()) {
    for (Index i = 0; i < block.size(); ++i) {
      for (Index j = 0; j < block.size(); ++j) {
        y[place(block.first + i)] += block.numerator(i, j) * x[place(block.first + j)];
      }
    }
  }
  return y;
}

/// The column's product with G* x, given by its numerators.
ExactContacts::Fraction ExactContacts::project(const Column& column, const std::vector<Dyadic>& numerators) const {
  Fraction sum;
  for (const Entry& entry : column) {
    sum += Fraction{entry.value * numerators[place(entry.row)], response_.block_of(entry.row).denominator};
  }
  return sum;
}

Quad ExactContacts::diagonal(Index row) const {
  std::vector<Dyadic> x(place(problem_.ngc()));
  for (const Entry& entry : columns_[place(row)]) x[place(entry.row)] = entry.value;
  Fraction sum = project(columns_[place(row)], respond(std::move(x)));
  if (problem_.is_soft()) {
    const SoftRows<Dyadic> soft(problem_, layout_);
    if (row < layout_.nc) {
      sum += Fraction{soft.normal(row)};
    } else {
      const auto [contact, k] = direction_of(row);
      sum += Fraction{soft.diagonal(contact, k)};
    }
  }
  return sum.value();
}

/// The numerators of G* J f.
std::vector<Dyadic> ExactContacts::change(const Vector& z) const {
  std::vector<Dyadic> impulse(place(problem_.ngc()));
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    if (z(static_cast<Index>(j)) == 0) continue;
    const Dyadic factor(z(static_cast<Index>(j)));
    for (const Entry& entry : columns_[j]) impulse[place(entry.row)] += entry.value * factor;
  }
  return respond(std::move(impulse));
}

std::vector<Quad> ExactContacts::velocity(const Vector& z) const {
  const std::vector<Dyadic> numerators = change(z);
  std::vector<Quad> velocity;
  for (Index i = 0; i < problem_.ngc(); ++i) {
    Fraction sum{numerators[place(i)], response_.block_of(i).denominator};
    sum += Fraction{Dyadic(problem_.v(i))};
    velocity.push_back(sum.value());
  }
  return velocity;
}

Quad ExactContacts::inverse(Index i, Index j) const {
  const ExactResponse::Block& block = response_.block_of(i);
  if (j < block.first || j >= block.first + block.size()) return 0;
  return quotient(block.numerator(i - block.first, j - block.first), block.denominator);
}

std::vector<Quad> ExactContacts::complement(const Vector& z) const {
  const std::vector<Dyadic> numerators = change(z);
  const SoftRows<Dyadic> soft(problem_, layout_);
  std::vector<Quad> w;
  for (std::size_t j = 0; j < columns_.size(); ++j) {
    Fraction sum = project(columns_[j], numerators);
    sum += Fraction{q_[j]};
    const auto row = static_cast<Index>(j);
    if (row >= layout_.nc) {
      const auto [contact, k] = direction_of(row);
      sum += Fraction{Dyadic(z(layout_.lambda_offset() + layout_.lambda[place(contact)]))};
      const auto yielding = soft.yielding(contact, [&](Index i) { return Dyadic(z(i)); });
      if (problem_.is_soft()) sum += Fraction{soft.along(contact, k, yielding)};
    } else if (problem_.is_soft()) {
      sum += Fraction{soft.normal(row) * Dyadic(z(row))};
    }
    w.push_back(sum.value());
  }
  for (Index cone = 0; cone < layout_.cones; ++cone) {
    const Index contact = layout_.cone_contact[place(cone)];
    Dyadic slack = Dyadic(problem_.mu(contact)) * Dyadic(z(contact));
    for (Index t = layout_.friction_begin[place(contact)]; t < layout_.friction_begin[place(contact) + 1]; ++t) {
      slack -= Dyadic(z(layout_.friction_offset() + t));
    }
    w.push_back(quotient(slack, Dyadic(1.0)));
  }
  return w;
}

/// What the verdict's residual of the row is relative to: |q_i|, or the rounding of q_i in double over 1e-4 if larger.
Quad ExactContacts::scale(Index row) const {
  constexpr double kTolerance = 1e-4;
  if (row >= layout_.lambda_offset()) return 0;
  const SoftRows<Dyadic> soft(problem_, layout_);
  Dyadic offsets;  // the sum of their magnitudes
  int more = 0;    // terms beside those of J
  if (row < layout_.nc) {
    offsets = abs(offset(row));
    more = (offsets.is_zero() ? 0 : 1) + (problem_.normal_compliance(row) != 0 ? 1 : 0);
  } else if (problem_.is_soft()) {
    const auto [contact, k] = direction_of(row);
    const auto of = soft.offset(contact);
    offsets = abs(soft.along(contact, k, {of[0], {}})) + abs(soft.along(contact, k, {Dyadic(), of[1]}));
    more = soft.terms(contact, k);
  }
  Quad magnitude = quotient(offsets, Dyadic(1.0));
  for (const Entry& entry : columns_[place(row)]) {
    magnitude += quotient(abs(entry.value * Dyadic(problem_.v(entry.row))), Dyadic(1.0));
  }
  const double terms = static_cast<double>(columns_[place(row)].size()) + more;
  const Quad floor = (terms + 1) * (Quad{0x1p-53} * magnitude + Quad{0x1p-1074});
  return std::max(quotient(abs(q_[place(row)]), Dyadic(1.0)), floor / Quad{kTolerance});
}

double ExactContacts::velocity_residual(const Vector& z) const {
  const std::vector<Quad> w = complement(z);
  const RowIslands islands = row_islands(problem_);
  std::vector<Quad> residuals(place(islands.count), 0);
  std::vector<Quad> scales(place(islands.count), 0);
  for (Index row = 0; row < layout_.size(); ++row) {
    Quad impulse = z(row);
    Quad velocity = w[place(row)];
    if (row >= layout_.lambda_offset()) {
      if (velocity != 0) velocity *= diagonal(layout_.cone_contact[place(row - layout_.lambda_offset())]);
    } else if (impulse != 0) {
      impulse *= diagonal(row);
    }
    Quad& residual = residuals[place(islands.of_row[place(row)])];
    residual = std::max(residual, abs(std::min(impulse, velocity)));
    Quad& largest = scales[place(islands.of_row[place(row)])];
    largest = std::max(largest, scale(row));
  }
  double rho = 0;
  for (std::size_t k = 0; k < residuals.size(); ++k) {
    if (residuals[k] == 0) continue;
    rho = std::max(rho, scales[k] == 0 ? std::numeric_limits<double>::infinity() : to_double(residuals[k] / scales[k]));
  }
  return rho;
}

}  // namespace lcpbench
