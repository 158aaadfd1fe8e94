#include "native/lcpbench.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/registry.h"
#include "native/contacts/block_inverse.h"
#include "native/lcpbench_checks.h"

namespace lcpbench {
namespace {

/// impulse += J f
void add_impulses(const Jacobian& J, const double* f, Vector& impulse) {
  const auto add_columns = [&](const auto& matrix) {
    for (Index j = 0; j < matrix.cols(); ++j) {
      if (f[j] != 0) impulse += f[j] * matrix.col(j);
    }
  };
  if (impulse.size() > 0) std::visit(add_columns, J);
}

void check_layout(const EigenLayout& caller) {
  const EigenLayout here;
  const auto check = [](const std::string& what, int there, int expected, const char* advice) {
    if (there == expected) return;
    throw InputError("the program was compiled with " + what + " " + std::to_string(there) + ", lcpbench with " +
                     std::to_string(expected) + ": build both with the same " + advice);
  };
  check("Eigen's version", caller.version, here.version, "Eigen");
  check("Eigen's alignment in bytes", caller.alignment, here.alignment, "-m options");
  check("Eigen's plain malloc", caller.plain_malloc, here.plain_malloc, "-fsanitize and EIGEN_ options");
  check("Eigen's index size in bytes", caller.index_bytes, here.index_bytes, "EIGEN_ options");
  check("Eigen's row-major default", caller.row_major, here.row_major, "EIGEN_ options");
}

}  // namespace

struct ContactSolver::State {
  std::string name;
  std::unique_ptr<Solver> solver;

  Problem problem;
  const ContactProblem* contacts = nullptr;  ///< of the problem; null before load()
  ContactLayout layout;
  BlockInverse inverse_inertia;  ///< without blocks: not yet made
  Vector v;

  Answer answer;
  std::vector<ContactId> ids, last_ids;  ///< of the contacts, and of those before; or none
  ContactMatch match;
  Vector start;  ///< impulses of the last solve
  Vector last_start;
  bool has_start = false;
  Vector impulse, velocity;   ///< ngc
  bool has_velocity = false;  ///< `velocity` is that of the answer

