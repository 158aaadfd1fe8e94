#include "native/answer_test.h"

#include <variant>

#include "core/answer_storage.h"
#include "core/quad.h"
#include "core/timed_solve.h"

namespace lcpbench {
namespace {

using contact_lemke::Ending;

/// Of the verdict's 1e-4, relative to max|q|: in 113 bits nothing is lost to rounding but that of the returned lambdas.
constexpr double kClaimedQuadResidual = 0.999e-4;

constexpr double kDoubleUnitRoundoff = 0x1p-53;

/// Whether there may be directions in which nothing moves, so that contacts can ask for what no impulse does.
bool may_be_singular(const Inertia& inertia) {
  return std::holds_alternative<FactoredInertia>(inertia) || std::holds_alternative<InverseInertia>(inertia);
}

}  // namespace

AnswerTest::AnswerTest() : judge_(contact_lemke_engine(isa_level())), quad_judge_(lemke::quad::kContactEngine) {}

void AnswerTest::load(const Problem& problem, Bodies bodies) {
  completed_.resize(problem.size());
  const Index farkas_size = problem.contact() == nullptr ? problem.size() : problem.contact()->nc();
  if (farkas_size != farkas_size_) farkas_.resize(farkas_size);  // else it was taken, or given away
  farkas_size_ = farkas_size;
  bare_ = problem.contact() == nullptr;
  by_bodies_ =
      bodies == Bodies::kOneByOne && !bare_ && std::holds_alternative<BlockInertia>(problem.contact()->inertia);
  may_be_singular_ = false;
  if (by_bodies_) return bodies_test_.load(*problem.contact());
  if (bare_) return bare_test_.load(problem.lcp());
  const ContactProblem& contact = *problem.contact();
  contacts_.load_in_units(contact);
  judge_.load(contacts_.input);
  quad_judge_.reserve(contacts_.input);
  quad_is_loaded_ = false;
  may_be_singular_ = may_be_singular(contact.inertia);
  if (may_be_singular_) path_end_.resize(problem.size());
}

void AnswerTest::set_velocity(const Vector& v) {
  if (by_bodies_) return bodies_test_.set_velocity(v);
  contacts_.set_velocity(v);
  judge_.set_velocity(contacts_.v.data());
  if (quad_is_loaded_) quad_judge_.set_velocity(contacts_.v.data());
}

bool AnswerTest::settle(Answer& answer, double deadline_s) {
  if (answer.claim != Claim::kSolved) return false;
  const Outcome outcome = solves(answer.z) ? confirm(deadline_s) : Outcome::kResidual;
  switch (outcome) {  // details are short enough for std::string to hold in place
    case Outcome::kSolved: answer.z = completed_; return true;
    case Outcome::kUnsolvable: report_proof(answer); return false;
    case Outcome::kResidual: answer.detail = "residual"; break;
    case Outcome::kUnconfirmed: answer.detail = "unconfirmed"; break;
    case Outcome::kOutOfTime:
      answer.claim = Claim::kTimeLimit;
      answer.detail.clear();
      return false;
  }
  answer.claim = Claim::kNumericalFailure;
  return false;
}

void AnswerTest::settle_ray(Answer& answer, double deadline_s, const Vector* u) {
  bool proven = false;
  if (bare_) {
    proven = u != nullptr ? bare_test_.disproves_near(*u, deadline_s) : bare_test_.disproves(deadline_s);
  } else if (!by_bodies_ && may_be_singular_) {
    proven = disproves_contacts({.deadline_s = deadline_s});
  }
  if (proven) return report_proof(answer);
  answer.claim = Claim::kNumericalFailure;
  answer.detail = "ray";
}

void AnswerTest::report_proof(Answer& answer) {
  answer.claim = Claim::kUnsolvable;
  answer.detail = bare_ ? "proven" : "ray to rounding";
  if (bare_ && bare_test_.proof().size() == 0) return;  // by exact enumeration of all supports
  Vector& farkas = cleared_vectors().farkas;
  if (farkas.size() != farkas_size_ && farkas_.size() == farkas_size_) farkas.swap(farkas_);
  if (bare_) {
    farkas = bare_test_.proof();
  } else {
    farkas = path_end_.head(contacts_.input.nc);
  }
  answer.farkas.swap(farkas);
}

bool AnswerTest::solves(const Vector& z) {
  if (!z.allFinite()) return false;
  completed_ = z.cwiseMax(0.0);
  if (by_bodies_) return solves_bodies();
  if (!bare_) return solves_contacts();
  return solves_bare();
}

bool AnswerTest::solves_bare() {
  if (bare_test_.backward_error(completed_) <= kClaimedBackwardError) return true;
  return bare_test_.drop_rounding(completed_) && bare_test_.backward_error(completed_) <= kClaimedBackwardError;
}

bool AnswerTest::solves_bodies() {
  bodies_test_.release(completed_);
  if (bodies_test_.complete_in_double(completed_).certain <= kClaimedResidual) return true;
  return bodies_test_.complete_in_quad(completed_).certain <= kClaimedQuadResidual;
}

/// What nothing moves stays so: methods that end inside leave impulses there.
void AnswerTest::release_islands_at_rest() {
  const contact_lemke::Input& input = contacts_.input;
  if (input.island_of_contact == nullptr) return;
  for (std::ptrdiff_t c = 0; c < input.nc; ++c) {
    const std::ptrdiff_t island = input.island_of_contact[c];
    bool moves = false;
    for (std::ptrdiff_t i = 0; i < input.ngc && island >= 0 && completed_(c) > 0; ++i) {
      moves = moves || (input.island_of_coordinate[i] == island && input.v[i] != 0);
    }
    if (!moves) completed_(c) = 0;
  }
}

bool AnswerTest::solves_contacts() {
  release_islands_at_rest();
  release_friction(contacts_.input, completed_);
  contact_lemke::Residual residual = judge_.complete(completed_.data());
  residual_ = residual.velocity;
  if (residual.certain <= kClaimedResidual) return true;
  residual = quad_judge().complete(completed_.data());
  residual_ = residual.velocity;
  return residual.certain <= kClaimedQuadResidual;
}

/// Whether the problem that completed_ seems to solve has a solution.
AnswerTest::Outcome AnswerTest::confirm(double deadline_s) {
  if (bare_) return bare_test_.disproves(completed_, deadline_s) ? Outcome::kUnsolvable : Outcome::kSolved;
  if (!may_be_singular_ || residual_ <= kUndoubtedResidual) return Outcome::kSolved;
  const bool frictional = contacts_.friction_begin.back() > 0;
  Outcome outcome = confirm({.deadline_s = deadline_s}, frictional);
  if (outcome == Outcome::kUnconfirmed) outcome = confirm({.quad = true, .deadline_s = deadline_s}, frictional);
  if (outcome == Outcome::kUnconfirmed && frictional) {
    outcome = confirm({.quad = true, .classic = true, .deadline_s = deadline_s}, true);
  }
  return outcome;
}

/// What one path shows. A ray of the problem without friction proves that nothing solves the problem with it; path_end_
/// is then that proof.
AnswerTest::Outcome AnswerTest::confirm(const Path& path, bool frictional) {
  LoadedContacts& engine = path.quad ? quad_judge() : judge_;
  Ending ending = follow(path, engine, false);
  if (ending == Ending::kSolved) {
    // In 113 bits the path's own word is enough: its answer was rounded to doubles.
    const bool confirms = path.quad || engine.complete(path_end_.data()).velocity <= kUndoubtedResidual;
    return confirms ? Outcome::kSolved : Outcome::kUnconfirmed;
  }
  if (ending == Ending::kRay && frictional) ending = follow(path, engine, true);
  if (ending == Ending::kTimeLimit) return Outcome::kOutOfTime;
  const bool disproved = ending == Ending::kRay && judge_.disproves(path_end_.data());
  return disproved ? Outcome::kUnsolvable : Outcome::kUnconfirmed;
}

/// Whether a ray of the problem without friction proves that nothing solves the problem; path_end_ is then that proof.
bool AnswerTest::disproves_contacts(const Path& path) {
  LoadedContacts& engine = path.quad ? quad_judge() : judge_;
  return follow(path, engine, true) == Ending::kRay && judge_.disproves(path_end_.data());
}

Ending AnswerTest::follow(const Path& path, LoadedContacts& engine, bool frictionless) {
  const ContactLemkeSettings settings;
  const double roundoff = path.quad ? kQuadUnitRoundoff : kDoubleUnitRoundoff;
  const std::ptrdiff_t rows = contacts_.input.nc + contacts_.input.ngc;
  contact_lemke::Rules rules;
  rules.classic = path.classic && !frictionless;
  rules.frictionless = frictionless;
  rules.refinements = static_cast<std::ptrdiff_t>(settings.max_refinements);
  rules.pivot_tolerance = roundoff * settings.pivot_tolerance;
  rules.tie_tolerance = roundoff * settings.tie_tolerance;
  rules.residual_tolerance = roundoff * settings.refine_tolerance;
  rules.max_pivots = 100 + 20 * (path.classic ? rows + contacts_.friction_begin.back() : rows);
  rules.deadline_s = path.deadline_s;
  rules.clock_s = wall_clock_s;
  path_end_.setZero();
  return engine.solve(rules, path_end_.data()).ending;
}

LoadedContacts& AnswerTest::quad_judge() {
  if (!quad_is_loaded_) quad_judge_.load(contacts_.input);
  quad_is_loaded_ = true;
  return quad_judge_;
}

void release_friction(const contact_lemke::Input& contacts, Vector& z) {
  for (std::ptrdiff_t contact = 0; contact < contacts.nc; ++contact) {
    if (z(contact) > 0) continue;
    z.segment(contacts.nc + contacts.friction_begin[contact],
              contacts.friction_begin[contact + 1] - contacts.friction_begin[contact])
        .setZero();
  }
}

}  // namespace lcpbench
