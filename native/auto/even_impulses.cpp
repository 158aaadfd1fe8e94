#include "native/auto/even_impulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// Classes of residuals, relative to max|q|. A velocity within the answer's class may count as zero; one of so many
/// times its residual does, because it is noise of the method.
constexpr std::array kClasses{1e-9, 1e-6, 1e-4};
constexpr double kNoise = 10;

/// Added to the matrix, relative to the diagonal of J'J, so that it is regular. A step leaves about this part of what
/// was left, over the least eigenvalue of the scaled matrix; the next one with the same factors takes it away.
constexpr double kAdded = 1e-13;
/// Of that diagonal over the masses, relative to the largest: less is the rounding of levers that are zero.
constexpr double kLeastLever = 1e-16;

/// Most problems take fewer than ten.
constexpr std::int64_t kMostFactorizations = 200;
/// The search ends where the slope along the step is at most this part of that at its beginning.
constexpr double kFlat = 0.1;
constexpr int kMostTries = 40;
/// With so much of g left, the faces are known but for rounding.
constexpr double kClose = 1e-10;
/// A step with the same factors that leaves more than this part made no progress. Four such steps in a row are the end.
constexpr double kProgress = 0.5;
constexpr int kMostIdle = 4, kMostRefinements = 5;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

double class_of(double residual) {
  const auto own = std::find_if(kClasses.begin(), kClasses.end(), [&](double most) { return residual <= most; });
  return own == kClasses.end() ? 0 : *own;
}

Eigen::Vector3d project_on_ray(const Eigen::Vector3d& ray, const Eigen::Vector3d& point, Eigen::Matrix3d& slope) {
  const Eigen::Vector3d unit = ray.normalized();
  const double along = unit.dot(point);
  if (along > 0) {
    slope = unit * unit.transpose();
    return along * unit;
  }
  slope.setZero();
  return Eigen::Vector3d::Zero();
}

/// On all that is between two rays of the same length.
Eigen::Vector3d project_between(const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                                const Eigen::Vector3d& point, Eigen::Matrix3d& slope) {
  const Eigen::Vector3d sum = first + second, difference = second - first;
  const Eigen::Vector3d middle = sum.normalized(), across = difference.normalized();
  const double along = middle.dot(point), aside = across.dot(point);
  if (!(std::abs(aside) * sum.norm() <= along * difference.norm())) {
    return project_on_ray(aside < 0 ? first : second, point, slope);
  }
  slope = middle * middle.transpose() + across * across.transpose();
  return along * middle + aside * across;
}

}  // namespace

void EvenImpulses::load(const Problem& problem) {
  problem_ = &problem;
  is_prepared_ = false;
  v_ = problem.contact()->v;
}

void EvenImpulses::set_velocity(const Vector& v) {
  v_ = v;
  if (!is_prepared_) return;
  state_.set_velocity(v);
  test_.set_velocity(v);
}

/// @returns whether all friction directions are those of regular polygons
bool EvenImpulses::prepare() {
  if (is_prepared_) return is_regular_;
  const ContactProblem& contact = *problem_->contact();
  is_prepared_ = true;
  state_.load(*problem_);
  is_regular_ = find_contact_rows(state_, rows_) < 0;
  if (!is_regular_) return false;
  polygons_.find(state_);
  const Index ngc = contact.ngc();
  Vector diagonal = Vector::Zero(ngc);  // of J'J
  for (const ContactRows& rows : rows_) {
    for (Index k = 0; k < rows.J.cols(); ++k) diagonal(rows.coordinates[at(k)]) += rows.J.col(k).squaredNorm();
  }
  masses_ = Vector::Ones(ngc);
  if (std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia)) {
    for_each_matrix(contact.inertia, [&](const Matrix& G, Index i) { masses_.segment(i, G.rows()) = G.diagonal(); });
  }
  diagonal = diagonal.cwiseMax(kLeastLever * (diagonal.array() / masses_.array()).maxCoeff() * masses_);
  BlockInertia added;
  for (const double each : diagonal) added.blocks.push_back(Matrix::Constant(1, 1, kAdded * each));
  matrix_.load(added, rows_);
  test_.load(*problem_, AnswerTest::Bodies::kOneByOne, &state_.units.numbers());
  set_velocity(v_);
  return true;
}

Eigen::Vector3d EvenImpulses::ray(std::size_t contact, Index direction) const {
  const Eigen::Vector2d friction = state_.mu(static_cast<Index>(contact)) * polygons_.of(contact)->direction(direction);
  return {1, friction(0), friction(1)};
}

