#include "native/auto/rest.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <variant>

#include "core/entries.h"
#include "native/contacts/contact_impulses.h"

namespace lcpbench {
namespace {

/// Sweeps of projections. If contacts are few, the first ones make each contact that approached at first part at
/// kParting times that speed, from either side, which mostly is enough. The others, over-relaxed, push apart what still
/// approaches: the angles between the contacts of a pile are narrow. Contacts that did not approach at first part at
/// kLeastNeed of the fastest ones.
constexpr int kFirstSweeps = 3, kMaxSweeps = 24;
constexpr Index kFewContacts = 8;
constexpr double kParting = 0.1, kLeastNeed = 0.1, kRelaxation = 1.7;
/// Of single bodies: sweeps, and how far the projections go beyond.
constexpr int kSweepsOfBodies = 4;
constexpr double kBeyond = 1.5;
/// It gives up where so many sweeps leave more than this part of what approaches.
constexpr int kSweepsToFall = 4;
constexpr double kFalling = 0.85;
/// Largest order, and pivot relative to the largest one that counts as zero, of the range of impulses.
constexpr Index kLargestRange = 60;
constexpr double kNoPivot = 1e-9;
/// What a coordinate may miss of its own terms, if more than rounding is missing beside the largest terms of its body:
/// a tenth of what the verdict allows between impulses and velocity.
constexpr double kAgrees = 1e-5;
/// Products of this size have all their digits, and so have sums with smaller ones.
constexpr double kLeastTerm = 0x1p-900;
/// Of may_hold().
constexpr double kFastestNear = 1e-5;
/// Least y'G v of a proof, over |y|'|G v|.
constexpr double kLeastMomentum = 1e-9;
/// Of Cholesky's method, over the diagonal of G.
constexpr double kLeastPivot = 1e-13;

}  // namespace

bool Rest::takes(const ContactProblem& contact) {
  return !contact.is_soft() && (std::holds_alternative<BlockInertia>(contact.inertia) ||
                                std::holds_alternative<DenseInertia>(contact.inertia));
}

void Rest::load(const ContactProblem& contact, const Vector& v) {
  contact_ = &contact;
  v_ = &v;
  const Index ngc = contact.ngc();
  room_.setZero(ngc, kParts);
  Index next = 0;
  for (Coordinates* part : {&momentum_, &mass_, &moves_, &y_, &magnitude_, &column_}) {
    new (part) Coordinates(room_.col(next++).data(), ngc);
  }
  for_each_matrix(contact.inertia, [this](const Matrix& block, Index) {
    if (block.rows() > factor_.rows()) factor_.resize(block.rows(), block.rows());
  });
  double least_offset = 0;
  fastest_ = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    double speed = contact.offset(c);
    for_each_entry(contact.N, c, [&](Index row, double entry) {
      speed += entry * v(row);
      moves_(row) = 1;
    });
    fastest_ = max_or_infinity(fastest_, std::abs(speed));
    least_offset = std::min(least_offset, contact.offset(c));
  }
  touching_ = kTouching * fastest_;
  is_possible_ = -least_offset <= touching_ && fastest_ < std::numeric_limits<double>::infinity();
  if (is_possible_ && has_free_momentum()) is_possible_ = false;
  if (!is_possible_) return;
  for_each_matrix(contact.inertia, [&](const Matrix& block, Index first) {
    const Index size = block.rows();
    if (size == 0) return;
    const bool is_moved = moves_.segment(first, size).maxCoeff() > 0;
    moves_.segment(first, size).setConstant(is_moved ? 1 : 0);
    mass_.segment(first, size) = block.diagonal();
    if (!is_moved) return;
    momentum_.segment(first, size).noalias() = block * v.segment(first, size);
    // What underflows is no balance.
    for (Index i = first; i < first + size; ++i) {
      const double term = std::abs(mass_(i) * v(i));
      is_possible_ = is_possible_ && (v(i) == 0 || term >= kLeastTerm);
    }
  });
}

