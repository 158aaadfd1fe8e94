#include "native/friction_ipm/friction_ipm.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/contacts/contact_impulses.h"
#include "native/velocity_ipm/interior_point.h"
#include "native/velocity_ipm/multifrontal_cholesky.h"

namespace lcpbench {
namespace {

struct FrictionIpmSettings {
  Algebra algebra = Algebra::kAuto;
  double tolerance = 1e-9;
  double accept_residual = 1e-4;
  double shift = 1e-12;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    visit_algebra(field, algebra);
    field("tolerance", tolerance, RealRange{.min = 0},
          "stop when the velocity residual of every island is at most this times max|q| of the island");
    field("accept_residual", accept_residual, RealRange{.min = 0},
          "claim solved only when the velocity residual of every island, evaluated in double, is at most this times "
          "max|q| of the island");
    field("shift", shift, RealRange{.min = 0, .max = 1}, "of the convex problems: see velocity_ipm");
    field("max_iterations", max_iterations, IntegerRange{.min = 0},
          "predictor-corrector steps, over all convex problems");
  }
};

/// So many convex problems without the residual falling to a half: the fixed point is not being reached.
constexpr int kMostIdleRounds = 60;
constexpr double kProgress = 0.5;
/// Of the tolerance, to which the convex problems are solved at last: at the tolerance itself their errors keep the
/// rounds around it, and rounding decides when one is below.
constexpr double kConvexShare = 0.25;
/// To which the first convex problem is solved, and of the residual of a round, to which the next one is. The steps
/// that follow the interior point mostly bring it to rounding from there.
constexpr double kFirstConvex = 2.5e-5;
constexpr double kNextConvex = 1e-2;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The columns a_id = N_i + mu_i d of every contact i and direction d, one column N_i where there is no friction, as
/// [N D] times two sparse matrices. With the multipliers g of the columns, f_N = normal g and f_D = friction g.
struct ConeColumns {
  SparseMatrix normal;    ///< nc x columns, entries 1
  SparseMatrix friction;  ///< sum(edges) x columns, entries mu

  Index size() const { return normal.cols(); }
};

ConeColumns cone_columns(const ContactProblem& contact) {
  const ContactLayout layout = contact_layout(contact);
  std::vector<Eigen::Triplet<double>> normal;
  std::vector<Eigen::Triplet<double>> friction;
  for (std::size_t i = 0; i < contact.edges.size(); ++i) {
    const double mu = contact.mu(static_cast<Index>(i));
    const int directions = mu > 0 ? contact.edges[i] : 0;
    const auto first = static_cast<int>(normal.size());
    for (int column = first; column < first + std::max(directions, 1); ++column) {
      normal.emplace_back(static_cast<int>(i), column, 1.0);
      if (directions == 0) continue;
      friction.emplace_back(static_cast<int>(layout.friction_begin[i]) + column - first, column, mu);
    }
  }
  const auto columns = static_cast<Index>(normal.size());
  ConeColumns cone{SparseMatrix(layout.nc, columns), SparseMatrix(layout.friction, columns)};
  cone.normal.setFromTriplets(normal.begin(), normal.end());
  cone.friction.setFromTriplets(friction.begin(), friction.end());
  return cone;
}

/// The contact problem that has these columns for its normals and no friction, and no offset: each round has its own.
ContactProblem convex_problem(const ContactProblem& contact, const ConeColumns& cone) {
  ContactProblem convex;
  convex.v = contact.v;
  convex.inertia = contact.inertia;
  convex.edges.assign(static_cast<std::size_t>(cone.size()), 0);
  convex.mu = Vector::Zero(cone.size());
  convex.D = Matrix(contact.ngc(), 0);
  const auto* N = std::get_if<SparseMatrix>(&contact.N);
  const auto* D = std::get_if<SparseMatrix>(&contact.D);
  if (N != nullptr && (D != nullptr || !contact.frictional())) {
    SparseMatrix columns = *N * cone.normal;
    if (D != nullptr) columns += *D * cone.friction;
    convex.N = columns;
  } else {
    convex.N = Matrix(to_dense(contact.N) * cone.normal + to_dense(contact.D) * cone.friction);
  }
  return convex;
}

/// Solves contact problems with friction, also large sparse ones, as the fixed point of convex problems.
///
/// For slip bounds lambda that are held, the Anitescu-Potra problem becomes a projection in the inertia metric,
///
///     minimize 1/2 (u - v)'G (u - v) subject to (N_i + mu_i d)'u + b_i + mu_i lambda_i >= 0,
///
/// one constraint for each direction d of each contact i, whose multipliers g give f_N = sum g_d and f_D = mu g. Where
/// lambda_i = max -d'u of its own solution, that solution solves the whole problem, and conversely. From lambda = 0
/// (the convex relaxation) each round solves one such problem by InteriorPoint and takes lambda from its velocity.
/// Block inertia with sparse N and D: sparse Cholesky, whose cost follows the graph of bodies. That the rounds converge
/// is not proven; without friction the first one is the answer. [Cadoux 2009; Acary, Cadoux, Lemarechal, Malick 2011,
/// ZAMM 91; Anitescu 2006]
///
/// kSolved: the velocity residual, recomputed from z in double, is within accept_residual and AnswerTest passes;
/// kNumericalFailure: the rounds did not get there. `detail` has their number. Opposite friction impulses of a contact
/// are returned as their difference.
class FrictionIpm final : public LimitedFrictionIpm {
 public:
  explicit FrictionIpm(const FrictionIpmSettings& settings)
      : settings_(settings),
        tolerance_(settings.tolerance),
        accept_residual_(settings.accept_residual),
        method_({.tolerance = kConvexShare * settings.tolerance, .shift = settings.shift}) {}
  const Capabilities& capabilities() const override;
  void limit_rounds(std::int64_t rounds, double accept_residual) override {
    max_rounds_ = rounds;
    accept_residual_ = accept_residual;
  }
  void aim_at(double residual) override {
    tolerance_ = accept_residual_ = residual;
    test_.allow(residual);
  }
  void unlimit_rounds() override {
    limit_rounds(kNoLimit, settings_.accept_residual);
    tolerance_ = settings_.tolerance;
    test_.allow(0);
  }

