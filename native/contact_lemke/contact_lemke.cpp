#include "native/contact_lemke/contact_lemke.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/quad.h"
#include "core/registry.h"
#include "core/timed_solve.h"

namespace lcpbench {

/// One stage of the cascade.
struct ContactStage {
  ContactArithmetic arithmetic = ContactArithmetic::kDouble;
  bool classic = false;
  std::ptrdiff_t variant = 0;
  bool reinvert = false;
  const char* name = "";  ///< short enough for std::string to hold in place
};

namespace {

using contact_lemke::Ending;
using contact_lemke::Engine;
using contact_lemke::Outcome;
using contact_lemke::Residual;
using contact_lemke::Rules;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr std::array kStages{
    ContactStage{.name = ""},
    ContactStage{.reinvert = true, .name = "reinverted"},
    ContactStage{.variant = 1, .reinvert = true, .name = "second path"},
    ContactStage{.variant = 2, .reinvert = true, .name = "third path"},
    ContactStage{.classic = true, .reinvert = true, .name = "classic"},
    ContactStage{.arithmetic = ContactArithmetic::kQuad, .name = "quad"},
    ContactStage{.arithmetic = ContactArithmetic::kQuad, .classic = true, .name = "quad, classic"}};

/// Before all, where a solve goes on from the last one.
constexpr ContactStage kWarmStage{.name = "warm"};

/// Above so many coordinates no stage inverts the kernel at each pivot: that takes longer than the stages in 113 bits,
/// and helps less. Where those may follow, the stage `reinverted` is left out, and so is `classic` in double, which
/// takes many pivots.
constexpr std::ptrdiff_t kSmallKernel = 32;

/// More multiplications than any limit on work asks for.
constexpr double kMostWork = 0x1p60;

/// Up to this residual an answer that may not be claimed is returned, as the verdict may count it. Beyond it zeros may be
/// nearer to a solution.
constexpr double kReturnedResidual = 1e-4;

/// Seconds for a unit of work, as a rule, to tell what a time limit rules out.
constexpr double kTimeOfWork = 1e-10;

/// A multiplication of an engine's numbers, in multiplications of doubles. Measured as the time of paths over their
/// count of multiplications, from 9 to 216 coordinates: 0.065 ns in double (AVX2), 25 to 40 in 113 bits.
double price_of(ContactArithmetic arithmetic) { return arithmetic == ContactArithmetic::kQuad ? 420 : 1; }

/// Impulses, each with an opposite one counted once.
double rows_of(const ContactProblem& contact) {
  return static_cast<double>(contact.nc()) + static_cast<double>(cols(contact.D)) / 2;
}

// Work in multiplications of doubles (0.065 ns), fitted to times of the engine in double. Parameters: `ngc`, without
// the coordinates that no contact moves; `rows`, of rows_of().

/// Of loading an engine. @param block  the order of the largest block of the inertia
double work_of_load(std::ptrdiff_t ngc, std::ptrdiff_t block, double rows) {
  const double order = static_cast<double>(ngc);
  const double range = static_cast<double>(contact_lemke::kLeastRange + block);
  const bool is_one_range = ngc < 2 * contact_lemke::kLeastRange || range > order;
  const double factors = is_one_range ? 1.7 * order * order : 1.7 * range * range + (4 + 0.04 * order) * order;
  return std::round(order * (factors + 3.4 * rows)) + 20000;
}

/// Of completing and testing an answer (Engine::complete()).
double work_of_test(std::ptrdiff_t ngc, double rows) {
  const double order = static_cast<double>(ngc);
  return 12 * order * (order + rows) + 8000;
}

/// Of deciding whether there is a solution, as a rule.
double work_of_proof(std::ptrdiff_t ngc, double rows) {
  const double order = static_cast<double>(ngc);
  return order * order * (order + rows);
}

bool wanted(const ContactStage& stage, const ContactLemkeSettings& settings, std::ptrdiff_t ngc) {
  using Precision = ContactLemkePrecision;
  const bool cascade = settings.precision == Precision::kCascade;
  if (stage.arithmetic == ContactArithmetic::kQuad && !cascade && settings.precision != Precision::kQuad) return false;
  if (stage.arithmetic == ContactArithmetic::kDouble && settings.precision == Precision::kQuad) return false;
  if (stage.reinvert && cascade && ngc > kSmallKernel && (stage.classic || stage.variant == 0)) return false;
  if (stage.classic && settings.covering == ContactLemkeCovering::kNormals) return false;
  if (!stage.classic && settings.covering == ContactLemkeCovering::kClassic) return false;
  return true;
}

}  // namespace

contact_lemke::Engine::~Engine() = default;

std::unique_ptr<Engine> make_contact_lemke_engine(IsaLevel level) {
  if (level > best_isa_level()) throw std::invalid_argument("this processor lacks the instruction-set level asked for");
#if defined(__x86_64__)
  if (level >= IsaLevel::kAvx2) return std::unique_ptr<Engine>(contact_lemke::avx2::create_engine());
#endif
  return std::unique_ptr<Engine>(contact_lemke::baseline::create_engine());
}

LaterEngines::LaterEngines() : quad(contact_lemke::quad::create_engine()) {}

ContactLemke::ContactLemke(const ContactLemkeSettings& settings, IsaLevel level)
    : ContactLemke(settings, std::make_shared<LaterEngines>(), level) {}

ContactLemke::ContactLemke(const ContactLemkeSettings& settings, std::shared_ptr<LaterEngines> later, IsaLevel level)
    : settings_(settings), double_(make_contact_lemke_engine(level)), later_(std::move(later)) {}

double ContactLemke::load_work(const Problem& problem, Index idle) {
  const ContactProblem& contact = *problem.contact();
  Index block = 0;
  for_each_matrix(contact.inertia, [&](const Matrix& G, Index) { block = std::max(block, G.rows()); });
  return work_of_load(contact.ngc() - idle, block, rows_of(contact));
}

void ContactLemke::reserve(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  doubtful_.reserve(contact);
  const Index ngc = ContactInput::coordinates(contact);
  data_.reserve(ngc, contact.nc(), cols(contact.D));
  best_.reserve(problem.size());
  z_.reserve(problem.size());
  given_v_.reserve(ngc);
  data_.load_layout(contact);
  double_->reserve(data_.input);
  reserve_later_stages(data_.input);
}

/// With precision=double too, where 113 bits test what double is in doubt of. Does nothing if the last problem that it
/// took memory for was not smaller in any respect.
void ContactLemke::reserve_later_stages(const contact_lemke::Input& input) {
  std::array<std::ptrdiff_t, 8> room{
      input.ngc, input.nc, 0, 0, 0, 0, input.inertia.Ginv == nullptr ? 1 : 0, input.compliance_n != nullptr ? 1 : 0};
  for (std::ptrdiff_t c = 0; c < input.nc; ++c) {
    const std::ptrdiff_t edges = input.friction_begin[c + 1] - input.friction_begin[c];
    const bool has_friction = edges > 0 && input.mu[c] > 0;
    room[2] = std::max(room[2], edges);
    room[3] += edges;
    room[4] += has_friction ? 1 : 0;
    room[5] += has_friction ? edges : 0;
  }
  if (std::equal(room.begin(), room.end(), room_in_later_stages_.begin(), std::less_equal<>{})) return;
  room_in_later_stages_ = room;
  later_->quad->reserve(input);
  later_->holder = nullptr;
}

void ContactLemke::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  data_.load(contact);
  may_be_unsolvable_ = may_be_unsolvable(contact);
  if (may_be_unsolvable_) farkas_.load(contact);
  doubtful_.load(contact);
  if (asks_for_given_velocity()) given_v_ = contact.v;
  double_->load(data_.input);
  if (later_->holder == this) later_->holder = nullptr;
  reserve_later_stages(data_.input);
  best_.resize(problem.size());
  z_.resize(problem.size());
  progress_ = {};
  found_ = {};
  has_basis_ = false;
}