  void load(Problem next, std::span<const ContactId> next_ids, bool follows);
  void take_start(const ContactLayout& last_layout);
  void forget_answer();
  void compute_velocity();
  bool has_answer() const { return answer.claim == Claim::kSolved && answer.z.size() == layout.size(); }
};

/// @param follows  the contacts are those of the next step: the impulses of the last one are brought to them
void ContactSolver::State::load(Problem next, std::span<const ContactId> next_ids, bool follows) {
  if (!next_ids.empty() && static_cast<Index>(next_ids.size()) != next.contact()->nc()) {
    throw InputError(std::to_string(next_ids.size()) + " ids for " + std::to_string(next.contact()->nc()) +
                     " contacts");
  }
  const std::string refusal = why_not(solver->capabilities(), next);
  if (!refusal.empty()) throw InputError(name + ": " + refusal);
  problem = std::move(next);
  contacts = problem.contact();
  const ContactLayout last_layout = std::exchange(layout, contact_layout(*contacts));
  ids.swap(last_ids);
  ids.assign(next_ids.begin(), next_ids.end());
  const bool is_needed = solver->capabilities().allocation_free;
  inverse_inertia = is_needed ? BlockInverse(contacts->inertia, InverseProof::kDigits) : BlockInverse();
  v = contacts->v;
  for (Vector* room : {&impulse, &velocity}) room->resize(v.size());
  if (follows) {
    solver->update(problem);
    take_start(last_layout);
  } else {
    solver->load(problem);
    start.resize(problem.size());
    has_start = false;
  }
  forget_answer();
}

/// Brings `start` to the contacts of now.
void ContactSolver::State::take_start(const ContactLayout& last_layout) {
  if (has_start) {
    match.find(last_ids, ids);
    has_start = match.matched() > 0 || (layout.rows > 0 && layout.rows == last_layout.rows);
  }
  if (has_start) {
    last_start.swap(start);
    matched_start(last_start, last_layout, match, layout, start);
  } else {
    start.resize(problem.size());
  }
}

void ContactSolver::State::forget_answer() {
  answer.clear();
  answer.z.resize(problem.size());
  answer.z.setZero();
  has_velocity = false;
}

void ContactSolver::State::compute_velocity() {
  if (has_velocity) return;
  has_velocity = true;
  velocity = v;
  if (!has_answer()) return;
  if (answer.velocity.size() == v.size()) {
    velocity = answer.velocity;
    return;
  }
  impulse.setZero();
  add_impulses(contacts->N, answer.z.data(), impulse);
  add_impulses(contacts->D, answer.z.data() + layout.friction_offset(), impulse);
  add_impulses(contacts->rows.R, answer.z.data() + layout.row_offset(), impulse);
  if (inverse_inertia.blocks() == 0) inverse_inertia = BlockInverse(contacts->inertia, InverseProof::kDigits);
  inverse_inertia.add_product(impulse, velocity);
  const auto is_tiny = [](const auto& impulses) {
    return std::any_of(impulses.begin(), impulses.end(), is_near_underflow);
  };
  const auto& z = answer.z;
  if (velocity.allFinite() && !is_tiny(z.head(layout.lambda_offset())) && !is_tiny(z.tail(layout.rows))) return;
  ContactProblem moving = *contacts;
  moving.v = v;
  velocity = post_impact_velocity(moving, answer.z);
}

std::vector<NativeSolver> native_solvers() {
  std::vector<NativeSolver> solvers;
  for (const RegisteredSolver& solver : registered_solvers()) {
    if (!solver.native() || !solver.unavailable.empty()) continue;
    const SolverDefinition& definition = solver.definition;
    solvers.push_back(
        {definition.name, definition.summary, definition.source, !definition.capabilities.frictionless_only});
  }
  return solvers;
}

ContactSolver::ContactSolver(std::string_view spec, EigenLayout layout) {
  check_layout(layout);
  const Spec parsed = parse_spec(spec);
  if (!find_solver(parsed.name).native()) throw InputError("'" + parsed.name + "' is no native solver");
  state_ = std::make_unique<State>();
  state_->name = parsed.name;
  state_->solver = make_solver(parsed);
}

ContactSolver::~ContactSolver() = default;
ContactSolver::ContactSolver(ContactSolver&& other) noexcept = default;
ContactSolver& ContactSolver::operator=(ContactSolver&& other) noexcept = default;

void ContactSolver::load(const RigidScene& scene, std::span<const ContactId> ids) {
  check_usable(scene);
  state_->load(Problem(state_->name, scene), ids, false);
}

void ContactSolver::load(const ContactProblem& contacts, std::span<const ContactId> ids) {
  check_usable(contacts);
  state_->load(Problem(state_->name, contacts), ids, false);
}

void ContactSolver::update(const RigidScene& scene, std::span<const ContactId> ids) {
  check_usable(scene);
  state_->load(Problem(state_->name, scene), ids, state_->contacts != nullptr);
}

void ContactSolver::update(const ContactProblem& contacts, std::span<const ContactId> ids) {
  check_usable(contacts);
  state_->load(Problem(state_->name, contacts), ids, state_->contacts != nullptr);
}

ContactSolver::State& ContactSolver::loaded() const {
  if (state_->contacts == nullptr) throw std::logic_error("ContactSolver: nothing was loaded");
  return *state_;
}

void ContactSolver::set_velocity(const Vector& v) {
  State& state = loaded();
  if (v.size() != state.v.size()) {
    throw InputError("v has " + std::to_string(v.size()) + " entries, expected " + std::to_string(state.v.size()));
  }
  if (!v.allFinite()) throw InputError("v holds NaN or infinity");
  state.v = v;
  state.forget_answer();
  state.solver->update(state.v);
}

Claim ContactSolver::solve(double time_limit_s) {
  State& state = loaded();
  SolveRequest request;
  request.time_limit_s = time_limit_s;
  if (state.has_start) request.start = &state.start;
  state.has_velocity = false;
  state.solver->solve(request, state.answer);
  const Vector& z = state.answer.z;
  const Claim claim = state.answer.claim;
  const bool usable = claim == Claim::kSolved || claim == Claim::kIterationLimit || claim == Claim::kTimeLimit;
  state.has_start =
      usable && state.solver->capabilities().warm_start && z.size() == state.start.size() && z.allFinite();
  if (state.has_start) state.start = z;
  return state.answer.claim;
}

const Vector& ContactSolver::velocity() const {
  State& state = loaded();
  state.compute_velocity();
  return state.velocity;
}

double ContactSolver::normal_impulse(Index contact) const {
  const State& state = loaded();
  if (contact < 0 || contact >= state.layout.nc) {
    throw std::out_of_range("there is no contact " + std::to_string(contact));
  }
  return state.has_answer() ? state.answer.z(contact) : 0.0;
}

double ContactSolver::friction_impulse(Index contact, Index t) const {
  normal_impulse(contact);  // tests the index
  const State& state = loaded();
  const ContactLayout& layout = state.layout;
  const auto c = static_cast<std::size_t>(contact);
  const Index half = (layout.friction_begin[c + 1] - layout.friction_begin[c]) / 2;
  if (t < 0 || t >= half) throw std::out_of_range("the contact has no friction direction " + std::to_string(t));
  if (!state.has_answer()) return 0.0;
  const Index first = layout.friction_offset() + layout.friction_begin[c] + t;
  return state.answer.z(first) - state.answer.z(first + half);
}

double ContactSolver::row_impulse(Index row) const {
  const State& state = loaded();
  if (row < 0 || row >= state.layout.rows) throw std::out_of_range("there is no bounded row " + std::to_string(row));
  return state.has_answer() ? state.answer.z(state.layout.row_offset() + row) : 0.0;
}

Eigen::Vector3d ContactSolver::impulse(Index contact) const {
  const State& state = loaded();
  const RigidScene* scene = state.problem.scene();
  if (scene == nullptr) throw std::logic_error("ContactSolver: impulses in world axes need a RigidScene");
  const double normal = normal_impulse(contact);
  const RigidContact& geometry = scene->contacts[static_cast<std::size_t>(contact)];
  Eigen::Vector3d total = normal * geometry.normal;
  if (geometry.edges == 0) return total;
  total += friction_impulse(contact, 0) * geometry.tangent;
  total += friction_impulse(contact, 1) * geometry.normal.cross(geometry.tangent);
  return total;
}

const Answer& ContactSolver::answer() const { return state_->answer; }

const Capabilities& ContactSolver::capabilities() const { return state_->solver->capabilities(); }

}  // namespace lcpbench
