#include "native/contact_lemke.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <variant>

#include "core/quad.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

/// One rung of the cascade.
struct ContactRung {
  bool quad = false;
  bool classic = false;
  std::ptrdiff_t variant = 0;
  bool reinvert = false;
  const char* name = "";  ///< short enough for std::string to hold in place
};

namespace {

using contact_lemke::Ending;
using contact_lemke::Engine;
using contact_lemke::Residual;
using contact_lemke::Rules;

constexpr double kFloatUnitRoundoff = 0x1p-24;
constexpr double kDoubleUnitRoundoff = 0x1p-53;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The residual up to which kSolved is claimed, relative to max|q|: half of the evaluation's bound, to be on its safe
/// side whatever this test itself rounds.
constexpr double kClaimedResidual = 5e-5;

struct Engines {
  const Engine& in_double;
  const Engine& in_float;
};

Engines engines_at(IsaLevel level) {
  if (level > best_isa_level()) throw std::invalid_argument("this processor lacks the instruction-set level asked for");
#if defined(__x86_64__)
  if (level == IsaLevel::kAvx512) return {lemke::avx512::kContactEngine, lemke::avx512::kFloatContactEngine};
  if (level == IsaLevel::kAvx2) return {lemke::avx2::kContactEngine, lemke::avx2::kFloatContactEngine};
#endif
  return {lemke::baseline::kContactEngine, lemke::baseline::kFloatContactEngine};
}

constexpr std::array kRungs{ContactRung{.name = ""},
                            ContactRung{.reinvert = true, .name = "reinverted"},
                            ContactRung{.variant = 1, .reinvert = true, .name = "second path"},
                            ContactRung{.variant = 2, .reinvert = true, .name = "third path"},
                            ContactRung{.classic = true, .reinvert = true, .name = "classic"},
                            ContactRung{.quad = true, .name = "quad"},
                            ContactRung{.quad = true, .classic = true, .name = "quad, classic"}};

/// The classic covering vector takes many pivots: above this order of kernels their inversion would cost more than the
/// rungs in 113 bits, and is left to the path's own judgement.
constexpr std::ptrdiff_t kSmallKernel = 32;

bool climbs_to_quad(const ContactLemkeSettings& settings) {
  return settings.precision == ContactLemkePrecision::kQuad || settings.precision == ContactLemkePrecision::kCascade;
}

bool returns_velocity(const ContactLemkeSettings& settings) {
  return settings.precision == ContactLemkePrecision::kPolished || settings.precision == ContactLemkePrecision::kQuad;
}

bool wanted(const ContactRung& rung, const ContactLemkeSettings& settings) {
  if (rung.quad && !climbs_to_quad(settings)) return false;
  if (!rung.quad && settings.precision == ContactLemkePrecision::kQuad) return false;
  if (rung.classic && settings.covering == ContactLemkeCovering::kNormals) return false;
  if (!rung.classic && settings.covering == ContactLemkeCovering::kClassic) return false;
  return true;
}

}  // namespace

LoadedContacts::LoadedContacts(const Engine& engine) : engine_(engine), state_(engine.create()) {}

LoadedContacts::~LoadedContacts() { engine_.destroy(state_); }

void ContactLemke::ContactData::load(const ContactProblem& contact) {
  v = contact.v;
  mu = contact.mu;
  const ContactLayout layout = contact_layout(contact);
  friction_begin.assign(layout.friction_begin.begin(), layout.friction_begin.end());
  input = {};
  input.ngc = contact.ngc();
  input.nc = contact.nc();
  input.v = v.data();
  input.N = dense_data(contact.N, N);
  input.D = dense_data(contact.D, D);
  input.friction_begin = friction_begin.data();
  input.mu = mu.data();
  load_inertia(contact.inertia);
}

const double* ContactLemke::ContactData::dense_data(const Jacobian& jacobian, Matrix& copy) {
  if (const auto* dense = std::get_if<Matrix>(&jacobian)) return dense->data();
  copy = to_dense(jacobian);
  return copy.data();
}