void ContactLemke::on_update(const Vector& v) {
  if (!v.allFinite()) return Solver::on_update(v);  // refuses it, as load does
  data_.set_velocity(v);
  if (asks_for_given_velocity()) given_v_ = v;
  double_->set_velocity(data_.v.data());
  if (later_->holder == this) later_->quad->set_velocity(data_.v.data());
}

void ContactLemke::respond(const Vector& z, Vector& velocity) {
  (later_->holder == this ? later_->quad : double_)->respond(z.data(), velocity.data());
  if (data_.units.size() > 0) velocity.array() *= data_.units.view().array();
}

bool ContactLemke::holds(ContactArithmetic arithmetic) const {
  return arithmetic == ContactArithmetic::kDouble || later_->holder == this;
}

/// The work of making the engine hold this problem; 0 where it does.
double ContactLemke::work_until_loaded(ContactArithmetic arithmetic) const {
  return holds(arithmetic) ? 0 : price_of(arithmetic) * load_work(problem(), 0);
}

Engine& ContactLemke::engine_of(ContactArithmetic arithmetic) {
  if (arithmetic == ContactArithmetic::kDouble) return *double_;
  if (later_->holder == this) return *later_->quad;
  later_->holder = nullptr;  // load() may throw, and then the data of the last holder are gone
  later_->quad->load(data_.input);
  later_->holder = this;
  return *later_->quad;
}

