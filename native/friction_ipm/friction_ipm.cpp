#include "native/friction_ipm/friction_ipm.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "core/compliance.h"
#include "core/registry.h"
#include "native/answer_test/impulse_solver.h"
#include "native/velocity_ipm/interior_point.h"
#include "native/velocity_ipm/multifrontal.h"

namespace lcpbench {
namespace {

struct FrictionIpmSettings {
  double tolerance = 1e-9;
  std::int64_t max_iterations = 10000;

  void visit(auto&& field) {
    visit_tolerance(field, tolerance);
    field("max_iterations", max_iterations, IntegerRange{.min = 0},
          "predictor-corrector steps, over all convex problems");
  }
};

/// So many factorizations without the residual falling to a half: the fixed point is not being reached.
constexpr std::int64_t kMostIdleSteps = 1500;
constexpr double kProgress = 0.5;
/// No convex problem is solved to less than this part of the tolerance. If they were solved to the tolerance itself,
/// their errors would keep the rounds around it, and rounding would decide which round is the last.
constexpr double kConvexShare = 0.25;
/// The residual to which the first convex problem is solved. From there InteriorPoint::finish() mostly brings it to
/// rounding, so that the rounds end if it is the answer.
constexpr double kFirstConvex = 2.5e-5;
/// With a smaller tolerance, all are solved to it.
constexpr double kToRounding = 1e-10;
/// Each later one is solved to this part of the least residual so far, and at least as far as the first.
constexpr double kNextConvex = 0.1;
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

/// N cone.normal + D cone.friction, each column of which is that of a contact and of at most one of its directions.
/// @param D  used only where there is friction
SparseMatrix sparse_columns(const SparseMatrix& N, const SparseMatrix* D, const ConeColumns& cone) {
  using Entries = SparseMatrix::InnerIterator;
  SparseMatrix columns(N.rows(), cone.size());
  for (Index c = 0; c < cone.size(); ++c) {
    columns.startVec(c);
    const auto place = [&](Index row) -> double& { return columns.insertBack(row, c); };
    Entries normal(N, Entries(cone.normal, c).row());
    if (const Entries direction(cone.friction, c); direction) {
      for (Entries friction(*D, direction.row()); friction; ++friction) {
        for (; normal && normal.row() < friction.row(); ++normal) place(normal.row()) = normal.value();
        double& entry = place(friction.row());
        entry = friction.value() * direction.value();
        if (!normal || normal.row() != friction.row()) continue;
        entry += normal.value();
        ++normal;
      }
    }
    for (; normal; ++normal) place(normal.row()) = normal.value();
  }
  columns.finalize();
  return columns;
}

/// The contact problem that has these columns for its normals and no friction, and no offset: each round has its own.
ContactProblem convex_problem(const ContactProblem& contact, const ConeColumns& cone) {
  ContactProblem convex;
  convex.v = contact.v;
  convex.inertia = contact.inertia;
  convex.edges.assign(static_cast<std::size_t>(cone.size()), 0);
  convex.mu = Vector::Zero(cone.size());
  convex.D = Matrix(contact.ngc(), 0);
  if (!contact.frictional()) convex.compliance_n = contact.compliance_n;
  const auto* N = std::get_if<SparseMatrix>(&contact.N);
  const auto* D = std::get_if<SparseMatrix>(&contact.D);
  if (N != nullptr && (D != nullptr || !contact.frictional())) {
    convex.N = sparse_columns(*N, D, cone);
  } else {
    convex.N = Matrix(to_dense(contact.N) * cone.normal + to_dense(contact.D) * cone.friction);
  }
  return convex;
}

/// Steps of the interior point after which its velocity may show that there is no rest.
constexpr std::int64_t kStepsToRefute = 3;

/// R of the multipliers of a soft problem with friction: those of a contact give way along its normal and its tangents.
CoupledCompliance coupled_compliance(const ContactProblem& contact) {
  CoupledCompliance coupled;
  if (!contact.is_soft() || !contact.frictional()) return coupled;
  for (Index i = 0; i < contact.nc(); ++i) {
    const double mu = contact.mu(i);
    const Index directions = mu > 0 ? contact.edges[static_cast<std::size_t>(i)] : 0;
    Matrix R =
        Matrix::Constant(std::max<Index>(directions, 1), std::max<Index>(directions, 1), contact.normal_compliance(i));
    if (directions > 0) {
      Eigen::Matrix2Xd C(2, directions);
      for (Index k = 0; k < directions; ++k) {
        const std::array<double, 2> direction = edge_direction(k, directions);
        C.col(k) << direction[0], direction[1];
      }
      R += mu * mu * contact.tangential_compliance(i) * C.transpose() * C;
    }
    coupled.add_block(R);
  }
  return coupled;
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
/// Compliance enters w of each constraint as that of its contact's normal and tangents does.
/// Block inertia with sparse N and D: sparse Cholesky, whose cost follows the graph of bodies. That the rounds converge
/// is not proven; without friction the first one is the answer. [Cadoux 2009; Acary, Cadoux, Lemarechal, Malick 2011,
/// ZAMM 91; Anitescu 2006]
///
/// kSolved: the velocity residual, recomputed from z in double, is at most 1e-4 or the tolerance, and AnswerTest passes;
/// kNumericalFailure: the rounds did not get there. `detail` has their number. Opposite friction impulses of a contact
/// are returned as their difference.
class FrictionIpm final : public BestImpulseSolver<FrictionIpmSolver> {
 public:
  explicit FrictionIpm(const FrictionIpmSettings& settings)
      : settings_(settings),
        method_({.tolerance = kConvexShare * settings.tolerance}) {}
  const Capabilities& capabilities() const override;
  double work() const override { return method_.work() - now_.work_before + best_.work; }
  bool solve_convex(const Budget& budget, const std::function<bool(const Vector& z)>& is_refuted,
                    Answer& answer) override;

 private:
  /// Of one solve.
  struct Progress {
    int rounds = 1;                 ///< with the one that runs
    double residual = kInfinity;    ///< of the last round
    std::int64_t steps_then = 0;    ///< factorizations and rounds until the residual last fell to a half
    bool goes_on = false;           ///< the next round from a point of the last one
    double work_before = 0;         ///< of the interior point; Best::work is without its work
  };

  void on_load(const Problem& problem) override;
  void begin(const Vector* start, double error) override;
  bool run(double work, double deadline_s) override;
  bool can_improve() const override { return has_friction(); }
  void describe(std::string& detail) const override;

  void begin_round(double residual);
  bool end_round();
  bool note();
  double take_impulses();
  bool is_certain() const;
  void find_offsets(bool at_rest);
  bool has_friction() const { return cone_.friction.nonZeros() > 0; }

  FrictionIpmSettings settings_;
  InteriorPoint method_;
  ConeColumns cone_;
  Vector friction_impulses_;  // f_D
  Vector slip_bounds_;        // nc, mu lambda + b
  Vector offset_;             // per cone column
  Vector tangential_offsets_;              // sum(edges), tangential offsets along each direction
  Progress now_;
};

void FrictionIpm::on_load(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  result_.reserve(problem);
  cone_ = cone_columns(contact);
  const ContactProblem convex = convex_problem(contact, cone_);
  const bool sparse = suits_sparse_algebra(convex);
  CoupledCompliance coupled = coupled_compliance(contact);
  std::unique_ptr<WhitenedNormals> normals =
      sparse ? sparse_whitened_normals(convex, multifrontal_cholesky(), coupled) : dense_whitened_normals(convex);
  method_.load(std::move(normals), convex, std::move(coupled));
  refusal_ = method_.loaded() ? "" : "needs an inertia of positive definite blocks";
  if (!refusal_.empty()) return;
  if (has_friction()) method_.keep_points();
  state_.load(problem);
  load_test(problem);
  friction_impulses_.resize(cone_.friction.rows());
  slip_bounds_.resize(state_.contacts);
  offset_.resize(cone_.size());
  tangential_offsets_.setZero(cone_.friction.rows());
  best_impulse_.resize(state_.impulse.size());
}

/// The multipliers of the cone columns as normal and signed friction impulses, and the velocity that they give.
/// @returns the residual, relative to the scale
double FrictionIpm::take_impulses() {
  friction_impulses_.noalias() = cone_.friction * method_.impulses();
  state_.impulse.head(state_.contacts).noalias() = cone_.normal * method_.impulses();
  for (const SignedFriction& friction : state_.frictions) {
    const Index first = friction.first_column - state_.contacts;
    state_.impulse.segment(friction.first_column, friction.directions) =
        friction_impulses_.segment(first, friction.directions) -
        friction_impulses_.segment(first + friction.directions, friction.directions);
  }
  state_.recompute_velocity();
  best_.work += state_.work_of_residual();
  return state_.residual() / state_.scale;
}

/// Whether the rounding of the impulses, which may grow without bound, is within what is accepted.
bool FrictionIpm::is_certain() const {
  const double largest = state_.columns.diagonal.cwiseProduct(state_.impulse.cwiseAbs()).maxCoeff();
  return std::numeric_limits<double>::epsilon() * largest <= best_.accept_residual * state_.scale;
}

/// b + mu (lambda + c'offset_t) of each cone column into offset_, at the velocity reached; `at_rest`: with lambda = 0.
void FrictionIpm::find_offsets(bool at_rest) {
  slip_bounds_.setZero();
  for (const SignedFriction& friction : state_.frictions) {
    if (!at_rest) slip_bounds_(friction.contact) = state_.mu(friction.contact) * state_.slip_bound(friction);
  }
  if (state_.offset.size() > 0) slip_bounds_ += state_.offset;
  offset_.noalias() = cone_.normal.transpose() * slip_bounds_;
  if (state_.offset_t.size() == 0) return;
  for (const SignedFriction& friction : state_.frictions) {
    const Index first = friction.first_column - state_.contacts;
    for (Index t = 0; t < friction.directions; ++t) {
      const double offset =
          state_.tangents.col(friction.first_column + t).dot(state_.offset_t.segment<2>(2 * friction.contact));
      tangential_offsets_(first + t) = offset;
      tangential_offsets_(first + friction.directions + t) = -offset;
    }
  }
  offset_.noalias() += cone_.friction.transpose() * tangential_offsets_;
}

void FrictionIpm::begin(const Vector* /*start*/, double error) {
  begin_result({.iterations = 0, .pivots = 0, .factorizations = 0});
  now_ = {.work_before = method_.work()};
  best_ = {.tolerance = error > 0 ? error : settings_.tolerance,
           .accept_residual = error > 0 ? error : std::max(settings_.tolerance, kAcceptedResidual)};
  if (!refusal_.empty()) return;
  test_.allow(error);
  best_impulse_.setZero();
  find_offsets(true);
  begin_round(kInfinity);
}

/// The next convex problem, with the bounds in offset_. @param residual the least so far, or of the start
void FrictionIpm::begin_round(double residual) {
  method_.set_velocity(state_.u0, offset_, state_.scale, state_.speed);
  const double size = std::max(1.0, method_.size_over_scale());
  const double least = kConvexShare * best_.tolerance * size;
  const double next = kNextConvex * residual;
  const double most = best_.tolerance < kToRounding ? least : std::max(least, kFirstConvex * size);
  method_.aim_at(has_friction() ? std::clamp(next, least, most) : least);
  if (now_.goes_on) {
    method_.begin_near(now_.residual);
  } else {
    method_.begin();
  }
}

/// Keeps the impulses that the interior point has reached, if they are the best so far. @returns whether they are
bool FrictionIpm::note() {
  now_.residual = take_impulses();
  if (!(now_.residual < best_.residual && is_certain())) return false;
  best_.residual = now_.residual;
  best_impulse_ = state_.impulse;
  return true;
}

/// @returns whether it was the last one
bool FrictionIpm::end_round() {
  method_.finish(result_.counters);
  const std::int64_t steps = result_.counters.factorizations + now_.rounds;
  const double least = best_.residual;
  if (note() && now_.residual < kProgress * least) now_.steps_then = steps;
  const bool is_idle = steps - now_.steps_then > kMostIdleSteps;
  if (best_.residual <= best_.tolerance || is_idle || !(now_.residual < kInfinity)) return true;
  return !has_friction();  // the next problem would be the same
}

bool FrictionIpm::run(double work, double deadline_s) {
  using Stop = InteriorPoint::Stop;
  const double until = this->work() + work;
  for (;;) {
    const double left = until - this->work();
    const Stop stop = method_.iterate(left, deadline_s, settings_.max_iterations, result_.counters);
    if (stop == Stop::kWorkLimit) break;
    Claim claim = Claim::kNumericalFailure;
    if (stop == Stop::kTimeLimit) claim = Claim::kTimeLimit;
    if (stop == Stop::kIterationLimit) claim = Claim::kIterationLimit;
    now_.goes_on = stop != Stop::kBreakdown;
    if ((claim != Claim::kNumericalFailure || end_round()) && end(claim, deadline_s)) return true;
    ++now_.rounds;
    find_offsets(false);
    begin_round(best_.residual);
    if (this->work() >= until) break;
  }
  note();
  report_best(Claim::kIterationLimit);
  return false;
}

bool FrictionIpm::solve_convex(const Budget& budget, const std::function<bool(const Vector& z)>& is_refuted,
                               Answer& answer) {
  using Stop = InteriorPoint::Stop;
  begin(nullptr, budget.error);
  answer.reserve(problem());
  if (!refusal_.empty() || !(state_.scale > 0)) {
    solve_within(budget, answer);
    return true;
  }
  Stop stop = method_.iterate(kInfinity, budget.deadline_s, kStepsToRefute, result_.counters);
  if (stop == Stop::kIterationLimit) {
    note();
    report_best(Claim::kIterationLimit);
    if (is_refuted(result_.z)) return false;
    stop = method_.iterate(kInfinity, budget.deadline_s, settings_.max_iterations, result_.counters);
  }
  const bool is_in_time = stop != Stop::kTimeLimit;
  const bool has_ended = is_in_time && end_round() && end(Claim::kNumericalFailure, budget.deadline_s);
  if (!has_ended) report_best(is_in_time ? Claim::kIterationLimit : Claim::kTimeLimit);
  answer = result_;
  return true;
}

void FrictionIpm::describe(std::string& detail) const {
  std::array<char, 40> text{};
  const char* const plural = now_.rounds == 1 ? "" : "s";
  const int length = std::snprintf(text.data(), text.size(), "%d convex problem%s", now_.rounds, plural);
  detail.assign(text.data(), static_cast<std::size_t>(length));
}

constexpr Capabilities kCapabilities{
    .needs = Needs::kFactored,
    .compliance = true,
    .guarantees = "without friction as velocity_ipm; with friction none, the rounds may not converge",
    .obeys_time_limit = true,
    .allocation_free = true};

const Capabilities& FrictionIpm::capabilities() const { return kCapabilities; }

}  // namespace

std::unique_ptr<FrictionIpmSolver> make_friction_ipm() { return std::make_unique<FrictionIpm>(FrictionIpmSettings{}); }

SolverDefinition lcpbench_solver_friction_ipm() {
  return define_solver<FrictionIpm, FrictionIpmSettings>(
      {.name = "friction_ipm",
       .summary = "friction as a fixed point of convex problems, each by the interior point in velocity space; sparse",
       .source =
           "Acary, Cadoux, Lemarechal, Malick 2011, A formulation of the linear discrete Coulomb friction problem",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