void ContactLemke::ContactData::load_inertia(const Inertia& inertia) {
  contact_lemke::InertiaInput& to = input.inertia;
  offsets.assign(1, 0);
  blocks.clear();
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    add_block(dense->G);
  } else if (const auto* separate = std::get_if<BlockInertia>(&inertia)) {
    for (const Matrix& block : separate->blocks) add_block(block);
  } else if (const auto* factored = std::get_if<FactoredInertia>(&inertia)) {
    to.factors = factored->X.cols();
    to.X = factored->X.data();
    to.alpha = factored->alpha.data();
  } else {
    to.Ginv = std::get<InverseInertia>(inertia).Ginv.data();
  }
  to.blocks = static_cast<std::ptrdiff_t>(blocks.size());
  to.offsets = offsets.data();
  to.G = blocks.data();
}

void ContactLemke::ContactData::add_block(const Matrix& G) {
  blocks.push_back(G.data());
  offsets.push_back(offsets.back() + G.rows());
}

Capabilities contact_lemke_capabilities(const ContactLemkeSettings& settings) {
  Capabilities capabilities;
  capabilities.needs = Needs::kFactored;
  capabilities.max_size = 3000;  // dense matrices of order ngc, which may be several times n
  capabilities.guarantees = "contact problems with mu >= 0 and positive definite G, without degeneracy";
  capabilities.obeys_time_limit = true;
  // The memory of 113-bit arithmetic is taken when a problem first needs it.
  // So is the velocity's, of which the answer keeps none from one solve to the next.
  capabilities.allocation_free =
      settings.precision == ContactLemkePrecision::kDouble || settings.precision == ContactLemkePrecision::kFloat;
  return capabilities;
}

ContactLemke::ContactLemke(const ContactLemkeSettings& settings, IsaLevel level)
    : settings_(settings),
      capabilities_(contact_lemke_capabilities(settings)),
      double_(engines_at(level).in_double),
      quad_(lemke::quad::kContactEngine),
      float_(engines_at(level).in_float) {}

const Capabilities& ContactLemke::capabilities() const { return capabilities_; }

void ContactLemke::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  data_.load(contact);
  double_.load(data_.input);
  if (in_float()) float_.load(data_.input);
  quad_is_loaded_ = false;
  best_.resize(problem.size());
  best_velocity_.resize(0);
}

void ContactLemke::on_update(const Vector& v) {
  if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
  data_.v = v;
  double_.set_velocity(data_.v.data());
  if (in_float()) float_.set_velocity(data_.v.data());
  if (quad_is_loaded_) quad_.set_velocity(data_.v.data());
}

LoadedContacts& ContactLemke::engine_of(bool quad) {
  if (!quad) return in_float() ? float_ : double_;
  if (!quad_is_loaded_) {
    quad_.load(data_.input);
    quad_is_loaded_ = true;
  }
  return quad_;
}

double ContactLemke::roundoff_of(const LoadedContacts& engine) const {
  if (&engine == &quad_) return kQuadUnitRoundoff;
  return &engine == &float_ ? kFloatUnitRoundoff : kDoubleUnitRoundoff;
}

/// Several times what the sets of the study take at most.
std::ptrdiff_t ContactLemke::pivots_of_rung(bool classic) const {
  const std::ptrdiff_t rows = data_.input.nc + data_.input.ngc;
  return classic ? 50 * (rows + data_.friction_begin.back()) + 500 : 20 * rows + 100;
}

void ContactLemke::on_solve(const SolveRequest& request, Answer& answer) {
  Progress progress;
  progress.deadline_s = std::isinf(request.time_limit_s) ? kInfinity : wall_clock_s() + request.time_limit_s;
  for (const ContactRung& rung : kRungs) {
    if (!wanted(rung, settings_)) continue;
    if (rung.quad && progress.best <= kClaimedResidual) break;
    Rules rules;
    rules.classic = rung.classic;
    rules.variant = rung.variant;
    rules.reinvert = rung.reinvert && (!rung.classic || data_.input.ngc <= kSmallKernel);
    if (climb(rung, rules, progress, answer)) break;
  }
  report(progress, answer);
}