/// The limit on the pivots of a path, which ends those that cycle. On the first path contacts often tie, as those of
/// symmetric bodies do, and it may cycle: its limit is one that all but 6 of 2,032 paths on the study's sets keep.
/// Others have several times the most that they take, and more in 113 bits, where a large kernel was too much for double.
std::ptrdiff_t ContactLemke::pivots_of(const ContactStage& stage) const {
  const std::ptrdiff_t rows = data_.input.nc + data_.input.ngc;
  if (rules_.resume) return 2 * rows + 10;  // where that is of little help, it is better to begin anew
  if (stage.classic) return 50 * (rows + data_.friction_begin.back()) + 500;
  if (stage.arithmetic == ContactArithmetic::kQuad) return (data_.input.ngc > kSmallKernel ? 60 : 20) * rows + 100;
  const bool is_first = stage.variant == 0 && !stage.reinvert;
  return (is_first ? 4 : 20) * rows + 100;
}

void ContactLemke::begin(const Budget& budget) {
  progress_ = {};
  found_ = {};
  const double most = ContactLemkeSettings{}.accept_residual;
  progress_.accepted = budget.error > 0 ? std::min(budget.error, most) : settings_.accept_residual;
  progress_.deadline_s = budget.deadline_s;
  progress_.most_work = budget.work;
}

bool ContactLemke::solve_within(const Budget& budget, Answer& answer) {
  begin(budget);
  answer.reserve(problem());
  answer.z.resize(problem().size());
  answer.z.setZero();
  const bool has_ended = follow_stages(answer.z.data());
  report(answer);
  return has_ended;
}

void ContactLemke::on_solve(const SolveRequest& request, Answer& answer) {
  begin({.deadline_s = std::isinf(request.time_limit_s) ? kInfinity : wall_clock_s() + request.time_limit_s});
  follow_stages(answer.z.data());
  report(answer);
}

double ContactLemke::residual(const Answer& answer) {
  if (!(found_.best < kInfinity)) return kInfinity;
  z_ = answer.z;
  return double_->complete(z_.data()).velocity;
}

/// @param z n entries for the impulses of stages
/// @returns whether nothing remains to be tried; if not, the budget of work is over
bool ContactLemke::follow_stages(double* z) {
  if (std::exchange(has_basis_, false) && resumes_) {
    rules_ = {};
    rules_.resume = true;
    const Climbed climbed = climb(kWarmStage, z);
    if (climbed != Climbed::kFailed) return climbed == Climbed::kLast;
  }
  std::int64_t counted = 0;
  for (const ContactStage& stage : kStages) {
    if (!wanted(stage, settings_, data_.input.ngc)) continue;
    if (max_stages_ > 0 && counted == max_stages_) return true;
    if (stage.arithmetic != ContactArithmetic::kDouble && found_.can_claim) return true;
    if (!begins(stage)) continue;
    const int long_paths = found_.long_paths;
    const Climbed climbed = climb(stage, z);
    if (climbed != Climbed::kFailed) return climbed == Climbed::kLast;
    if (found_.long_paths == long_paths) ++counted;
  }
  return true;
}

