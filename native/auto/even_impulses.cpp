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

/// Added to the matrix, relative to the diagonal of J'J, so that it is regular. A step leaves about this part of what
/// was left, over the least eigenvalue of the scaled matrix; the next one with the same factors takes it away. Where no
/// part of a step leaves less, kMore times as much is added, up to about kMostAdded.
constexpr double kAdded = 1e-13, kMore = 100, kMostAdded = 0.1;
/// Of that diagonal over the masses, relative to the largest: less is the rounding of levers that are zero.
constexpr double kLeastLever = 1e-16;

/// From each start. Most problems take fewer than ten.
constexpr int kMostFactorizations = 50;
/// What is left has to fall by this part of itself times the step's length, which is halved down to the second.
constexpr double kLeastFall = 1e-4, kShortestStep = 0x1p-10;
/// With so much of g left, the pieces are known but for rounding; with more than the second, they are not.
constexpr double kClose = 1e-10, kMostLeft = 1e-7;
/// A step with the same factors that leaves more than this part made no progress. Four such steps in a row are the end.
constexpr double kProgress = 0.5;
constexpr int kMostIdle = 4, kMostRefinements = 5;
/// Compliance of the soft contacts that give a start, over the mean M_nn.
constexpr double kSoft = 1e-6;

std::size_t at(Index i) { return static_cast<std::size_t>(i); }

double class_of(double residual) {
  const auto own = std::find_if(kClasses.begin(), kClasses.end(), [&](double most) { return residual <= most; });
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
  for (const double each : diagonal) added.blocks.push_back(Matrix::Constant(1, 1, each));
  matrix_.load(added, rows_);
  test_.load(*problem_, &state_.units.numbers());
  set_velocity(v_);
  return true;
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
  const Eigen::Vector2d slip =
      pull(contact, state_.u).tail<2>() + state_.creep(state_.frictions[at(rows_[contact].friction)]);
  const Index side = polygon.side_of(-slip);  // the directions of its corners are the most against the slip
  const double first = polygon.direction(side).dot(slip), second = polygon.direction(side + 1).dot(slip);
  if (-std::min(first, second) <= still) return {Form::kPolygon};
  if (std::abs(first - second) <= still) return {Form::kSide, side};
  return {Form::kCorner, first < second ? side : side + 1};
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
    subtract(c, -inside, sum_);
    subtract(c, -own, whole_);
  }
}

/// Begins with contacts that all press, with friction inside of its section.
void EvenImpulses::begin() {
  for (Point* point : {&now_, &next_}) {
    point->impulse.setZero(3, state_.contacts);
    point->slope.resize(rows_.size());
  }
  for (std::size_t c = 0; c < rows_.size(); ++c) carry(c, Eigen::Vector3d::UnitX(), now_.slope[c]);
  now_.y.setZero(masses_.size());
  now_.left = sum_;
}

/// Begins with the y of contacts that are a little soft. @returns false where they have no answer
bool EvenImpulses::begin_softly(double deadline_s) {
  ContactProblem contact = *problem_->contact();
  contact.v = v_;
  const double soft = kSoft * state_.columns.diagonal.head(state_.contacts).mean();
  if (contact.compliance_n.size() == 0) contact.compliance_n.setZero(contact.nc());
  if (contact.compliance_t.size() == 0) contact.compliance_t.setZero(contact.nc());
  for (Index i = 0; i < contact.nc(); ++i) {
    if (sections_[at(i)].form == Section::Form::kKept) continue;
    contact.compliance_n(i) = soft;
    contact.compliance_t(i) = contact.edges[at(i)] > 0 ? soft : 0;
  }
  softened_.emplace(problem_->name(), std::move(contact));
  solver_->load(*softened_);
  candidate_.reserve(*softened_);
  solver_->solve({.time_limit_s = deadline_s - wall_clock_s()}, candidate_);
  if (candidate_.claim != Claim::kSolved) return false;
  state_.impulse = own_;
  state_.recompute_velocity();
  now_.y = state_.u;
  state_.set_impulses(candidate_.z);
  now_.y = (now_.y - state_.u) / soft;
  find_left(now_);
  return true;
}

