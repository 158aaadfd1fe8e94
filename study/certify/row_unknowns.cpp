#include "study/certify/row_unknowns.h"

#include <algorithm>
#include <cmath>

#include "study/certify/integers.h"

namespace lcpbench::exact {

RowUnknowns::RowUnknowns(const ContactProblem& contact)
    : layout(contact_layout(contact)), bounds(contact.rows.bounds), origin(Vector::Zero(contact.rows.size())) {
  std::vector<Index> first;  // part of each row
  for (Index row = 0; row < origin.size(); ++row) {
    const bool has_lower = std::isfinite(bounds.lower(row)), has_upper = std::isfinite(bounds.upper(row));
    first.push_back(std::ssize(parts));
    if (has_lower || has_upper) {
      origin(row) = has_lower ? bounds.lower(row) : bounds.upper(row);
      parts.push_back({row, has_lower ? 1 : -1});
      if (has_lower && has_upper) slacks.push_back({row, first.back()});
      continue;
    }
    parts.push_back({row, 1});
    parts.push_back({row, -1});
    if (bounds.friction_of[index(row)] >= 0) slacks.push_back({row, first.back(), 0});
  }
  for (Slack& slack : slacks) {
    if (slack.is_friction()) slack.load = first[index(bounds.friction_of[index(slack.row)])];
  }
}

std::optional<Index> RowUnknowns::with_sign(Index row, int sign) const {
  for (std::size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].row == row && parts[k].sign == sign) return part_offset() + static_cast<Index>(k);
  }
  return std::nullopt;
}

Vector RowUnknowns::unknowns(const Vector& z, const Vector& w) const {
  constexpr double kAtBound = 1e-9;
  Vector x = Vector::Zero(size());
  x.head(part_offset()) = z.head(part_offset());
  x.segment(cone_offset(), layout.cones) = z.segment(layout.lambda_offset(), layout.cones);
  const auto f = z.tail(layout.rows);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const auto [row, sign] = parts[k];
    x(part_offset() + static_cast<Index>(k)) = std::max(0.0, sign * (f(row) - origin(row)));
  }
  for (std::size_t k = 0; k < slacks.size(); ++k) {
    const Slack& slack = slacks[k];
    const double velocity = w(layout.row_offset() + slack.row);
    double& s = x(slack_offset() + static_cast<Index>(k));
    if (slack.is_friction()) {
      const double limit = bounds.mu(slack.row) * f(bounds.friction_of[index(slack.row)]);
      if (std::abs(f(slack.row)) >= limit * (1 - kAtBound)) s = std::abs(velocity);
    } else if (f(slack.row) >= bounds.upper(slack.row) - kAtBound * std::abs(bounds.upper(slack.row))) {
      s = std::max(0.0, -velocity);
    }
  }
  return x;
}

Matrix RowUnknowns::to_impulses() const {
  Matrix E = Matrix::Zero(layout.size(), size());
  E.topLeftCorner(part_offset(), part_offset()).setIdentity();
  E.block(layout.lambda_offset(), cone_offset(), layout.cones, layout.cones).setIdentity();
  for (std::size_t k = 0; k < parts.size(); ++k) {
    E(layout.row_offset() + parts[k].row, part_offset() + static_cast<Index>(k)) = parts[k].sign;
  }
  return E;
}

Lcp RowUnknowns::lcp(const Lcp& mixed) const {
  const Matrix E = to_impulses();
  Vector z = Vector::Zero(layout.size());
  z.tail(layout.rows) = origin;
  Lcp lcp;
  lcp.M = E.transpose() * mixed.M * E;
  lcp.q = E.transpose() * (mixed.q + mixed.M * z);
  for (std::size_t k = 0; k < slacks.size(); ++k) {
    const Slack& slack = slacks[k];
    const Index at = slack_offset() + static_cast<Index>(k);
    for (Index part = slack.first; part <= slack.first + (slack.is_friction() ? 1 : 0); ++part) {
      lcp.M(part_offset() + part, at) = 1;
      lcp.M(at, part_offset() + part) = -1;
    }
    if (slack.is_friction()) {
      lcp.M(at, part_offset() + slack.load) = bounds.mu(slack.row);
    } else {
      lcp.q(at) = bounds.upper(slack.row) - bounds.lower(slack.row);
    }
  }
  return lcp;
}

}  // namespace lcpbench::exact
