#include "native/active_set/least_energy.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "core/isa.h"
#include "core/timed_solve.h"
#include "native/active_set/active_set.h"
#include "native/contacts/dense_data.h"

namespace lcpbench {
namespace {

using active_set::Ending;

/// Largest residual that the engine's own test of the projection accepts, relative to the scale.
constexpr double kLargestResidual = 1e-8;

/// Threshold of separates(), relative to the largest normal velocity before the impact: far above the rounding of
/// contacts that hold.
constexpr double kSeparating = 1e-6;

/// Most changes of the active set for each coordinate and contact; usually there is about one for each coordinate.
constexpr Index kStepsPerUnknown = 4;

/// Steps of Newton's method, where contacts yield.
constexpr std::ptrdiff_t kMostNewtonSteps = 30;
/// Residual at which Newton's method ends, relative to the velocities (see squared_scale in dual_method.h). Its last
/// step mostly leaves no more than rounding errors.
constexpr double kNewtonResidual = 1e-10;
/// Least ratio of r_n to M_nn. Rounding leaves impulses a relative error of M_nn / r_n unit round-offs, which exceeds
/// kNewtonResidual below this ratio. takes() has only a low estimate of M_nn, |N_i|^2 / max G_ii; the engine tests M_nn
/// itself.
constexpr double kLeastSoftness = 1e-6;

/// How many friction directions a contact has; none where mu is 0, though D may have columns there.
Index edges_of(const ContactProblem& contact, Index c) {
  return contact.mu(c) > 0 ? contact.edges[static_cast<std::size_t>(c)] : 0;
}

/// How many columns of `Input::N` a contact has. Rigid: one for each edge of its pyramid, or its normal alone. Soft:
/// three, its normal and two tangents, which are zero where it has none.
Index rows_of(const ContactProblem& contact, Index c) {
  const Index edges = edges_of(contact, c);
  return contact.is_soft() ? 3 : std::max<Index>(edges, 1);
}

Index rows_of_all(const ContactProblem& contact) {
  Index sum = 0;
  for (Index c = 0; c < contact.nc(); ++c) sum += rows_of(contact, c);
  return sum;
}

}  // namespace

bool LeastEnergy::takes(const ContactProblem& contact) {
  if (contact.ngc() == 0) return false;
  double heaviest = 0;  // of G's diagonal
  if (const auto* dense = std::get_if<DenseInertia>(&contact.inertia)) {
    heaviest = dense->G.diagonal().maxCoeff();
  } else if (const auto* bodies = std::get_if<BlockInertia>(&contact.inertia)) {
    for (const Matrix& block : bodies->blocks) heaviest = std::max(heaviest, block.diagonal().maxCoeff());
  } else {
    return false;
  }
  const auto yields = [&](Index c) {
    const Index edges = edges_of(contact, c);
    const double squared = std::visit([c](const auto& N) { return N.col(c).squaredNorm(); }, contact.N);
    return contact.normal_compliance(c) * heaviest > kLeastSoftness * squared &&
           (edges == 0 || (edges <= 4 && contact.tangential_compliance(c) > 0));
  };
  for (Index c = 0; c < contact.nc() && contact.is_soft(); ++c) {
    if (!yields(c)) return false;
  }
  return true;
}

double LeastEnergy::work(const ContactProblem& contact, Index idle) {
  const auto ngc = static_cast<double>(contact.ngc() - idle);
  const auto rows = static_cast<double>(rows_of_all(contact));
  return ngc * ngc * (ngc / 6 + rows / 2 + rows + ngc);
}

LeastEnergy::LeastEnergy() : engine_(make_active_set_engine(isa_level())) {}

void LeastEnergy::reserve(const ContactProblem& contact) {
  active_set::Input input;
  input.ngc = contact.ngc();
  input.nc = rows_of_all(contact);
  if (contact.is_soft()) {
    input.soft = input.nc;
    input.mu = contact.mu.data();
    compliance_.reserve(input.nc);
    mu_.reserve(contact.nc());
  }
  engine_->reserve(input);
  columns_.reserve(input.ngc * input.nc);
  if (std::holds_alternative<BlockInertia>(contact.inertia)) inertia_.reserve(input.ngc * input.ngc);
  if (std::holds_alternative<SparseMatrix>(contact.N)) dense_normals_.reserve(input.ngc * contact.nc());
  if (std::holds_alternative<SparseMatrix>(contact.D)) dense_directions_.reserve(input.ngc * cols(contact.D));
  for (GrowingVector* of_edges : {&offsets_, &multipliers_, &farkas_}) of_edges->reserve(input.nc);
  velocity_.reserve(input.ngc);
  z_.reserve(lcp_size(contact));
}

void LeastEnergy::load(const ContactProblem& contact, const Vector& v) {
  contact_ = &contact;
  has_last_ = false;
  active_set::Input input;
  input.ngc = contact.ngc();
  input.nc = rows_of_all(contact);
  columns_.resize(input.ngc * input.nc);
  offsets_.resize(input.nc);
  if (contact.is_soft()) {
    compliance_.resize(input.nc);
    mu_.resize(contact.nc());
    take_rows_of_soft();
    input.soft = input.nc;
    input.compliance = compliance_.data();
    input.mu = mu_.data();
  } else {
    take_columns();
  }
  input.v = v.data();
  input.N = columns_.data();
  if (contact.has_offset() || contact.is_soft()) input.b = offsets_.data();
  if (const auto* dense = std::get_if<DenseInertia>(&contact.inertia)) {
    input.matrix = dense->G.data();
  } else {
    copy_dense(std::get<BlockInertia>(contact.inertia), input.ngc, inertia_);
    input.matrix = inertia_.data();
  }
  engine_->load(input);
  multipliers_.resize(input.nc);
  farkas_.resize(input.nc);
  velocity_.resize(input.ngc);
  z_.resize(lcp_size(contact));
}

/// Writes the edges N_i + mu_i d of the pyramids, or N_i where mu_i is 0, each with the offset of its contact.
void LeastEnergy::take_columns() {
  const Index ngc = contact_->ngc();
  const Eigen::Map<const Matrix> N(dense_data(contact_->N, dense_normals_), ngc, contact_->nc());
  const Eigen::Map<const Matrix> D(dense_data(contact_->D, dense_directions_), ngc, cols(contact_->D));
  Eigen::Map<Matrix> columns = columns_.as_matrix(ngc, offsets_.size());
  Index column = 0;
  Index direction = 0;
  for (Index c = 0; c < contact_->nc(); ++c) {
    const double mu = contact_->mu(c);
    const Index rows = rows_of(*contact_, c);
    for (Index t = 0; t < rows; ++t, ++column) {
      columns.col(column) = N.col(c);
      if (mu > 0) columns.col(column) += mu * D.col(direction + t);
      offsets_.view()(column) = contact_->offset(c);
    }
    direction += contact_->edges[static_cast<std::size_t>(c)];
  }
}

/// Writes normals and tangents, with their offsets and compliance. Tangents that a contact does not have are zero, with
/// a compliance of 1.
void LeastEnergy::take_rows_of_soft() {
  const Index ngc = contact_->ngc();
  const Eigen::Map<const Matrix> N(dense_data(contact_->N, dense_normals_), ngc, contact_->nc());
  const Eigen::Map<const Matrix> D(dense_data(contact_->D, dense_directions_), ngc, cols(contact_->D));
  Eigen::Map<Matrix> columns = columns_.as_matrix(ngc, offsets_.size());
  columns.setZero();
  offsets_.view().setZero();
  compliance_.view().setOnes();
  Index direction = 0;
  for (Index c = 0, row = 0; c < contact_->nc(); ++c, row += 3) {
    const Index tangents = edges_of(*contact_, c) / 2;
    mu_.view()(c) = tangents > 0 ? contact_->mu(c) : 0;
    columns.col(row) = N.col(c);
    offsets_.view()(row) = contact_->offset(c);
    compliance_.view()(row) = contact_->normal_compliance(c);
    for (Index t = 0; t < tangents; ++t) {
      columns.col(row + 1 + t) = D.col(direction + t);
      offsets_.view()(row + 1 + t) = contact_->tangential_offset(c, static_cast<int>(t));
      compliance_.view()(row + 1 + t) = contact_->tangential_compliance(c);
    }
    direction += contact_->edges[static_cast<std::size_t>(c)];
  }
}

bool LeastEnergy::solve(bool warm, double deadline_s, std::int64_t& steps) {
  active_set::Rules rules;
  rules.accept_residual = kLargestResidual;
  rules.max_steps = kStepsPerUnknown * (contact_->ngc() + contact_->nc());
  if (contact_->is_soft()) {
    rules.max_steps = kMostNewtonSteps;
    rules.accept_residual = kNewtonResidual;
  }
  rules.clock_s = wall_clock_s;
  rules.time_limit_s = deadline_s;
  if (warm && has_last_) rules.start = multipliers_.data();
  const active_set::Outcome outcome =
      engine_->solve(rules, multipliers_.data(), velocity_.data(), farkas_.data());
  steps = outcome.steps;
  has_last_ = outcome.ending == Ending::kSolved;
  has_velocity_ = outcome.has_velocity;
  if (has_last_) take_impulses();
  return has_last_;
}

bool LeastEnergy::separates(const Vector& v) const {
  if (!has_velocity_) return false;
  const Eigen::Map<const Matrix> columns(columns_.data(), velocity_.size(), offsets_.size());
  double largest = 0, work = 0, impulse = 0;
  for (Index c = 0, column = 0; c < contact_->nc(); ++c) {
    const Index rows = rows_of(*contact_, c), opposite = column + rows / 2;
    // The mean of opposite edges is the normal.
    const auto speed = [&](const auto& u) {
      return (columns.col(column).dot(u) + columns.col(opposite).dot(u)) / 2 + contact_->offset(c);
    };
    largest = std::max(largest, std::abs(speed(v)));
    if (z_(c) > 0) {
      work += z_(c) * speed(velocity_.view());
      impulse += z_(c);
    }
    column += rows;
  }
  return work > kSeparating * largest * impulse;
}

/// Of a rigid contact, f_N is the sum of the multipliers of its edges, and f_D has mu times the difference of those of
/// opposite edges. Of a soft one, the multipliers are f_N and the impulses along the tangents.
void LeastEnergy::take_impulses() {
  Eigen::Map<Vector> z = z_.view();
  z.setZero();
  const bool is_soft = contact_->is_soft();
  Index row = 0;
  Index direction = contact_->nc();
  for (Index c = 0; c < contact_->nc(); ++c) {
    const Index rows = rows_of(*contact_, c), half = edges_of(*contact_, c) / 2;
    const auto multipliers = multipliers_.view().segment(row, rows);
    z(c) = is_soft ? multipliers(0) : multipliers.sum();
    for (Index t = 0; t < half; ++t) {
      const double along =
          is_soft ? multipliers(1 + t) : contact_->mu(c) * (multipliers(t) - multipliers(t + half));
      z(direction + t) = std::max(along, 0.0);
      z(direction + t + half) = std::max(-along, 0.0);
    }
    row += rows;
    direction += contact_->edges[static_cast<std::size_t>(c)];
  }
}

}  // namespace lcpbench
