#include "native/auto/rest.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "core/entries.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

/// Roundings that the balance of a coordinate may lose, relative to the magnitudes that it sums up.
constexpr double kBalanceRounding = 64 * std::numeric_limits<double>::epsilon();

/// Sweeps of projections, and how far each makes a contact part that should not approach, over the fastest velocity
/// at a contact.
constexpr int kMostSweeps = 12;
constexpr double kParting = 0.02;
/// Least y'G v of a proof, over |y|'|G v|.
constexpr double kLeastMomentum = 1e-9;

}  // namespace

bool Rest::takes(const ContactProblem& contact) {
  return !contact.is_soft() && (std::holds_alternative<BlockInertia>(contact.inertia) ||
                                std::holds_alternative<DenseInertia>(contact.inertia));
}

void Rest::load(const ContactProblem& contact, const Vector& v) {
  contact_ = &contact;
  v_ = v;
  const Index ngc = contact.ngc();
  for (Vector* vector : {&momentum_, &magnitude_, &mass_, &sum_, &magnitudes_, &column_}) vector->setZero(ngc);
  moves_.assign(static_cast<std::size_t>(ngc), 0);
  rows_.reserve(static_cast<std::size_t>(ngc));
  double fastest = 0, least_offset = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    double speed = contact.offset(c);
    for_each_entry(contact.N, c, [&](Index row, double entry) {
      speed += entry * v(row);
      moves_[static_cast<std::size_t>(row)] = 1;
    });
    fastest = max_or_infinity(fastest, std::abs(speed));
    least_offset = std::min(least_offset, contact.offset(c));
  }
  touching_ = kTouching * fastest;
  is_possible_ = -least_offset <= touching_ && fastest < std::numeric_limits<double>::infinity();
  if (!is_possible_) return;
  for_each_matrix(contact.inertia, [&](const Matrix& block, Index first) {
    const Index size = block.rows();
    char* const moves = moves_.data() + first;
    const bool is_moved = std::any_of(moves, moves + size, [](char moves_it) { return moves_it != 0; });
    std::fill(moves, moves + size, is_moved ? 1 : 0);
    mass_.segment(first, size) = block.diagonal();
    if (!is_moved) return;
    momentum_.segment(first, size).noalias() = block * v.segment(first, size);
    magnitude_.segment(first, size).noalias() = block.cwiseAbs() * v.segment(first, size).cwiseAbs();
  });
}

bool Rest::may_hold(const ContactProblem& contact, const Vector& v, const Vector& z) {
  Index fastest = 0;
  if (v.size() == 0 || !(v.cwiseAbs().maxCoeff(&fastest) > 0)) return false;
  double sum = 0, magnitude = 0;
  const auto add = [&](double term) {
    sum += term;
    magnitude += std::abs(term);
  };
  for_each_matrix(contact.inertia, [&](const Matrix& block, Index first) {
    if (fastest < first || fastest >= first + block.rows()) return;
    for (Index i = 0; i < block.rows(); ++i) add(block(i, fastest - first) * v(first + i));
  });
  const auto add_impulses = [&](const Jacobian& J, Index first) {
    if (const auto* dense = std::get_if<Matrix>(&J)) {
      for (Index c = 0; c < dense->cols(); ++c) add((*dense)(fastest, c) * z(first + c));
      return;
    }
    const auto& sparse = std::get<SparseMatrix>(J);
    for (Index c = 0; c < sparse.cols(); ++c) {
      if (z(first + c) != 0) add(sparse.coeff(fastest, c) * z(first + c));
    }
  };
  add_impulses(contact.N, 0);
  add_impulses(contact.D, contact.nc());
  return std::abs(sum) <= kNear * magnitude;
}

