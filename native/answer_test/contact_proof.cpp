// What the end of the linear program of ContactSolvability proves.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/timed_solve.h"
#include "native/answer_test/contact_program.h"
#include "native/answer_test/contact_solvability.h"
#include "native/answer_test/scaled_numbers.h"
#include "native/contacts/contact_edges.h"

namespace lcpbench {
namespace {

constexpr double kUnitRoundoff = 0x1p-53;
/// Of scaled sums, whose largest terms have the size of one, with speeds up to the second.
constexpr double kUnderflow = 0x1p-600;
constexpr double kLargestSpeed = 0x1p300;
constexpr double kTiny = 0x1p-1000;

/// Of finds_separation(): how far beyond its bound each edge is to be, of the fastest approach.
constexpr double kBeyond = 0.01;
constexpr int kSweepsPerTest = 10;

}  // namespace

/// Whether K'(v + X y) > 0, or K'X y > 0, by more than the rounding in these sums, for the dual solution y. What
/// products lose to underflow is less than the rounding of kTiny.
bool ContactSolvability::lifts_all(const Program<double>& program, bool from_v) {
  const Index ngc = X_->rows();
  auto lift = lift_.head(ngc);
  auto terms = lift_terms_.head(ngc);
  lift.setZero();
  if (from_v) lift = Eigen::Map<const Vector>(v_, ngc);
  terms = lift.cwiseAbs();
  for (Index k = 0; k < X_->cols(); ++k) {
    const double dual = program.costs()[program.edges + k] - (program.first_phase ? 1.0 : 0.0);
    const int exponent = row_exponent_[static_cast<std::size_t>(k)] - (from_v ? cost_exponent_ : 0);
    const double y = scaled(dual, exponent);
    if (!(std::abs(y) < std::numeric_limits<double>::infinity())) return false;
    if (dual != 0 && std::abs(y) < std::numeric_limits<double>::min()) return false;
    lift += y * X_->col(k);
    terms += std::abs(y) * X_->col(k).cwiseAbs();
  }
  return separates_all();
}

/// Whether K' lift_ > 0 by more than the rounding in these sums, and in lift_, of which lift_terms_ has the terms.
bool ContactSolvability::separates_all() const {
  const double rounding = 4 * kUnitRoundoff * static_cast<double>(2 * X_->rows() + X_->cols() + 8);
  return std::all_of(edges_.begin(), edges_.end(), [&](const Edge& edge) {
    double sum = 0;
    double size = 0;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const double weight = factor * entry;
      sum += weight * lift_(i);
      size += (std::abs(weight) + kTiny) * (lift_terms_(i) + kTiny);
    });
    return size > 1e-250 && size < 1e250 && sum > rounding * size;
  });
}

/// Whether K'X y > 0 for the dual solution y of the first phase, each edge by more than the rounding of its sum. The
/// basis of X's range is known to within `rounding` of its rows. The value of the program is no test: where mu is
/// large, the edges of a cone are nearly opposite, and pivots of the size of rounding may lift them.
bool ContactSolvability::lifts_all(const Program<Quad>& program, Quad rounding) const {
  for (Index j = 0; j < program.edges; ++j) {
    const Edge& edge = edges_[static_cast<std::size_t>(j)];
    const int exponent = column_exponent_[static_cast<std::size_t>(j)];
    Quad sum = 0;
    Quad terms = 0;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const Quad weight = scaled(static_cast<Quad>(entry) * static_cast<Quad>(factor), exponent);
      Quad lift = 0;
      Quad duals = 0;
      Quad largest = 0;
      for (Index k = 0; k < program.rows - 1; ++k) {
        const Quad dual = program.costs()[program.edges + k] - 1;
        const Quad entry_of_X = reach(i, k, Quad()) * static_cast<Quad>(row_scale_[static_cast<std::size_t>(k)]);
        lift += dual * entry_of_X;
        duals += magnitude(dual);
        largest = std::max(largest, magnitude(entry_of_X));
      }
      sum += weight * lift;
      terms += magnitude(weight) * duals * largest;
    });
    if (!(sum > rounding * terms)) return false;
  }
  return true;
}