/// What the contact may carry at the velocity of state_. @param still velocities up to this one count as zero
EvenImpulses::Cone EvenImpulses::cone_of(std::size_t contact, double still) const {
  const auto i = static_cast<Index>(contact);
  const ContactProblem& problem = *problem_->contact();
  if (problem.normal_compliance(i) > 0 || problem.tangential_compliance(i) > 0) return {.form = Cone::Form::kKept};
  if (!(state_.normal_velocity(i) <= still)) return {};
  if (rows_[contact].friction < 0 || !(state_.mu(i) > 0)) return {.rays = 1, .first = Eigen::Vector3d::UnitX()};
  const FrictionPolygon& polygon = *polygons_.of(contact);
  const Eigen::Vector2d slip =
      pull(contact, state_.u).tail<2>() + state_.creep(state_.frictions[at(rows_[contact].friction)]);
  const Index side = polygon.side_of(-slip);  // the directions of its corners are the most against the slip
  const double lambda = -std::min(polygon.direction(side).dot(slip), polygon.direction(side + 1).dot(slip));
  const bool sticks = lambda <= still;
  Cone cone;
  if (sticks && polygon.edges() > 2) cone.form = Cone::Form::kPyramid;
  for (const Index k : {side, side + 1}) {
    const bool may_push = sticks || lambda + polygon.direction(k).dot(slip) <= still;
    if (may_push) (cone.rays++ == 0 ? cone.first : cone.second) = ray(contact, k);
  }
  return cone;
}

/// The nearest point of the contact's cone, and how it moves with the point.
Eigen::Vector3d EvenImpulses::project(std::size_t contact, const Eigen::Vector3d& point, Eigen::Matrix3d& slope) const {
  const Cone& cone = cones_[contact];
  if (cone.form == Cone::Form::kPyramid) {
    // The pyramid is its own mirror image at each plane through the normal and a corner: what is nearest to a point is
    // between the same two corners.
    const Index side = polygons_.of(contact)->side_of(point.tail<2>());
    const Eigen::Vector3d first = ray(contact, side), second = ray(contact, side + 1);
    if (!(first.cross(second).dot(point) >= 0)) return project_between(first, second, point, slope);
    slope.setIdentity();
    return point;
  }
  if (cone.rays == 2) return project_between(cone.first, cone.second, point, slope);
  if (cone.rays == 1) return project_on_ray(cone.first, point, slope);
  slope.setZero();
  return Eigen::Vector3d::Zero();
}

/// J_c y
Eigen::Vector3d EvenImpulses::pull(std::size_t contact, const Vector& y) const {
  const ContactRows& rows = rows_[contact];
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (Index k = 0; k < rows.J.cols(); ++k) sum += rows.J.col(k) * y(rows.coordinates[at(k)]);
  return sum;
}

/// from -= J_c'impulse
void EvenImpulses::subtract(std::size_t contact, const Eigen::Vector3d& impulse, Vector& from) const {
  const ContactRows& rows = rows_[contact];
  for (Index k = 0; k < rows.J.cols(); ++k) from(rows.coordinates[at(k)]) -= rows.J.col(k).dot(impulse);
}

/// In the norm of the velocities that it gives, about.
double EvenImpulses::size_of(const Vector& left) const {
  return std::sqrt((left.array().square() / masses_.array()).sum());
}

/// Sets the cones, g, and where the method begins: the first step takes each cone for the space that it spans.
void EvenImpulses::find_cones(double still) {
  const Index ngc = masses_.size();
  net_.resize(3, state_.contacts);
  net_impulses(state_, net_);
  sum_.setZero(ngc);
  whole_.setZero(ngc);
  cones_.resize(rows_.size());
  for (Point* point : {&now_, &next_}) {
    point->impulse.setZero(3, state_.contacts);
    point->slope.resize(rows_.size());
  }
  for (std::size_t c = 0; c < rows_.size(); ++c) {
    Cone& cone = cones_[c];
    Eigen::Matrix3d& slope = now_.slope[c];
    cone = cone_of(c, still);
    const Eigen::Vector3d own = net_.col(static_cast<Index>(c)), inside = project(c, own, slope);
    // An impulse that is outside by more than noise shows that the contact slips so little that no face is certain.
    const double outside = state_.columns.diagonal(static_cast<Index>(c)) * (own - inside).norm();
    if (cone.form == Cone::Form::kKept || !(outside <= still)) {
      cone = {.form = Cone::Form::kKept};
      slope.setZero();
      continue;
    }
    subtract(c, -inside, sum_);
    subtract(c, -own, whole_);
    if (cone.rays > 0) project(c, cone.first + cone.second, slope);
    if (cone.form == Cone::Form::kPyramid) slope.setIdentity();
  }
  now_.y.setZero(ngc);
  now_.left = sum_;
}