/// Sets the rules of the stage's path. False where it would be a path that has been ended by its limit on pivots.
bool ContactLemke::begins(const ContactStage& stage) {
  Rules& rules = rules_;
  rules = {};
  rules.classic = stage.classic;
  rules.variant = stage.variant;
  if (found_.long_paths > 0 && !stage.classic && stage.variant == 0) {  // in any arithmetic
    if (stage.arithmetic == ContactArithmetic::kDouble) return false;
    rules.variant = 1;
  }
  rules.reinvert = stage.reinvert && found_.long_paths == 0 && data_.input.ngc <= kSmallKernel;
  return true;
}

ContactLemke::Climbed ContactLemke::climb(const ContactStage& stage, double* z) {
  if (!holds(stage.arithmetic)) {  // what loading the engine will take is counted before it is done
    const double work = work_until_loaded(stage.arithmetic);
    found_.ending = has_time_for(work) ? Ending::kPivotLimit : Ending::kTimeLimit;
    if (found_.ending == Ending::kTimeLimit) return Climbed::kLast;
    progress_.work += work;
    if (progress_.work > progress_.most_work) return Climbed::kOutOfWork;
  }
  const Outcome outcome = run(stage, z);
  return outcome.is_out_of_work ? Climbed::kOutOfWork : judge(stage, outcome.ending, z);
}

bool ContactLemke::has_time_for(double work) const {
  return !std::isfinite(progress_.deadline_s) || wall_clock_s() + kTimeOfWork * work <= progress_.deadline_s;
}

/// Keeps the answer of a path that has ended if it is the best so far. @returns what is to be done next
ContactLemke::Climbed ContactLemke::judge(const ContactStage& stage, Ending ending, double* z) {
  const auto last_if = [](bool is_last) { return is_last ? Climbed::kLast : Climbed::kFailed; };
  if (ending == Ending::kTimeLimit) return Climbed::kLast;
  if (rules_.resume && ending != Ending::kSolved) return last_if(found_.pivots_left(settings_.max_pivots) <= 0);
  if (ending == Ending::kPivotLimit) {
    ++found_.long_paths;
    return last_if(found_.pivots_left(settings_.max_pivots) <= 0);
  }
  if (ending == Ending::kRay) return last_if(is_disproved());
  if (ending != Ending::kSolved) return Climbed::kFailed;
  Engine& engine = engine_of(stage.arithmetic);
  const bool is_quad = stage.arithmetic == ContactArithmetic::kQuad;
  Residual residual = engine.complete(z);
  progress_.work += price_of(stage.arithmetic) * work_of_test(data_.input.ngc, rows_of(*problem().contact()));
  const bool in_doubt = residual.velocity <= kClaimedResidual && !(residual.certain <= kClaimedResidual);
  const double work = work_until_loaded(ContactArithmetic::kQuad);
  if (in_doubt && is_confirmed_exactly(z)) {
    residual.certain = residual.velocity;
  } else if (in_doubt && !is_quad && has_time_for(work)) {
    progress_.work += work;
    residual = engine_of(ContactArithmetic::kQuad).complete(z);
  }
  found_.is_beyond_double = is_quad && !(residual.certain <= kClaimedResidual);
  const bool is_small = residual.certain <= kClaimedResidual;
  const bool is_doubtful = is_small && doubtful_.may_be_singular() && residual.velocity > kSureResidual;
  if (is_doubtful && is_disproved()) return Climbed::kLast;
  const bool can_claim = is_small && !is_doubtful;
  if (can_claim != found_.can_claim ? can_claim : residual.certain < found_.best) {
    found_.can_claim = can_claim;
    found_.best = residual.certain;
    found_.stage = stage.name;
    best_.view() = Eigen::Map<const Vector>(z, best_.size());
    found_.is_best = true;
  }
  const bool is_accepted = residual.velocity <= progress_.accepted && can_claim;
  has_basis_ = is_accepted && !is_quad && !stage.classic;
  return last_if(is_accepted);
}

