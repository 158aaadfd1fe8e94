#include "native/auto/even_impulses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

/// Classes of residuals, relative to the scale. A velocity within the answer's class may count as zero; one of so many
/// times its residual does, because it is noise of the method.
constexpr std::array kClasses{1e-9, 1e-6, 1e-4};
constexpr double kNoise = 10;

/// Added to the matrix, relative to D, so that it is regular. A step leaves about this part of the residual, over the
/// least eigenvalue of the scaled matrix; the next one with the same factors takes it away. Where no part of a step
/// makes the residual smaller, kMore times as much is added, up to about kMaxAdded.
constexpr double kAdded = 1e-13, kMore = 100, kMaxAdded = 0.1;
/// Of D over the masses, relative to the largest: less is the rounding of levers that are zero.
constexpr double kLeastLever = 1e-16;

/// From each start. Most problems take fewer than ten.
constexpr int kMaxFactorizations = 50;
/// The residual has to fall by this part of itself times the step's length, which is halved down to the second.
constexpr double kLeastFall = 1e-4, kShortestStep = 0x1p-10;
/// Relative to g: with such a residual the pieces are known but for rounding; with more than the second, they are not.
constexpr double kClose = 1e-10, kLargestResidual = 1e-7;
/// A step with the same factors that leaves more than this part made no progress. Four such steps in a row are the end.
constexpr double kProgress = 0.5;
constexpr int kMaxIdle = 4, kMaxRefinements = 5;
/// The values of s before zero, from 1 on, and by what each is smaller than the last. They lead to 97 of 102 answers
/// that Newton's method misses from zero; with a fall by 0.01 to 77, and on to 1e-13 to 49.
constexpr int kPathPoints = 10;
constexpr double kPathFall = 0.1;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

double class_of(double residual) {
  const auto own = std::find_if(kClasses.begin(), kClasses.end(), [&](double bound) { return residual <= bound; });
  return own == kClasses.end() ? 0 : *own;
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

const char* EvenImpulses::distribute(double error, double deadline_s, Answer& answer) {
  factorizations_ = 0;
  const ContactProblem& contact = *problem_->contact();
  const bool is_soft = contact.compliance_n.size() > 0 && contact.compliance_n.minCoeff() > 0;
  if (is_soft || (answer.z.head(contact.nc() + cols(contact.D)).array() == 0).all()) return "";
  if (!prepare()) return "friction directions are no regular polygon";
  state_.set_impulses(answer.z);
  own_ = state_.impulse;
  const double residual = state_.residual() / state_.scale, tolerance = class_of(residual);
  if (!(tolerance > 0)) return "the residual is above 1e-4 in double";
  find_sections(state_.scale * std::min(tolerance, std::max(kNoise * residual, kClasses[0])));
  test_.allow(error);
  begin();
  const char* why = balance(deadline_s) ? settle(tolerance, deadline_s) : "none were found";
  if (*why != '\0') {
    follow_path(deadline_s);
    why = balance(deadline_s) ? settle(tolerance, deadline_s) : "none were found";
  }
  if (*why == '\0') answer.z = candidate_.z;
  return why;
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
  diagonal_.setZero(ngc);
  for (const ContactRows& rows : rows_) {
    for (Index k = 0; k < rows.J.cols(); ++k) diagonal_(rows.coordinates[at(k)]) += rows.J.col(k).squaredNorm();
  }
  masses_ = Vector::Ones(ngc);
  if (std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia)) {
    for_each_matrix(contact.inertia, [&](const Matrix& G, Index i) { masses_.segment(i, G.rows()) = G.diagonal(); });
  }
  diagonal_ = diagonal_.cwiseMax(kLeastLever * (diagonal_.array() / masses_.array()).maxCoeff() * masses_);
  BlockInertia added;
  for (const double each : diagonal_) added.blocks.push_back(Matrix::Constant(1, 1, each));
  matrix_.load(added, rows_);
  test_.load(*problem_, &state_.units.numbers());
  set_velocity(v_);
  return true;
}