/// Goes along the step about as far as the dual function rises. @returns false where it does not rise
bool EvenImpulses::search() {
  const double rise = now_.left.dot(step_);
  double low = 0, at_low = rise, high = std::numeric_limits<double>::infinity(), at_high = 0, length = 1;
  if (!(rise > 0)) return false;
  for (int tries = 1;; ++tries) {
    next_.y = now_.y + length * step_;
    next_.left = sum_;
    for (std::size_t c = 0; c < rows_.size(); ++c) {
      const Eigen::Vector3d impulse = project(c, pull(c, next_.y), next_.slope[c]);
      next_.impulse.col(static_cast<Index>(c)) = impulse;
      if (impulse(0) != 0) subtract(c, impulse, next_.left);
    }
    const double slope = next_.left.dot(step_);
    if (std::abs(slope) <= kFlat * rise || tries == kMostTries) break;
    (slope > 0 ? low : high) = length;
    (slope > 0 ? at_low : at_high) = slope;
    const double share = std::clamp(at_low / (at_low - at_high), 0.1, 0.9);
    length = std::isinf(high) ? 2 * length : low + share * (high - low);
  }
  std::swap(now_, next_);
  return true;
}

/// @returns false where the method does not end
bool EvenImpulses::maximise(double deadline_s) {
  factored_.clear();
  const double whole = size_of(sum_);
  double size = whole, least = whole;
  for (int idle = 0; size > kClose * whole && idle < kMostIdle;) {
    const bool is_same = now_.slope == factored_;
    if (!is_same) {
      if (factorizations_ == kMostFactorizations || !(wall_clock_s() < deadline_s)) return false;
      ++factorizations_;
      factored_ = now_.slope;
      if (!matrix_.factor(factored_)) return false;
    }
    step_ = now_.left;
    matrix_.solve(step_);
    if (!search()) return false;
    size = size_of(now_.left);
    const bool has_progress = size <= kProgress * least;
    least = std::min(least, size);
    if (!is_same || now_.slope != factored_) {
      idle = 0;
    } else if (!has_progress) {
      ++idle;
    }
  }
  return std::isfinite(size);
}

/// Steps of the impulses themselves, which lose less to rounding than those of y, on the larger one of each contact's
/// last two faces. They aim at the sum of the answer's impulses as they are.
void EvenImpulses::refine() {
  if (factored_.empty()) return;  // nothing is carried
  if (now_.slope != factored_) {
    for (std::size_t c = 0; c < rows_.size(); ++c) {
      if (now_.slope[c].trace() > factored_[c].trace()) factored_[c] = now_.slope[c];
    }
    ++factorizations_;
    if (!matrix_.factor(factored_)) return;
  }
  now_.left += whole_ - sum_;
  double size = size_of(now_.left);
  for (int k = 0; k < kMostRefinements; ++k) {
    step_ = now_.left;
    matrix_.solve(step_);
    next_.left = whole_;
    for (std::size_t c = 0; c < rows_.size(); ++c) {
      const auto i = static_cast<Index>(c);
      next_.impulse.col(i) = now_.impulse.col(i) + factored_[c] * pull(c, step_);
      subtract(c, next_.impulse.col(i), next_.left);
    }
    const double left = size_of(next_.left);
    if (!(left <= kProgress * size)) return;
    size = left;
    now_.impulse.swap(next_.impulse);
    now_.left.swap(next_.left);
  }
}

/// The impulses become those of state_. Contacts that keep theirs keep their directions, too.
void EvenImpulses::take_impulses() {
  own_ = state_.impulse;
  set_net_impulses(now_.impulse, polygons_, state_);
  for (std::size_t c = 0; c < cones_.size(); ++c) {
    if (cones_[c].form != Cone::Form::kKept) continue;
    const auto i = static_cast<Index>(c);
    state_.impulse(i) = own_(i);
    if (rows_[c].friction < 0) continue;
    const SignedFriction& friction = state_.frictions[at(rows_[c].friction)];
    state_.impulse.segment(friction.first_column, friction.directions) =
        own_.segment(friction.first_column, friction.directions);
  }
  state_.recompute_velocity();
}

const char* EvenImpulses::distribute(double allowed, double deadline_s, Answer& answer) {
  factorizations_ = 0;
  const ContactProblem& contact = *problem_->contact();
  const bool is_soft = contact.compliance_n.size() > 0 && contact.compliance_n.minCoeff() > 0;
  if (is_soft || (answer.z.head(contact.nc() + cols(contact.D)).array() == 0).all()) return "";
  if (!prepare()) return "friction directions are no regular polygon";
  state_.set_impulses(answer.z);
  const double residual = state_.residual() / state_.q_max, most = class_of(residual);
  if (!(most > 0)) return "the residual is above 1e-4 in double";
  find_cones(state_.q_max * std::min(most, std::max(kNoise * residual, kClasses[0])));
  if (!maximise(deadline_s)) return "none were found";
  refine();
  take_impulses();
  if (!(state_.residual() <= most * state_.q_max)) return "their residual would be larger";
  candidate_.reserve(*problem_);
  candidate_.claim = Claim::kSolved;
  candidate_.z.resize(answer.z.size());
  state_.write_answer(candidate_.z);
  test_.allow(allowed);
  if (!test_.settle(candidate_, deadline_s)) return "they do not pass the test";
  answer.z = candidate_.z;
  return "";
}

}  // namespace lcpbench