/// Where the rank of the inertia's factors is in doubt, 113 bits may cut it wrongly, too.
bool ContactLemke::is_confirmed_exactly(const double* z) {
  if (!doubtful_.is_doubtful()) return false;
  Answer answer;
  answer.z = Eigen::Map<const Vector>(z, best_.size());
  return doubtful_.confirms(*problem().contact(), given_v_.view(), answer);
}

/// The path of a stage.
contact_lemke::Outcome ContactLemke::run(const ContactStage& stage, double* z) {
  Rules& rules = rules_;
  const double price = price_of(stage.arithmetic);
  rules.max_pivots = std::min(pivots_of(stage), found_.pivots_left(settings_.max_pivots));
  rules.clock_s = wall_clock_s;
  rules.deadline_s = progress_.deadline_s;
  if (progress_.most_work < kMostWork) {
    rules.max_work = static_cast<std::ptrdiff_t>((progress_.most_work - progress_.work) / price) + 1;
  } else {
    rules.max_work = Rules{}.max_work;
  }
  if (!progress_.is_fresh) Eigen::Map<Vector>(z, best_.size()).setZero();
  progress_.is_fresh = found_.is_best = false;
  const Outcome outcome = engine_of(stage.arithmetic).solve(rules, z);
  progress_.work += price * static_cast<double>(outcome.work);
  found_.pivots += outcome.pivots;
  found_.factorizations += outcome.factorizations;
  found_.ending = outcome.ending;
  return outcome;
}

/// Whether there is proven to be no solution. Asked once in a solve.
bool ContactLemke::is_disproved() {
  if (!may_be_unsolvable_ || found_.is_asked) return found_.is_disproved;
  found_.is_asked = true;
  progress_.work += work_of_proof(data_.input.ngc, rows_of(*problem().contact()));
  return found_.is_disproved = farkas_.proves_unsolvable(given_v_.view(), progress_.deadline_s);
}

void ContactLemke::report(Answer& answer) {
  answer.counters.iterations = answer.counters.pivots = found_.pivots;
  answer.counters.factorizations = found_.factorizations;
  if (!(found_.best <= kReturnedResidual)) {
    answer.z.setZero();
  } else if (!found_.is_best) {
    answer.z = best_.view();
  }
  if (found_.can_claim) {
    answer.claim = Claim::kSolved;
    answer.detail = found_.stage;
    if (doubtful_.confirms(*problem().contact(), given_v_.view(), answer)) return;
    answer.claim = Claim::kNumericalFailure;
    answer.detail = "residual";
    answer.z.setZero();
    return;
  }
  if (found_.is_disproved) {
    answer.z.setZero();
    answer.claim = Claim::kUnsolvable;
    answer.farkas = farkas_.proof();
    answer.detail = "the normals contradict each other";
  } else if (found_.ending == Ending::kTimeLimit) {
    answer.claim = Claim::kTimeLimit;
  } else if (found_.ending == Ending::kPivotLimit) {
    answer.claim = Claim::kIterationLimit;
    answer.detail = "pivot limit";
  } else {
    answer.claim = Claim::kNumericalFailure;
    answer.detail = found_.ending == Ending::kRay ? "ray, no proof" : "residual";
    if (found_.is_beyond_double) answer.detail = "z beyond double";
  }
}

SolverDefinition lcpbench_solver_contact_lemke() {
  return define_solver<ContactLemke, ContactLemkeSettings>(
      {.name = "contact_lemke",
       .summary = "Lemke's method on contacts: friction only where a contact presses, refined or in 113 bits on demand",
       .source = "Lemke 1965; Anitescu, Potra 1997; Cottle, Pang, Stone 1992, 4.4",
       .capabilities = ContactLemke::kCapabilities});
}

}  // namespace lcpbench