/// Sets the sections and g.
void EvenImpulses::find_sections(double still) {
  net_.resize(3, state_.contacts);
  net_impulses(state_, net_);
  sum_.setZero(masses_.size());
  whole_.setZero(masses_.size());
  sections_.resize(rows_.size());
  Eigen::Matrix3d slope;
  for (std::size_t c = 0; c < rows_.size(); ++c) {
    sections_[c] = section_of(c, still);
    const Eigen::Vector3d own = net_.col(static_cast<Index>(c)), inside = carry(c, own, slope);
    // An impulse that is outside by more than noise shows that the contact slips so little that no side is certain.
    const double outside = state_.columns.diagonal(static_cast<Index>(c)) * (own - inside).norm();
    if (!(outside <= still)) sections_[c].form = Section::Form::kKept;
    if (sections_[c].form == Section::Form::kKept) continue;
    rows_[c].add_momentum(inside, sum_);
    rows_[c].add_momentum(own, whole_);
  }
}

/// What the contact may carry at the velocity of state_. @param still velocities up to this one count as zero
EvenImpulses::Section EvenImpulses::section_of(std::size_t contact, double still) const {
  using Form = Section::Form;
  const auto i = static_cast<Index>(contact);
  const ContactProblem& problem = *problem_->contact();
  if (problem.normal_compliance(i) > 0 || problem.tangential_compliance(i) > 0) return {Form::kKept};
  if (!(state_.normal_velocity(i) <= still)) return {};
  if (rows_[contact].friction < 0 || !(state_.mu(i) > 0)) return {Form::kNormal};
  const FrictionPolygon& polygon = *polygons_.of(contact);
  const SignedFriction& friction = state_.frictions[at(rows_[contact].friction)];
  const Eigen::Vector2d slip = rows_[contact].velocity(state_.u).tail<2>() + state_.tangential_offset(friction);
  const Index side = polygon.side_of(-slip);  // the directions of its corners are the most against the slip
  const double first = polygon.direction(side).dot(slip), second = polygon.direction(side + 1).dot(slip);
  if (-std::min(first, second) <= still) return {Form::kPolygon};
  if (std::abs(first - second) <= still) return {Form::kSide, side};
  return {Form::kCorner, first < second ? side : side + 1};
}

/// Begins with contacts that all press, with friction inside of its section.
void EvenImpulses::begin() {
  for (Point* point : {&now_, &next_}) {
    point->impulse.setZero(3, state_.contacts);
    point->slope.resize(rows_.size());
  }
  for (std::size_t c = 0; c < rows_.size(); ++c) carry(c, Eigen::Vector3d::UnitX(), now_.slope[c]);
  now_.y.setZero(masses_.size());
  now_.residual = sum_;
}

/// From the solution at s = 1 to a start at s = 0.
void EvenImpulses::follow_path(double deadline_s) {
  begin();
  path_ = 1;
  for (int k = 1; k <= kPathPoints; ++k) {
    balance(deadline_s);
    path_ = k < kPathPoints ? path_ * kPathFall : 0;
    find_residual(now_);
  }
}

/// Newton's method from now_. @returns whether the residual is one of rounding
bool EvenImpulses::balance(double deadline_s) {
  factored_.clear();
  const double whole = size_of(sum_);
  const std::int64_t last = factorizations_ + kMaxFactorizations;
  double size = size_of(now_.residual), least = size, added = kAdded + path_;
  for (int idle = 0; size > kClose * whole && idle < kMaxIdle;) {
    const bool is_same = now_.slope == factored_;
    if (!is_same) {
      if (factorizations_ == last || !(wall_clock_s() < deadline_s)) return false;
      ++factorizations_;
      factored_ = now_.slope;
      if (!matrix_.factor(factored_, added)) return false;
    }
    step_ = now_.residual;
    matrix_.solve(step_);
    if (!search()) {
      if (added >= kMaxAdded) break;
      added *= kMore;
      factored_.clear();
      continue;
    }
    size = size_of(now_.residual);
    const bool has_progress = size <= kProgress * least;
    least = std::min(least, size);
    if (!is_same || now_.slope != factored_) {
      idle = 0;
    } else if (!has_progress) {
      ++idle;
    }
  }
  return size <= kLargestResidual * whole;
}

/// The line search. @returns false where no part of the step makes the residual smaller
bool EvenImpulses::search() {
  const double size = size_of(now_.residual);
  for (double length = 1; length >= kShortestStep; length /= 2) {
    next_.y = now_.y + length * step_;
    find_residual(next_);
    if (!(size_of(next_.residual) < (1 - kLeastFall * length) * size)) continue;
    std::swap(now_, next_);
    return true;
  }
  return false;
}