/// Of an inertia that is one matrix: whether a coordinate that no contact moves has momentum, which none can take away.
/// @pre moves_ tells which coordinates the normals move
bool Rest::has_free_momentum() {
  const Matrix* inertia = nullptr;
  if (const auto* dense = std::get_if<DenseInertia>(&contact_->inertia)) inertia = &dense->G;
  if (const auto* bodies = std::get_if<BlockInertia>(&contact_->inertia)) {
    if (bodies->blocks.size() == 1) inertia = &bodies->blocks.front();
  }
  if (inertia == nullptr || inertia->rows() == 0 || moves_.minCoeff() > 0) return false;
  Index direction = 0;
  for (const Index edges : contact_->edges) {
    for (Index t = direction; t < direction + edges / 2; ++t) {
      for_each_entry(contact_->D, t, [this](Index row, double) { moves_(row) = 1; });
    }
    direction += edges;
  }
  for (Index i = 0; i < moves_.size(); ++i) {
    if (moves_(i) > 0) continue;
    const auto row = inertia->col(i);
    if (std::abs(row.dot(*v_)) > kLeastMomentum * row.cwiseAbs().dot(v_->cwiseAbs())) return true;
  }
  return false;
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
  return std::abs(sum) <= kFastestNear * magnitude;
}