double Rest::imbalance(const Vector& z) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!is_possible_ || !z.allFinite()) return kInfinity;
  sum_ = momentum_;
  magnitudes_ = magnitude_;
  const auto add = [&](const Jacobian& J, Index column, double impulse) {
    if (impulse == 0) return;
    for_each_entry(J, column, [&](Index row, double entry) {
      sum_(row) += entry * impulse;
      magnitudes_(row) += std::abs(entry * impulse);
    });
  };
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index edges = contact_->edges[static_cast<std::size_t>(c)];
    if (z(c) < 0 || (z(c) > 0 && !touches(c))) return kInfinity;
    add(contact_->N, c, z(c));
    double friction = 0;
    for (Index t = direction; t < direction + edges; ++t) {
      const double impulse = z(contact_->nc() + t);
      if (impulse < 0) return kInfinity;
      friction += impulse;
      add(contact_->D, t, impulse);
    }
    if (friction > (1 + kBalanceRounding) * contact_->mu(c) * z(c)) return kInfinity;
    direction += edges;
  }
  double worst = 0;
  for_each_matrix(contact_->inertia, [&](const Matrix& block, Index first) {
    const auto roots = block.diagonal().array().sqrt();
    const double magnitude = (magnitudes_.segment(first, block.rows()).array() / roots).maxCoeff();
    const double missing = (sum_.segment(first, block.rows()).array().abs() / roots).maxCoeff();
    if (missing != 0) worst = max_or_infinity(worst, missing / magnitude);
  });
  return worst;
}

bool Rest::holds(const Vector& z) { return imbalance(z) <= kBalanceRounding; }

/// y += mass^-1 a missing / (a'mass^-1 a), a = N + factor d: then a'y has grown by what is missing.
template <class Normals, class Directions>
void Rest::push(const Normals& N, const Directions& D, Index contact, Index direction, double factor, double missing) {
  rows_.clear();
  const auto add = [&](double times) {
    return [this, times](Index row, double entry) {
      if (column_(row) == 0) rows_.push_back(row);
      column_(row) += times * entry;
    };
  };
  for_each_entry(N, contact, add(1));
  if (factor != 0) for_each_entry(D, direction, add(factor));
  double squared = 0;
  for (const Index row : rows_) squared += column_(row) * column_(row) / mass_(row);
  for (const Index row : rows_) {
    if (squared > 0) y_(row) += missing / squared * column_(row) / mass_(row);
    column_(row) = 0;
  }
}

/// A sweep over the touching contacts. @returns whether none approached along an edge of its cone before it
template <class Normals, class Directions>
bool Rest::widen(const Normals& N, const Directions& D, double target) {
  const auto speed = [this](const auto& J, Index column) {
    double sum = 0;
    for_each_entry(J, column, [&](Index row, double entry) { sum += entry * y_(row); });
    return sum;
  };
  bool parts = true;
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index edges = contact_->edges[static_cast<std::size_t>(c)];
    if (touches(c)) {
      Index fastest = direction;
      double slip = 0;
      for (Index t = direction; t < direction + edges / 2; ++t) {
        const double along = speed(D, t);
        if (std::abs(along) <= std::abs(slip)) continue;
        slip = along;
        fastest = t;
      }
      const double factor = slip > 0 ? -contact_->mu(c) : contact_->mu(c);
      const double parting = speed(N, c) - contact_->mu(c) * std::abs(slip);
      if (!(parting >= 0)) {
        parts = false;
        push(N, D, c, fastest, slip == 0 ? 0 : factor, target - parting);
      }
    }
    direction += edges;
  }
  return parts;
}

bool Rest::is_refuted(const Vector& near) {
  if (!is_possible_) return true;
  y_ = near;
  double fastest = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    fastest = std::max(fastest, std::abs(dot_column(contact_->N, c, near)));
  }
  for (Index t = 0; t < cols(contact_->D); ++t) {
    fastest = std::max(fastest, std::abs(dot_column(contact_->D, t, near)));
  }
  return std::visit(
      [&](const auto& N, const auto& D) {
        for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
          const double gone = y_.dot(momentum_);
          if (!(gone > kLeastMomentum * y_.cwiseAbs().dot(momentum_.cwiseAbs()))) return false;
          if (widen(N, D, kParting * fastest)) return true;
        }
        return false;
      },
      contact_->N, contact_->D);
}

void Rest::write_velocity(AnswerVector& u) const {
  u = v_;
  for (std::size_t i = 0; i < moves_.size(); ++i) {
    if (moves_[i] != 0) u(static_cast<Index>(i)) = 0;
  }
}

}  // namespace lcpbench