/// Whether a velocity is found at which all edges separate. It starts from v and is projected on one edge after the
/// other, each a little beyond its bound. Only with an offset and G given by its entries: the impulses then reach every
/// velocity, which ends in the speed 1 of the offset. Steps are exact where N and D of a contact are orthogonal.
/// O(sparse entries of the edges) per sweep. [Hildreth 1957]
bool ContactSolvability::finds_separation(double deadline_s, Index sweeps) {
  if (!reaches_all_velocities_) return false;
  const Index offset = X_->rows() - 1;
  auto lift = lift_.head(offset + 1);
  lift = Eigen::Map<const Vector>(v_, offset + 1);
  edge_norms_.setZero();
  edge_shares_.setZero();
  double most = 0;
  for (std::size_t j = 0; j < edges_.size(); ++j) {
    const Edge& edge = edges_[j];
    double speed = 0;
    const auto add_square = [&](Index i, double entry, double factor) {
      speed += factor * entry * lift(i);
      if (i < offset) edge_norms_(static_cast<Index>(j)) += factor * factor * entry * entry;
    };
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, add_square);
    most = std::max(most, -speed);
  }
  const double beyond = kBeyond * most;
  for (Index sweep = 0; sweep < sweeps; ++sweep) {
    for (std::size_t j = 0; j < edges_.size(); ++j) project_on_edge(static_cast<Index>(j), beyond);
    if (sweep % kSweepsPerTest != kSweepsPerTest - 1) continue;
    lift_terms_.head(offset + 1) = lift.cwiseAbs();
    if (separates_all()) return true;
    if (!(wall_clock_s() < deadline_s)) return false;
  }
  return false;
}

void ContactSolvability::project_on_edge(Index j, double beyond) {
  const Edge& edge = edges_[static_cast<std::size_t>(j)];
  const Index offset = X_->rows() - 1;
  double speed = 0;
  visit_edge(*contact_, edge.contact, edge.direction, edge.factor,
             [&](Index i, double entry, double factor) { speed += factor * entry * lift_(i); });
  if (!(edge_norms_(j) > 0)) return;
  const double step = std::max(-edge_shares_(j), (beyond - speed) / edge_norms_(j));
  edge_shares_(j) += step;
  if (step == 0) return;
  visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
    if (i < offset) lift_(i) += step * factor * entry;
  });
}

/// The columns of the basis and their costs from the data, scaled as the program has them.
void ContactSolvability::load_basis(const Program<double>& program) {
  for (Index r = 0; r < program.rows; ++r) {
    const Edge& edge = edges_[static_cast<std::size_t>(basis_[static_cast<std::size_t>(r)])];
    const int exponent = column_exponent_[static_cast<std::size_t>(basis_[static_cast<std::size_t>(r)])];
    auto column = basis_columns_.col(r).head(program.rows);
    auto terms = basis_terms_.col(r).head(program.rows);
    column.setZero();
    terms.setZero();
    basis_costs_(r) = basis_cost_terms_(r) = 0;
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const double weight = scaled(entry * factor, exponent);
      for (Index k = 0; k < X_->cols(); ++k) {
        const double term = weight * ((*X_)(i, k) * row_scale_[static_cast<std::size_t>(k)]);
        column(k) += term;
        terms(k) += std::abs(term);
      }
      const double cost = scaled(entry * factor, exponent + cost_exponent_) * v_[i];  // `weight` may have underflowed
      basis_costs_(r) += cost;
      basis_cost_terms_(r) += std::abs(cost);
    });
    column(program.rows - 1) = terms(program.rows - 1) = 1;
  }
}

/// Whether B u = e certainly has a solution u > 0 with v'K u < 0. B holds the exact columns of the last basis, e is the
/// last unit vector, and u~ is the computed u. The artificial variables' columns of the tableau are R, the inverse of B
/// up to rounding. If |I - R B| < 1, B is regular, and u differs from u~ by at most |R| |B u~ - e| / (1 - |I - R B|).
/// [Rump 1983]
bool ContactSolvability::proves_unsolvable(const Program<double>& program) {
  const Index rows = program.rows;
  if (std::any_of(basis_.begin(), basis_.end(), [&](Index j) { return j >= program.edges; })) return false;
  if (std::any_of(v_, v_ + X_->rows(), [](double speed) { return !(std::abs(speed) < kLargestSpeed); })) return false;
  load_basis(program);
  const double sums = 4 * kUnitRoundoff * static_cast<double>(X_->rows() + rows + 4);
  double missed = 0;
  for (Index k = 0; k < rows; ++k) {
    double sum = k == rows - 1 ? -1 : 0;
    double terms = 1;
    for (Index j = 0; j < rows; ++j) {
      sum += basis_columns_(k, j) * program.row(j)[program.right()];
      terms += basis_terms_(k, j) * std::abs(program.row(j)[program.right()]);
    }
    missed = std::max(missed, std::abs(sum) + sums * terms);
  }
  double inverse = 0;
  double off_unit = 0;
  for (Index r = 0; r < rows; ++r) {
    const double* const of_inverse = program.row(r) + program.edges;
    double size = 0;
    double off = 0;
    for (Index k = 0; k < rows; ++k) size += std::abs(of_inverse[k]);
    for (Index j = 0; j < rows; ++j) {
      double sum = j == r ? -1 : 0;
      double terms = 1;
      for (Index k = 0; k < rows; ++k) {
        sum += of_inverse[k] * basis_columns_(k, j);
        terms += std::abs(of_inverse[k]) * basis_terms_(k, j);
      }
      off += std::abs(sum) + sums * terms;
    }
    inverse = std::max(inverse, size);
    off_unit = std::max(off_unit, off);
    if (!(size < 1e100 && off < 0.5)) return false;
  }
  const double off = 1.1 * (inverse * missed / (1 - off_unit) + kUnderflow);
  double value = 0;
  double rounding = kUnderflow;
  for (Index r = 0; r < rows; ++r) {
    const double share = program.row(r)[program.right()];
    if (!(share > off)) return false;
    value += basis_costs_(r) * share;
    rounding += basis_cost_terms_(r) * (off + sums * share);
  }
  return value < -1.1 * rounding;
}

