#include "adapters/dart/boxed_contacts.h"

#include <algorithm>
#include <limits>

namespace lcpbench {
namespace {

/// DART's rows are padded to multiples of four numbers, but for a single one (dPAD of ODE).
Index stride(Index n) { return n > 1 ? ((n - 1) | 3) + 1 : n; }

/// Collects the boxed rows of a problem.
struct RowBuilder {
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> limit;  ///< friction: of |x| / f_N
  std::vector<int> normal_row;

  Index add(double bound, int normal) {
    limit.push_back(bound);
    normal_row.push_back(normal);
    return static_cast<Index>(limit.size()) - 1;
  }
  void add_friction(Index first_direction, int edges, double mu, int normal) {
    if (edges == 2) {
      entries.emplace_back(first_direction, add(mu, normal), 1.0);
      return;
    }
    const Index sum = add(mu / 2, normal);
    const Index difference = add(mu / 2, normal);
    entries.emplace_back(first_direction, sum, 1.0);
    entries.emplace_back(first_direction + 1, sum, 1.0);
    entries.emplace_back(first_direction, difference, 1.0);
    entries.emplace_back(first_direction + 1, difference, -1.0);
  }
};

}  // namespace

std::string BoxedContacts::load(const ContactProblem& contact) {
  layout_ = contact_layout(contact);
  RowBuilder rows;
  for (Index i = 0; i < layout_.nc; ++i) {
    rows.entries.emplace_back(i, rows.add(std::numeric_limits<double>::infinity(), -1), 1.0);
  }
  for (const Index c : layout_.cone_contact) {
    const auto i = static_cast<std::size_t>(c);
    if (contact.edges[i] > 4) return "a pyramid of more than 4 edges is no box";
    rows.add_friction(layout_.friction_offset() + layout_.friction_begin[i], contact.edges[i], contact.mu(c),
                      static_cast<int>(c));
  }
  lcp_ = form_lcp(contact);
  const auto m = static_cast<Index>(rows.limit.size());
  rows_.resize(lcp_.size(), m);
  rows_.setFromTriplets(rows.entries.begin(), rows.entries.end());
  padded_.setZero(stride(m), m);
  padded_.topRows(m) = rows_.transpose() * (lcp_.M * rows_).eval();
  b_ = -(rows_.transpose() * lcp_.q);
  upper_ = Eigen::Map<const Vector>(rows.limit.data(), m);
  lower_ = (upper_.array() < std::numeric_limits<double>::infinity()).select(-upper_, 0.0);
  normal_row_ = std::move(rows.normal_row);
  return {};
}

void BoxedContacts::start_at(const Vector* z) {
  x_.setZero(b_.size());
  if (z == nullptr) return;
  Vector merged = *z;
  for (const Index c : layout_.cone_contact) {
    const auto i = static_cast<std::size_t>(c);
    const Index half = (layout_.friction_begin[i + 1] - layout_.friction_begin[i]) / 2;
    const Index begin = layout_.friction_offset() + layout_.friction_begin[i];
    merged.segment(begin, half) -= merged.segment(begin + half, half);
  }
  for (Index k = 0; k < x_.size(); ++k) x_(k) = rows_.col(k).dot(merged) / rows_.col(k).squaredNorm();
}

bool BoxedContacts::solve(dart::constraint::BoxedLcpSolver& solver, bool early_termination, Vector& z) {
  constexpr int kUnbounded = 0;
  destroyed_A_ = padded_;
  destroyed_b_ = b_;
  destroyed_lower_ = lower_;
  destroyed_upper_ = upper_;
  destroyed_normal_row_ = normal_row_;
  const bool solved =
      solver.solve(static_cast<int>(x_.size()), destroyed_A_.data(), x_.data(), destroyed_b_.data(), kUnbounded,
                   destroyed_lower_.data(), destroyed_upper_.data(), destroyed_normal_row_.data(), early_termination);
  z = rows_ * x_;
  if (frictional()) split_friction(z);
  return solved;
}

void BoxedContacts::split_friction(Vector& z) const {
  for (const Index c : layout_.cone_contact) {
    const auto i = static_cast<std::size_t>(c);
    const Index begin = layout_.friction_offset() + layout_.friction_begin[i];
    const Index half = (layout_.friction_begin[i + 1] - layout_.friction_begin[i]) / 2;
    for (Index k = begin; k < begin + half; ++k) {
      z(k + half) = std::max(-z(k), 0.0);
      z(k) = std::max(z(k), 0.0);
    }
  }
  const Vector w = lcp_.M * z + lcp_.q;  // lambda is still zero: its rows are slips
  for (const Index c : layout_.cone_contact) {
    const auto i = static_cast<std::size_t>(c);
    const auto slips = w.segment(layout_.friction_offset() + layout_.friction_begin[i],
                                 layout_.friction_begin[i + 1] - layout_.friction_begin[i]);
    z(layout_.lambda_offset() + layout_.lambda[i]) = std::max(-slips.minCoeff(), 0.0);
  }
}

void BoxedSolver::on_solve(const SolveRequest& request, Answer& answer) {
  if (!refusal_.empty()) {
    answer.claim = Claim::kUnsupported;
    answer.detail = refusal_;
  } else if (answer.z.size() == 0) {
    answer.claim = Claim::kSolved;
  } else {
    contacts_.start_at(capabilities().warm_start ? request.start : nullptr);
    solve(contacts_, answer);
  }
}

}  // namespace lcpbench