double Rest::imbalance(const Vector& z) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (!is_possible_ || !z.allFinite()) return kInfinity;
  Coordinates& sum = y_;
  sum = momentum_;
  magnitude_ = momentum_.cwiseAbs();
  const auto add = [&](const Jacobian& J, Index column, double impulse) {
    if (impulse == 0) return;
    for_each_entry(J, column, [&](Index row, double entry) {
      sum(row) += entry * impulse;
      magnitude_(row) += std::abs(entry * impulse);
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
    if (friction > (1 + kRounding) * contact_->mu(c) * z(c)) return kInfinity;
    direction += edges;
  }
  double worst = 0;
  for_each_matrix(contact_->inertia, [&](const Matrix& block, Index first) {
    if (block.rows() == 0) return;
    const auto roots = block.diagonal().array().sqrt();
    const double magnitude = (magnitude_.segment(first, block.rows()).array() / roots).maxCoeff();
    const double missing = (sum.segment(first, block.rows()).array().abs() / roots).maxCoeff();
    if (missing != 0) worst = max_or_infinity(worst, missing / magnitude);
  });
  const bool agrees = (sum.array().abs() <= kAgrees * magnitude_.array()).all();
  return agrees || worst <= kRounding ? worst : std::max(worst, 2 * kBalanced);
}

double Rest::residual_speed() {
  for (Index i = 0; i < y_.size(); ++i) y_(i) = y_(i) == 0 ? 0 : y_(i) / mass_(i);
  double fastest = 0;
  const auto add = [&](const Jacobian& J) {
    for (Index c = 0; c < cols(J); ++c) {
      double speed = 0;
      for_each_entry(J, c, [&](Index row, double entry) { speed += entry * y_(row); });
      fastest = max_or_infinity(fastest, std::abs(speed));
    }
  };
  add(contact_->N);
  add(contact_->D);
  return fastest / fastest_;
}

/// y += mass^-1 a missing / (a'mass^-1 a), a = N + factor d: then a'y has grown by what is missing.
template <class Normals, class Directions, class Body>
void Rest::push(const Normals& N, const Directions& D, Index contact, Body body, Index direction, double factor,
                double missing) {
  rows_.clear();
  const auto add = [&](double times) {
    return [this, times, body](Index row, double entry) {
      if (!body.contain(row)) return;
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

/// The least (N + mu d)'y of the contact over its directions d, of a body's coordinates. @param direction the contact's
/// first; becomes that d
/// @param factor becomes mu, with the sign of d
template <class Normals, class Directions, class Body>
double Rest::parting(const Normals& N, const Directions& D, Index contact, Body body, Index& direction,
                     double& factor) const {
  const auto speed = [this, body](const auto& J, Index column) -> double {
    if constexpr (std::is_same_v<Body, AllRows>) return J.col(column).dot(y_);
    double sum = 0;
    for_each_entry(J, column, [&](Index row, double entry) { sum += body.contain(row) ? entry * y_(row) : 0; });
    return sum;
  };
  const double mu = contact_->mu(contact);
  const Index end = direction + (mu > 0 ? contact_->edges[static_cast<std::size_t>(contact)] / 2 : 0);
  double slip = 0;
  for (Index t = direction; t < end; ++t) {
    const double along = speed(D, t);
    if (std::abs(along) <= std::abs(slip)) continue;
    slip = along;
    direction = t;
  }
  factor = slip == 0 ? 0 : std::copysign(mu, -slip);
  return speed(N, contact) - mu * std::abs(slip);
}

template <class Normals, class Directions>
bool Rest::refutes(const Normals& N, const Directions& D) {
  const auto nc = static_cast<std::size_t>(contact_->nc());
  const int first_sweeps = contact_->nc() <= kFewContacts ? kFirstSweeps : 0;
  double largest_need = 0;
  const double gone_before = y_.dot(momentum_);
  double missing_then = 0;  // what the contacts approached in all, kSweepsToFall sweeps ago
  for (int sweep = 0; sweep <= kMaxSweeps; ++sweep) {
    double missing = 0;
    double share = 0;  // of the way from the first y to this one on which all contacts part
    Index direction = 0;
    for (std::size_t c = 0; c < nc; ++c) {
      const auto contact = static_cast<Index>(c);
      if (touches(contact)) {
        Index fastest = direction;
        double factor = 0;
        const double now = parting(N, D, contact, AllRows{}, fastest, factor);
        if (sweep == 0) {
          needs_[c] = std::max(-now, 0.0);
          largest_need = std::max(largest_need, needs_[c]);
        } else if (now >= 0) {
          if (needs_[c] > 0) share = std::max(share, needs_[c] / (needs_[c] + now));
        } else {
          share = 2;  // not yet
          missing -= now;
        }
        const double target = kParting * (needs_[c] > 0 ? needs_[c] : kLeastNeed * largest_need);
        const bool pushes = now < 0 || (needs_[c] > 0 && sweep <= first_sweeps);
        const double step = (sweep <= first_sweeps ? 1 : kRelaxation) * (target - now);
        if (sweep > 0 && pushes) push(N, D, contact, AllRows{}, fastest, factor, step);
      }
      direction += contact_->edges[c];
    }
    if (sweep > 0 && sweep % kSweepsToFall == 0) {
      if (missing > kFalling * missing_then && sweep > first_sweeps + kSweepsToFall) return false;
      missing_then = missing;
    }
    if (sweep == 0 || share > 1) continue;
    const double gone = (1 - share) * gone_before + share * y_.dot(momentum_);
    if (gone > kLeastMomentum * y_.cwiseAbs().dot(momentum_.cwiseAbs())) return true;
  }
  return false;
}

bool Rest::has_several_bodies() const {
  const auto* bodies = std::get_if<BlockInertia>(&contact_->inertia);
  return bodies != nullptr && bodies->blocks.size() > 1;
}

/// Into parts_; magnitude_ becomes 1 for the coordinates of bodies that a contact touches, else 0.
template <class Normals, class Directions>
void Rest::find_parts(const Normals& N, const Directions& D) {
  parts_.clear();
  for_each_matrix(contact_->inertia, [&](const Matrix& block, Index first) {
    for (Index row = first; row < first + block.rows(); ++row) column_(row) = static_cast<double>(first + block.rows());
  });
  magnitude_.setZero();
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index edges = contact_->edges[static_cast<std::size_t>(c)];
    const std::size_t first_part = parts_.size();
    const auto add = [&](Index row, double) {
      const bool is_known = std::any_of(parts_.begin() + static_cast<std::ptrdiff_t>(first_part), parts_.end(),
                                        [row](const Part& part) { return part.body.contain(row); });
      if (is_known) return;
      Index first = row;
      const auto last = static_cast<Index>(column_(row));
      while (first > 0 && column_(first - 1) == column_(row)) --first;
      parts_.push_back({.contact = c, .direction = direction, .body = {.first = first, .last = last}});
      magnitude_.segment(first, last - first).setOnes();
    };
    if (touches(c)) {
      for_each_entry(N, c, add);
      for (Index t = direction; t < direction + edges / 2; ++t) for_each_entry(D, t, add);
    }
    direction += edges;
  }
  column_.setZero();
}

/// Whether the contacts of some body cannot hold it, even if all others stay at rest.
template <class Normals, class Directions>
bool Rest::refutes_a_body(const Normals& N, const Directions& D) {
  find_parts(N, D);
  const auto is_free = moves_.array() > 0 && magnitude_.array() == 0;
  if ((is_free && momentum_.array().abs() > 0).any()) return true;
  y_ = *v_;
  for (int sweep = 0; sweep <= kSweepsOfBodies; ++sweep) {
    magnitude_.setZero();  // 1 where a contact of the body approaches
    for (const Part& part : parts_) {
      Index direction = part.direction;
      double factor = 0;
      const double now = parting(N, D, part.contact, part.body, direction, factor);
      if (now >= 0) continue;
      magnitude_.segment(part.body.first, part.body.last - part.body.first).setOnes();
      if (sweep < kSweepsOfBodies) push(N, D, part.contact, part.body, direction, factor, -kBeyond * now);
    }
    bool is_refuted = false;
    for_each_matrix(contact_->inertia, [&](const Matrix& block, Index first) {
      const Index size = block.rows();
      if (is_refuted || size == 0 || moves_(first) == 0 || magnitude_(first) > 0) return;
      const auto y = y_.segment(first, size), momentum = momentum_.segment(first, size);
      is_refuted = y.dot(momentum) > kLeastMomentum * y.cwiseAbs().dot(momentum.cwiseAbs());
    });
    if (is_refuted) return true;
  }
  return false;
}

/// Whether few contacts leave some direction of momentum alone, in which there is momentum.
bool Rest::is_out_of_range() const {
  Index rows = 0, direction = 0;
  const auto count = static_cast<Index>(moves_.sum());
  for (Index c = 0; c < contact_->nc(); ++c) {
    if (touches(c)) rows += 1 + contact_->edges[static_cast<std::size_t>(c)] / 2;
  }
  if (rows == 0 || rows > count || count > kLargestRange) return false;
  Matrix range = Matrix::Zero(contact_->ngc(), rows);
  Index column = 0;
  const auto add = [&](const Jacobian& J, Index of) {
    for_each_entry(J, of, [&](Index row, double entry) { range(row, column) = entry / std::sqrt(mass_(row)); });
    const double length = range.col(column).norm();
    if (length > 0) range.col(column) /= length;
    ++column;
  };
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index edges = contact_->edges[static_cast<std::size_t>(c)];
    if (touches(c)) {
      add(contact_->N, c);
      for (Index t = 0; t < edges / 2; ++t) add(contact_->D, direction + t);
    }
    direction += edges;
  }
  Eigen::ColPivHouseholderQR<Matrix> factors(range.rows(), range.cols());
  factors.setThreshold(kNoPivot).compute(range);
  const Vector momentum = (momentum_.array() * (mass_.array() > 0).select(mass_.array().rsqrt(), 0)).matrix();
  const Vector rotated = factors.householderQ().adjoint() * momentum;
  return rotated.tail(rotated.size() - factors.rank()).norm() > kLeastMomentum * momentum.norm();
}

bool Rest::is_refuted(const Vector& near) {
  if (!is_possible_) return true;
  needs_.resize(contact_->edges.size());
  const bool parts = std::visit(
      [&](const auto& N, const auto& D) {
        y_ = near;
        return refutes(N, D) || (has_several_bodies() && refutes_a_body(N, D));
      },
      contact_->N, contact_->D);
  return parts || is_out_of_range();
}

double Rest::ratio_of_masses() const {
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  for (Index i = 0; i < mass_.size(); ++i) {
    if (moves_(i) == 0) continue;
    least = std::min(least, mass_(i));
    largest = std::max(largest, mass_(i));
  }
  return largest / least;
}

void Rest::bring_into_cones(Vector& z) const {
  Index direction = contact_->nc();
  for (Index c = 0; c < contact_->nc(); ++c) {
    auto friction = z.segment(direction, contact_->edges[static_cast<std::size_t>(c)]);
    z(c) = touches(c) ? std::max(z(c), 0.0) : 0;
    friction = friction.cwiseMax(0.0);
    const double sum = friction.sum(), upper_bound = contact_->mu(c) * z(c);
    if (sum > upper_bound) friction *= upper_bound / sum;
    direction += friction.size();
  }
}

bool Rest::is_inertia_regular() {
  bool regular = true;
  for_each_matrix(contact_->inertia, [&](const Matrix& block, Index) {
    if (!regular || block.rows() == 0) return;
    Eigen::Ref<Matrix> factor = factor_.topLeftCorner(block.rows(), block.rows());
    factor = block;
    const Eigen::LLT<Eigen::Ref<Matrix>> factors(factor);
    const auto pivots = factor.diagonal().array();
    regular = factors.info() == Eigen::Success && (pivots * pivots > kLeastPivot * block.diagonal().array()).all();
  });
  return regular;
}

void Rest::write_velocity(AnswerVector& u) {
  if (!is_inertia_regular()) return u.resize(0);
  u = (moves_.array() > 0).select(0.0, *v_);
}

}  // namespace lcpbench
