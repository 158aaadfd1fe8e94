#include "native/auto/methods.h"

#include "native/active_set/active_set.h"
#include "native/contact_ipm/contact_ipm.h"
#include "native/friction_ipm/friction_ipm.h"
#include "native/sor/psor.h"
#include "native/velocity_ipm/velocity_ipm.h"

namespace lcpbench {
namespace {

/// dense_entries() up to which a dense method is loaded. One then takes about 600 MB of addresses.
constexpr Index kMaxEntries = 4'000'000;

/// So many sweeps are made only where all other methods have given up.
constexpr PsorSettings kSweeps{.max_iterations = 900'000, .relaxation = 1, .tolerance = 1e-9};

std::unique_ptr<BudgetedSolver> make_method(AutoMethod method, const std::shared_ptr<LaterEngines>& later) {
  switch (method) {
    case AutoMethod::kContactLemke: return std::make_unique<ContactLemke>(ContactLemkeSettings{}, later);
    case AutoMethod::kVelocityIpm: return make_velocity_ipm();
    case AutoMethod::kFrictionIpm: return make_friction_ipm();
    case AutoMethod::kPsor: return make_psor(kSweeps);
    case AutoMethod::kContactIpm: return make_contact_ipm();
    default: return std::make_unique<ActiveSet>(ActiveSetSettings{});
  }
}

}  // namespace

bool Methods::takes(AutoMethod method, const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  if (is_dense(method) && dense_entries(contact) > kMaxEntries) return false;
  const Capabilities& lemke = ContactLemke::kCapabilities;
  if (method == AutoMethod::kContactLemke && problem.size() > lemke.max_size) return why_not(lemke, problem).empty();
  if (method == AutoMethod::kVelocityIpm || method == AutoMethod::kActiveSet) return !contact.frictional();
  return method != AutoMethod::kContactIpm || contact.inertia.index() <= 1;  // G is given
}

double Methods::load_work(AutoMethod method, const Problem& problem, Index idle) {
  if (method == AutoMethod::kActiveSet) return ActiveSet::load_work(problem, idle);
  return method == AutoMethod::kContactLemke ? ContactLemke::load_work(problem, idle) : 0;
}

void Methods::begin(const Problem& problem, const Vector& v, bool is_one_island) {
  problem_ = &problem;
  v_ = &v;
  is_one_island_ = is_one_island;
  is_loaded_.fill(false);
  has_least_energy_ = false;
}

void Methods::set_velocity(const Vector& v) {
  v_ = &v;
  if (has_least_energy_) least_energy_->update(v);
  for (std::size_t k = 0; k < kAutoMethods; ++k) {
    if (is_loaded_[k]) solvers_[k]->update(v);
  }
}

BudgetedSolver& Methods::made(AutoMethod method) {
  std::unique_ptr<BudgetedSolver>& solver = solvers_[static_cast<std::size_t>(method)];
  if (solver == nullptr) solver = make_method(method, later_);
  return *solver;
}

void Methods::reserve(AutoMethod method, const Problem& problem, bool with_least_energy) {
  if (method == AutoMethod::kActiveSet) static_cast<ActiveSet&>(made(method)).reserve(problem);
  if (method == AutoMethod::kContactLemke || with_least_energy) {
    static_cast<ContactLemke&>(made(AutoMethod::kContactLemke)).reserve(problem);
  }
  if (!with_least_energy) return;
  if (least_energy_ == nullptr) least_energy_ = std::make_unique<LeastEnergy>();
  least_energy_->reserve(*problem.contact());
}

BudgetedSolver& Methods::loaded(AutoMethod method) {
  BudgetedSolver& solver = made(method);
  bool& is_loaded = is_loaded_[static_cast<std::size_t>(method)];
  if (is_loaded) return solver;
  if (method == AutoMethod::kContactLemke) static_cast<ContactLemke&>(solver).expect_one_island(is_one_island_);
  solver.load_finite(*problem_);
  is_loaded = true;
  if (*v_ != problem_->contact()->v) solver.update(*v_);
  return solver;
}

LeastEnergy& Methods::loaded_least_energy() {
  if (least_energy_ == nullptr) least_energy_ = std::make_unique<LeastEnergy>();
  if (!has_least_energy_) {
    least_energy_->reserve(*problem_->contact());
    least_energy_->load(*problem_->contact(), *v_);
  }
  has_least_energy_ = true;
  return *least_energy_;
}

void Methods::respond(AutoMethod method, const Vector& z, Vector& u) {
  if (method == AutoMethod::kContactLemke) return static_cast<ContactLemke&>(loaded(method)).respond(z, u);
  if (auto* psor = dynamic_cast<PsorSolver*>(&loaded(method))) return psor->respond(z, u);
  ContactProblem moving = *problem_->contact();
  moving.v = *v_;
  u = post_impact_velocity(moving, z);
}

}  // namespace lcpbench