/// Whether the normals whose shares in the last basis are above `noise` prove that there is no solution. Keeps the
/// proof.
bool ContactSolvability::proves_unsolvable(const Program<Quad>& program, Quad noise) {
  support_.clear();
  for (Index r = 0; r < program.rows; ++r) {
    const Index j = basis_[static_cast<std::size_t>(r)];
    if (j >= program.edges || !(program.row(r)[program.right()] > noise)) continue;
    support_.push_back(edges_[static_cast<std::size_t>(j)].contact);
  }
  if (!farkas_support_.proves_unsolvable(*contact_, *X_, v_, support_)) return false;
  take_proof(program);
  return true;
}

/// Whether K'(v + X y) >= 0 for the dual solution y, each edge to within the rounding of its own sum.
bool ContactSolvability::holds_to_rounding(const Program<Quad>& program, Quad rounding) {
  for (Index j = 0; j < program.edges; ++j) {
    const Edge& edge = edges_[static_cast<std::size_t>(j)];
    const int exponent = column_exponent_[static_cast<std::size_t>(j)];
    Quad sum = costs_[static_cast<std::size_t>(j)];
    Quad terms = cost_terms_[static_cast<std::size_t>(j)];
    visit_edge(*contact_, edge.contact, edge.direction, edge.factor, [&](Index i, double entry, double factor) {
      const Quad weight = scaled(static_cast<Quad>(entry) * static_cast<Quad>(factor), exponent);
      for (Index k = 0; k < program.rows - 1; ++k) {
        const Quad dual = program.costs()[program.edges + k];
        const Quad term = weight * reach(i, k, Quad()) * static_cast<Quad>(row_scale_[static_cast<std::size_t>(k)]);
        sum += dual * term;
        terms += magnitude(dual * term);
      }
    });
    if (!(sum >= -rounding * terms)) return false;
  }
  return true;
}

/// Small integers where there are such in the same proportion.
template <class Scalar>
void ContactSolvability::take_proof(const Program<Scalar>& program) {
  constexpr double kLargest = 0x1p20;
  constexpr Quad kNearInteger = sizeof(Scalar) == sizeof(double) ? 0x1p-36 : 0x1p-40;
  auto proof = proof_.head(contact_->nc());
  proof.setZero();
  const auto share = [&](Index r) {
    const Index j = basis_[static_cast<std::size_t>(r)];
    if (j >= program.edges || !(program.row(r)[program.right()] > kNoise<Scalar>)) return Quad{0};
    return scaled(static_cast<Quad>(program.row(r)[program.right()]), column_exponent_[static_cast<std::size_t>(j)]);
  };
  Quad least = 0;
  for (Index r = 0; r < program.rows; ++r) {
    if (share(r) > 0 && (least == 0 || share(r) < least)) least = share(r);
  }
  for (Index r = 0; r < program.rows; ++r) {
    if (!(share(r) > 0)) continue;
    const Quad ratio = share(r) / least;
    const double near = std::round(to_double(ratio));
    const bool is_integer = near <= kLargest && magnitude(ratio - static_cast<Quad>(near)) <= kNearInteger * ratio;
    proof(edges_[static_cast<std::size_t>(basis_[static_cast<std::size_t>(r)])].contact) =
        is_integer ? near : to_double(ratio);
  }
}

void ContactSolvability::write_proof(Eigen::Ref<Vector> u) const { u = proof_.head(u.size()); }

template void ContactSolvability::take_proof(const Program<double>& program);
template void ContactSolvability::take_proof(const Program<Quad>& program);

}  // namespace lcpbench