 private:
  static constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();

  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  Claim run(double deadline_s, Answer& answer, int& rounds);
  void take_impulses();
  void report(Claim claim, int rounds, Answer& answer);
  void find_offsets(bool at_rest);

  FrictionIpmSettings settings_;
  std::int64_t max_rounds_ = kNoLimit;
  double tolerance_ = 0;
  double accept_residual_ = 0;
  InteriorPoint method_;
  ContactImpulses state_;
  ConeColumns cone_;
  AnswerTest test_;
  Vector friction_impulses_;  // f_D
  Vector slip_bounds_;        // nc, mu lambda + b
  Vector offset_;             // per cone column
  Vector best_impulse_;
};

void FrictionIpm::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  cone_ = cone_columns(contact);
  const ContactProblem convex = convex_problem(contact, cone_);
  const bool sparse = wants_sparse(settings_.algebra, convex);
  method_.load(sparse ? sparse_whitened_normals(convex, multifrontal_cholesky()) : dense_whitened_normals(convex),
               convex);
  if (!method_.loaded()) return;
  state_.load(problem);
  test_.load(problem, AnswerTest::Bodies::kOneByOne);
  friction_impulses_.resize(cone_.friction.rows());
  slip_bounds_.resize(state_.contacts);
  offset_.resize(cone_.size());
  best_impulse_.resize(state_.impulse.size());
}

void FrictionIpm::on_update(const Vector& v) {
  if (!method_.loaded() || !v.allFinite()) return Solver::on_update(v);
  state_.set_velocity(v);
  test_.set_velocity(v);
}

/// The multipliers of the cone columns as normal and signed friction impulses, and the velocity that they give.
void FrictionIpm::take_impulses() {
  friction_impulses_.noalias() = cone_.friction * method_.impulses();
  state_.impulse.head(state_.contacts).noalias() = cone_.normal * method_.impulses();
  for (const SignedFriction& friction : state_.frictions) {
    const Index first = friction.first_column - state_.contacts;
    state_.impulse.segment(friction.first_column, friction.directions) =
        friction_impulses_.segment(first, friction.directions) -
        friction_impulses_.segment(first + friction.directions, friction.directions);
  }
  state_.recompute_velocity();
}

/// b + mu lambda of each cone column into offset_, at the velocity reached; `at_rest`: with lambda = 0.
void FrictionIpm::find_offsets(bool at_rest) {
  slip_bounds_.setZero();
  for (const SignedFriction& friction : state_.frictions) {
    if (!at_rest) slip_bounds_(friction.contact) = state_.mu(friction.contact) * state_.slip_bound(friction);
  }
  if (state_.offset.size() > 0) slip_bounds_ += state_.offset;
  offset_.noalias() = cone_.normal.transpose() * slip_bounds_;
}