/// From its y all that a point has.
void EvenImpulses::find_residual(Point& point) const {
  point.residual = sum_;
  if (path_ > 0) point.residual.array() -= path_ * diagonal_.array() * point.y.array();
  for (std::size_t c = 0; c < rows_.size(); ++c) {
    const Eigen::Vector3d impulse = carry(c, rows_[c].velocity(point.y), point.slope[c]);
    point.impulse.col(static_cast<Index>(c)) = impulse;
    if (impulse(0) != 0) rows_[c].add_momentum(-impulse, point.residual);
  }
}

/// The impulses of a contact that yields by as much as it carries, and how they move with the point: the normal one is
/// that of the point if it is above zero, friction is the nearest in the section.
Eigen::Vector3d EvenImpulses::carry(std::size_t contact, const Eigen::Vector3d& point, Eigen::Matrix3d& slope) const {
  using Form = Section::Form;
  const Section& section = sections_[contact];
  slope.setZero();
  if (section.form == Form::kNothing || section.form == Form::kKept || !(point(0) > 0)) return Eigen::Vector3d::Zero();
  slope(0, 0) = 1;
  if (section.form == Form::kNormal) return {point(0), 0, 0};
  const FrictionPolygon& polygon = *polygons_.of(contact);
  const double mu = state_.mu(static_cast<Index>(contact)), size = mu * point(0);
  const Eigen::Vector2d other = point.tail<2>(), corner = polygon.direction(section.corner);
  const FrictionPolygon::Nearest friction =
      section.form == Form::kPolygon ? polygon.nearest(other, size)
      : section.form == Form::kSide  ? polygon.nearest_on_side(section.corner, other, size)
                                     : FrictionPolygon::Nearest{size * corner, Eigen::Matrix2d::Zero(), corner};
  slope.bottomLeftCorner<2, 1>() = mu * friction.growth;
  slope.bottomRightCorner<2, 2>() = friction.slope;
  return {point(0), friction.point(0), friction.point(1)};
}

/// In the norm of the velocities that it gives, about.
double EvenImpulses::size_of(const Vector& residual) const {
  return std::sqrt((residual.array().square() / masses_.array()).sum());
}

/// @returns why the impulses at the y of now_ are none; "" if candidate_ has them
const char* EvenImpulses::settle(double tolerance, double deadline_s) {
  refine();
  set_net_impulses(now_.impulse, polygons_, state_);
  for (std::size_t c = 0; c < sections_.size(); ++c) {  // contacts that keep theirs keep their directions, too
    if (sections_[c].form != Section::Form::kKept) continue;
    const auto i = static_cast<Index>(c);
    state_.impulse(i) = own_(i);
    if (rows_[c].friction < 0) continue;
    const SignedFriction& friction = state_.frictions[at(rows_[c].friction)];
    state_.impulse.segment(friction.first_column, friction.directions) =
        own_.segment(friction.first_column, friction.directions);
  }
  state_.recompute_velocity();
  if (!(state_.residual() <= tolerance * state_.scale)) return "their residual would be larger";
  candidate_.reserve(*problem_);
  candidate_.claim = Claim::kSolved;
  candidate_.z.resize(problem_->size());
  state_.write_answer(candidate_.z);
  return test_.settle(candidate_, deadline_s) ? "" : "they do not pass the test";
}

/// Steps of the impulses themselves, which lose less to rounding than those of y, on the larger one of each contact's
/// last two pieces. They aim at the sum of the answer's impulses as they are.
void EvenImpulses::refine() {
  if (factored_.empty()) return;  // nothing is carried
  if (now_.slope != factored_) {
    for (std::size_t c = 0; c < rows_.size(); ++c) {
      if (now_.slope[c].trace() > factored_[c].trace()) factored_[c] = now_.slope[c];
    }
    ++factorizations_;
    if (!matrix_.factor(factored_)) return;
  }
  now_.residual += whole_ - sum_;
  double size = size_of(now_.residual);
  for (int k = 0; k < kMaxRefinements; ++k) {
    step_ = now_.residual;
    matrix_.solve(step_);
    next_.residual = whole_;
    for (std::size_t c = 0; c < rows_.size(); ++c) {
      const auto i = static_cast<Index>(c);
      next_.impulse.col(i) = now_.impulse.col(i) + factored_[c] * rows_[c].velocity(step_);
      rows_[c].add_momentum(-next_.impulse.col(i), next_.residual);
    }
    const double next = size_of(next_.residual);
    if (!(next <= kProgress * size)) return;
    size = next;
    now_.impulse.swap(next_.impulse);
    now_.residual.swap(next_.residual);
  }
}

}  // namespace lcpbench