/// @returns whether nothing remains to be tried.
bool ContactLemke::climb(const ContactRung& rung, Rules rules, Progress& progress, Answer& answer) {
  LoadedContacts& engine = engine_of(rung.quad);
  const Ending ending = run(engine, rules, progress, answer.z);
  if (ending == Ending::kTimeLimit) return true;
  if (ending == Ending::kPivotLimit) return progress.pivots_left(settings_.max_pivots) <= 0;
  if (ending == Ending::kRay) return !progress.disproof_was_tried && disprove(engine, progress, answer);
  if (ending != Ending::kSolved) return false;
  if (returns_velocity(settings_)) polish(engine, answer);
  const Residual residual = (in_float() ? double_ : engine).complete(answer.z.data());
  if (residual.certain < progress.best) {
    progress.best = residual.certain;
    progress.rung = rung.name;
    best_ = answer.z;
    best_velocity_ = answer.velocity;
  }
  return residual.velocity <= settings_.accept_residual && residual.certain <= kClaimedResidual;
}

void ContactLemke::polish(LoadedContacts& engine, Answer& answer) {
  answer.velocity.resize(data_.input.ngc);
  if (!engine.polish(answer.velocity.data(), answer.z.data())) answer.velocity.resize(0);
}

Ending ContactLemke::run(LoadedContacts& engine, Rules rules, Progress& progress, Vector& z) {
  const double roundoff = roundoff_of(engine);
  rules.pivot_tolerance = roundoff * settings_.pivot_tolerance;
  rules.tie_tolerance = roundoff * settings_.tie_tolerance;
  rules.residual_tolerance = roundoff * settings_.refine_tolerance;
  rules.max_pivots = std::min(pivots_of_rung(rules.classic), progress.pivots_left(settings_.max_pivots));
  rules.refinements = static_cast<std::ptrdiff_t>(settings_.max_refinements);
  rules.deadline_s = progress.deadline_s;
  rules.clock_s = wall_clock_s;
  z.setZero();
  const contact_lemke::Outcome outcome = engine.solve(rules, z.data());
  progress.pivots += outcome.pivots;
  progress.factorizations += outcome.factorizations;
  progress.ending = outcome.ending;
  return outcome.ending;
}

/// A ray of the problem without friction proves that nothing solves the problem with it.
bool ContactLemke::disprove(LoadedContacts& engine, Progress& progress, Answer& answer) {
  progress.disproof_was_tried = true;
  Rules rules;
  rules.frictionless = true;
  const Ending ending = run(engine, rules, progress, answer.z);
  if (ending == Ending::kTimeLimit) return true;
  if (ending != Ending::kRay || !(in_float() ? double_ : engine).disproves(answer.z.data())) return false;
  progress.disproved = true;
  answer.farkas = answer.z.head(data_.input.nc);
  return true;
}

void ContactLemke::report(const Progress& progress, Answer& answer) {
  answer.counters.iterations = answer.counters.pivots = progress.pivots;
  answer.counters.factorizations = progress.factorizations;
  if (progress.best <= kClaimedResidual) {
    answer.claim = Claim::kSolved;
    answer.z = best_;
    answer.velocity = best_velocity_;
    answer.detail = progress.rung;
    return;
  }
  answer.z.setZero();
  answer.velocity.resize(0);
  if (progress.disproved) {
    answer.claim = Claim::kUnsolvable;
    answer.detail = "ray, proven";
  } else if (progress.ending == Ending::kTimeLimit) {
    answer.claim = Claim::kTimeLimit;
  } else if (progress.ending == Ending::kPivotLimit) {
    answer.claim = Claim::kIterationLimit;
    answer.detail = "pivot limit";
  } else {
    answer.claim = Claim::kNumericalFailure;
    answer.detail = progress.ending == Ending::kRay ? "ray, no proof" : "residual";
  }
}

SolverDefinition lcpbench_solver_contact_lemke() {
  return define_solver<ContactLemke, ContactLemkeSettings>(
      {.name = "contact_lemke",
       .summary = "Lemke's method on contacts: friction only where a contact presses, refined or in 113 bits on demand",
       .source = "Lemke 1965; Anitescu, Potra 1997; Cottle, Pang, Stone 1992, 4.4",
       .capabilities = contact_lemke_capabilities({})});
}

}  // namespace lcpbench