/// Leaves the impulses of the smallest residual in state_.
Claim FrictionIpm::run(double deadline_s, Answer& answer, int& rounds) {
  using Stop = InteriorPoint::Stop;
  Claim claim = Claim::kNumericalFailure;
  best_impulse_ = state_.impulse;
  double best = kInfinity;
  int idle_rounds = 0;
  find_offsets(true);
  const double least = kConvexShare * tolerance_;
  method_.aim_at(cone_.friction.nonZeros() == 0 ? least : std::max(least, kFirstConvex));
  for (rounds = 1;; ++rounds) {
    method_.set_velocity(state_.u0, offset_);
    const Stop stop = method_.iterate(deadline_s, settings_.max_iterations, answer.counters);
    if (stop == Stop::kTimeLimit) claim = Claim::kTimeLimit;
    if (stop == Stop::kIterationLimit) claim = Claim::kIterationLimit;
    if (claim != Claim::kNumericalFailure) break;
    method_.finish(answer.counters);
    take_impulses();
    const double residual = state_.residual() / state_.q_max;
    idle_rounds = residual < kProgress * best ? 0 : idle_rounds + 1;
    if (residual < best) {
      best = residual;
      best_impulse_ = state_.impulse;
    }
    if (best <= tolerance_ || idle_rounds > kMostIdleRounds || !(residual < kInfinity)) break;
    if (cone_.friction.nonZeros() == 0) break;  // the next problem would be the same
    if (rounds >= max_rounds_) {
      claim = Claim::kIterationLimit;
      break;
    }
    method_.aim_at(std::clamp(kNextConvex * best, least, std::max(least, kFirstConvex)));
    find_offsets(false);
  }
  state_.impulse = best_impulse_;
  state_.recompute_velocity();
  return best <= accept_residual_ ? Claim::kSolved : claim;
}

void FrictionIpm::report(Claim claim, int rounds, Answer& answer) {
  answer.claim = claim;
  state_.write_answer(answer.z);
  answer.velocity = state_.u;
  state_.units.restore(answer.velocity);
  std::array<char, 40> text{};
  const int length = std::snprintf(text.data(), text.size(), "%d convex problem%s", rounds, rounds == 1 ? "" : "s");
  answer.detail.assign(text.data(), static_cast<std::size_t>(length));
}

void FrictionIpm::on_solve(const SolveRequest& request, Answer& answer) {
  answer.counters = {.iterations = 0, .pivots = 0, .factorizations = 0};
  if (!method_.loaded()) {
    answer.claim = Claim::kUnsupported;
    answer.detail = "algebra=sparse needs an inertia of positive definite blocks";
    return;
  }
  if (state_.q_max == 0) {  // z = 0 solves it, and max|q| gives no scale to judge another answer by
    answer.claim = Claim::kSolved;
    answer.velocity = state_.u0;
    test_.settle(answer, wall_clock_s() + request.time_limit_s);  // q may have been rounded to zero
    return;
  }
  int rounds = 0;
  state_.impulse.setZero();
  state_.u = state_.u0;
  const double deadline_s = wall_clock_s() + request.time_limit_s;
  const Claim claim = run(deadline_s, answer, rounds);
  report(claim, rounds, answer);
  if (claim != Claim::kSolved || test_.settle(answer, deadline_s)) return;
  if (answer.claim != Claim::kNumericalFailure) return;
  state_.drop_what_counts_as_zero();
  report(claim, rounds, answer);
  test_.settle(answer, deadline_s);
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .guarantees = "without friction as velocity_ipm; with friction none, the rounds may not converge",
    .obeys_time_limit = true,
    .allocation_free = true};

const Capabilities& FrictionIpm::capabilities() const { return kCapabilities; }

}  // namespace

std::unique_ptr<LimitedFrictionIpm> make_friction_ipm() { return std::make_unique<FrictionIpm>(FrictionIpmSettings{}); }

SolverDefinition lcpbench_solver_friction_ipm() {
  return define_solver<FrictionIpm, FrictionIpmSettings>(
      {.name = "friction_ipm",
       .summary = "friction as a fixed point of convex problems, each by the interior point in velocity space; sparse",
       .source =
           "Acary, Cadoux, Lemarechal, Malick 2011, A formulation of the linear discrete Coulomb friction problem",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
