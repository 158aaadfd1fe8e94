#include "native/auto/island_part.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <variant>

#include "core/registry.h"

namespace lcpbench {

SolverDefinition lcpbench_solver_friction_ipm();
SolverDefinition lcpbench_solver_velocity_ipm();

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

void IslandPart::load(ProblemCutter& whole, const Island& part, const Vector& v) {
  cut(whole, part, v);
  load_method();
}

bool IslandPart::load_when_needed(ProblemCutter& whole, const Island& part, const Vector& v) {
  cut(whole, part, v);
  const bool can_wait = dense_.take(stand_in(), problem_);
  if (can_wait) {
    dense_.reserve(stand_in(), problem_);
  } else {
    load_method();
  }
  return can_wait;
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
  cut_out(has_friction || (has_rows && !by_bodies));
  if (by_bodies && has_rows && !has_friction && !is_benign(problem_.contact()->inertia)) cut_out(true);
  place_unknowns(whole.layout());
  v_ = problem_.contact()->v;
  u_.resize(v_.size());
  start_.resize(problem_.size());
  answer_.reserve(problem_);
  method_ = choose_method(by_bodies);
  is_loaded_ = false;
}

AutoMethod IslandPart::choose_method(bool is_scene) const {
  const ContactProblem& contact = *problem_.contact();
  const bool sparse = is_scene && std::holds_alternative<SparseMatrix>(contact.N);
  if (contact.frictional()) {
    return sparse && problem_.size() >= settings_.sparse_friction_from ? AutoMethod::kFrictionIpm
                                                                       : AutoMethod::kContactLemke;
  }
  return sparse && contact.nc() >= settings_.sparse_from ? AutoMethod::kVelocityIpm : AutoMethod::kActiveSet;
}

/// What solves it where the work was put off. Not contact_lemke for friction_ipm: it may take a hundred times as long.
AutoMethod IslandPart::stand_in() const {
  return method_ == AutoMethod::kVelocityIpm ? AutoMethod::kActiveSet : method_;
}

void IslandPart::load_method() {
  switch (method_) {
    case AutoMethod::kActiveSet:
      if (active_set_ == nullptr) active_set_ = std::make_unique<ActiveSet>(ActiveSetSettings{});
      break;
    case AutoMethod::kContactLemke:
      if (contact_lemke_ == nullptr) {
        contact_lemke_ = std::make_unique<ContactLemke>(ContactLemkeSettings{}, dense_.later_engines());
      }
      break;
    case AutoMethod::kVelocityIpm:
      if (velocity_ipm_ == nullptr) velocity_ipm_ = lcpbench_solver_velocity_ipm().make({});
      break;
    case AutoMethod::kFrictionIpm:
      if (friction_ipm_ == nullptr) {
        // Where it comes no nearer, contact_lemke follows, which does.
        friction_ipm_ = lcpbench_solver_friction_ipm().make({{"accept_residual", "3e-5"}});
      }
      break;
  }
  solver().load(problem_);
  is_loaded_ = true;
  const std::optional<AutoMethod> next = dense_.after(method_, problem_);
  if (next) dense_.reserve(*next, problem_);
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

Solver& IslandPart::solver() {
  switch (method_) {
    case AutoMethod::kContactLemke: return *contact_lemke_;
    case AutoMethod::kVelocityIpm: return *velocity_ipm_;
    case AutoMethod::kFrictionIpm: return *friction_ipm_;
    default: return *active_set_;
  }
}

void IslandPart::update(const Vector& v) {
  if (!is_loaded_) load_method();
  set_velocity(v);
}

void IslandPart::set_velocity(const Vector& v) {
  for (Index i = 0; i < v_.size(); ++i) v_(i) = v(part_->coordinates[static_cast<std::size_t>(i)]);
  if (is_loaded_ && takes(solver(), problem_)) solver().update(v_);
}

Claim IslandPart::solve(const Vector* start, const AutoLimits& limits, AutoReport& report) {
  SolveRequest request{.time_limit_s = limits.time()};
  if (start != nullptr) {
    for (Index i = 0; i < start_.size(); ++i) start_(i) = (*start)(place_[static_cast<std::size_t>(i)]);
    request.start = &start_;
  }
  std::optional<AutoMethod> next = stand_in();
  if (is_loaded_) {
    run_method(method_, solver(), request, limits, answer_, report);
    next = gave_up(answer_.claim, limits.max_pivots) ? dense_.after(method_, problem_) : std::nullopt;
    request.start = nullptr;  // it may have been what misled the method
  }
  by_dense_ = next.has_value();
  if (by_dense_) dense_.solve(*next, problem_, v_, request.start, limits, answer_, report);
  return answer_.claim;
}

void IslandPart::write_impulses(Vector& z) const {
  for (Index i = 0; i < answer_.z.size(); ++i) z(place_[static_cast<std::size_t>(i)]) = answer_.z(i);
}

void IslandPart::write_velocity(Vector& u) {
  if (gave_velocity()) return write(answer_.velocity, u);
  ContactLemke& lemke = by_dense_ ? dense_.contact_lemke() : *contact_lemke_;  // the others give one
  lemke.respond(answer_.z, u_);
  write(u_, u);
}

/// The part's coordinates of u.
void IslandPart::write(const Vector& own, Vector& u) const {
  for (Index i = 0; i < own.size(); ++i) u(part_->coordinates[static_cast<std::size_t>(i)]) = own(i);
}

}  // namespace lcpbench