/// From its y all that a point has.
void EvenImpulses::find_left(Point& point) const {
  point.left = sum_;
  for (std::size_t c = 0; c < rows_.size(); ++c) {
    const Eigen::Vector3d impulse = carry(c, pull(c, point.y), point.slope[c]);
    point.impulse.col(static_cast<Index>(c)) = impulse;
    if (impulse(0) != 0) subtract(c, impulse, point.left);
  }
}

/// Goes along the step. @returns false where no part of it leaves less
bool EvenImpulses::search() {
  const double size = size_of(now_.left);
  for (double length = 1; length >= kShortestStep; length /= 2) {
    next_.y = now_.y + length * step_;
    find_left(next_);
    if (!(size_of(next_.left) < (1 - kLeastFall * length) * size)) continue;
    std::swap(now_, next_);
    return true;
  }
  return false;
}

/// @returns whether nothing is left but rounding
bool EvenImpulses::balance(double deadline_s) {
  factored_.clear();
  const double whole = size_of(sum_);
  const std::int64_t most = factorizations_ + kMostFactorizations;
  double size = size_of(now_.left), least = size, added = kAdded;
  for (int idle = 0; size > kClose * whole && idle < kMostIdle;) {
    const bool is_same = now_.slope == factored_;
    if (!is_same) {
      if (factorizations_ == most || !(wall_clock_s() < deadline_s)) return false;
      ++factorizations_;
      factored_ = now_.slope;
      if (!matrix_.factor(factored_, added)) return false;
    }
    step_ = now_.left;
    matrix_.solve(step_);
    if (!search()) {
      if (added >= kMostAdded) break;
      added *= kMore;
      factored_.clear();
      continue;
    }
    size = size_of(now_.left);
    const bool has_progress = size <= kProgress * least;
    least = std::min(least, size);
    if (!is_same || now_.slope != factored_) {
      idle = 0;
    } else if (!has_progress) {
      ++idle;
    }
  }
  return size <= kMostLeft * whole;
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
  set_net_impulses(now_.impulse, polygons_, state_);
  for (std::size_t c = 0; c < sections_.size(); ++c) {
    if (sections_[c].form != Section::Form::kKept) continue;
    const auto i = static_cast<Index>(c);
    state_.impulse(i) = own_(i);
    if (rows_[c].friction < 0) continue;
    const SignedFriction& friction = state_.frictions[at(rows_[c].friction)];
    state_.impulse.segment(friction.first_column, friction.directions) =
        own_.segment(friction.first_column, friction.directions);
  }
  state_.recompute_velocity();
}

/// @returns why the impulses at the y of now_ are none; "" if candidate_ has them
const char* EvenImpulses::settle(double most, double deadline_s) {
  refine();
  take_impulses();
  if (!(state_.residual() <= most * state_.scale)) return "their residual would be larger";
  candidate_.reserve(*problem_);
  candidate_.claim = Claim::kSolved;
  candidate_.z.resize(problem_->size());
  state_.write_answer(candidate_.z);
  return test_.settle(candidate_, deadline_s) ? "" : "they do not pass the test";
}

const char* EvenImpulses::distribute(double allowed, double deadline_s, Answer& answer) {
  factorizations_ = 0;
  const ContactProblem& contact = *problem_->contact();
  const bool is_soft = contact.compliance_n.size() > 0 && contact.compliance_n.minCoeff() > 0;
  if (is_soft || (answer.z.head(contact.nc() + cols(contact.D)).array() == 0).all()) return "";
  if (!prepare()) return "friction directions are no regular polygon";
  state_.set_impulses(answer.z);
  own_ = state_.impulse;
  const double residual = state_.residual() / state_.scale, most = class_of(residual);
  if (!(most > 0)) return "the residual is above 1e-4 in double";
  find_sections(state_.scale * std::min(most, std::max(kNoise * residual, kClasses[0])));
  test_.allow(allowed);
  begin();
  const char* why = balance(deadline_s) ? settle(most, deadline_s) : "none were found";
  if (*why != '\0' && begin_softly(deadline_s)) {
    why = balance(deadline_s) ? settle(most, deadline_s) : "none were found";
  }
  if (*why == '\0') answer.z = candidate_.z;
  return why;
}

}  // namespace lcpbench
