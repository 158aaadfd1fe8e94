#include "native/auto/island_part.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <variant>

namespace lcpbench {
namespace {

/// Of a body's inertia scaled to unit diagonal: its least eigenvalue is no less than a third of that.
constexpr double kLeastDeterminant = 0x1p-20;

/// Whether double knows the response of every body to any impulse well. @pre BlockInertia
bool is_benign(const Inertia& inertia) {
  const auto& blocks = std::get<BlockInertia>(inertia).blocks;
  return std::all_of(blocks.begin(), blocks.end(), [](const Matrix& block) {
    const Eigen::LLT<Matrix> factors(block);
    if (factors.info() != Eigen::Success) return false;
    double determinant = 1;
    for (Index i = 0; i < block.rows(); ++i) {
      const double pivot = factors.matrixLLT()(i, i);
      determinant *= pivot * pivot / block(i, i);
    }
    return determinant >= kLeastDeterminant;
  });
}

}  // namespace

void IslandPart::load(ProblemCutter& whole, const Island& part, const Vector& v, bool in_turn, bool to_hold) {
  cut(whole, part, v);
  if (to_hold) return attempts_.load_to_hold(problem_, v_, in_turn);
  attempts_.load(problem_, v_, in_turn);
}

bool IslandPart::load_when_needed(ProblemCutter& whole, const Island& part, const Vector& v) {
  cut(whole, part, v);
  return attempts_.load_when_needed(problem_, v_);
}

void IslandPart::cut(ProblemCutter& whole, const Island& part, const Vector& v) {
  part_ = &part;
  const ContactProblem& given = whole.whole();
  // Where mu = 0 the slip gives lambda, which body by body is as certain as the velocity. In an inertia that couples
  // more, or in bodies near singular, the directions of friction may be the ones that double knows nothing of: then
  // their rows are solved and tested too.
  const bool by_bodies = std::holds_alternative<BlockInertia>(given.inertia);
  bool has_friction = false;
  bool has_rows = false;
  for (const Index contact : part.contacts) {
    const bool rows = given.edges[static_cast<std::size_t>(contact)] > 0;
    has_rows = has_rows || rows;
    has_friction = has_friction || (rows && given.mu(contact) > 0);
  }
  const auto cut_out = [&](bool with_friction) {
    problem_ = Problem("", whole.cut(part.contacts, part.coordinates, v, with_friction));
  };
  const bool keeps_rows = has_friction || (has_rows && !by_bodies);
  const bool is_whole = keeps_rows == has_rows && static_cast<Index>(part.contacts.size()) == given.nc() &&
                        static_cast<Index>(part.coordinates.size()) == given.ngc() && v == given.v;
  if (is_whole) {
    problem_ = whole.problem();
  } else {
    cut_out(keeps_rows);
  }
  if (by_bodies && has_rows && !has_friction && !is_benign(problem_.contact()->inertia)) cut_out(true);
  place_unknowns(whole.layout());
  v_ = problem_.contact()->v;
  u_.resize(v_.size());
  start_.resize(problem_.size());
  answer_.reserve(problem_);
}

void IslandPart::place_unknowns(const ContactLayout& layout) {
  const std::vector<Index>& contacts = part_->contacts;
  place_.assign(contacts.begin(), contacts.end());
  if (!problem_.contact()->frictional()) return;
  for (const Index contact : contacts) {
    const auto c = static_cast<std::size_t>(contact);
    for (Index t = layout.friction_begin[c]; t < layout.friction_begin[c + 1]; ++t) {
      place_.push_back(layout.friction_offset() + t);
    }
  }
  for (const Index contact : contacts) {
    const Index lambda = layout.lambda[static_cast<std::size_t>(contact)];
    if (lambda >= 0) place_.push_back(layout.lambda_offset() + lambda);
  }
}

void IslandPart::update(const Vector& v) {
  take_velocity(v);
  attempts_.update(v_);
}

void IslandPart::set_velocity(const Vector& v) {
  take_velocity(v);
  attempts_.set_velocity(v_);
}

void IslandPart::take_velocity(const Vector& v) {
  for (Index i = 0; i < v_.size(); ++i) v_(i) = v(part_->coordinates[static_cast<std::size_t>(i)]);
}

Claim IslandPart::solve(const Vector* start, const AutoLimits& limits, AutoReport& report) {
  SolveRequest request;
  if (start != nullptr) {
    for (Index i = 0; i < start_.size(); ++i) start_(i) = (*start)(place_[static_cast<std::size_t>(i)]);
    request.start = &start_;
  }
  attempts_.solve(request, limits, answer_, report);
  return answer_.claim;
}

void IslandPart::write_impulses(Vector& z) const {
  for (Index i = 0; i < answer_.z.size(); ++i) z(place_[static_cast<std::size_t>(i)]) = answer_.z(i);
}

void IslandPart::write_velocity(Vector& u) {
  if (gave_velocity()) return write(answer_.velocity, u);
  attempts_.respond(answer_, u_);
  write(u_, u);
}

/// The part's coordinates of u.
void IslandPart::write(const Vector& own, Vector& u) const {
  for (Index i = 0; i < own.size(); ++i) u(part_->coordinates[static_cast<std::size_t>(i)]) = own(i);
}

}  // namespace lcpbench
