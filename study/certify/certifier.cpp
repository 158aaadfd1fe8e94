#include <algorithm>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include <flint/flint.h>

#include "core/error.h"
#include "study/certify/basis.h"
#include "study/certify/branching.h"
#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/contact_variants.h"
#include "study/certify/deadline.h"
#include "study/certify/exact_checks.h"
#include "study/certify/exact_lemke.h"
#include "study/certify/exact_problem.h"
#include "study/certify/reduction.h"

namespace lcpbench {
namespace exact {
namespace {

/// Of the exact search near an answer whose basis was no solution: entries below this part of the terms of their rows
/// are unclear, and there may be so many of them.
constexpr double kClear = 1e-9;
constexpr std::size_t kMostUnclear = 64;

/// Rounds of exact exchanges after a float basis that was no solution.
constexpr int kExchanges = 8;
/// Largest orders for exact Lemke: on monotone problems, which it settles, on bare LCPs, and on other contacts.
constexpr Index kLargestMonotoneLemke = 128;
constexpr Index kLargestBareLemke = 60;
constexpr Index kLargestContactLemke = 40;
/// Largest order for floats of 113 bits on a dense M.
constexpr Index kLargestQuad = 60;
/// How many variants of a problem are tried in search of another velocity.
constexpr Index kVelocityVariants = 8;
/// Most combinations of contact modes to try one by one.
constexpr std::size_t kModes = 2500;

constexpr const char* kLemke = "lemke{test=none}";
constexpr const char* kInQuad = "contact_lemke{precision=quad}";

/// A point of `system` near the float solution z that `accepts` takes.
/// @param more_rows  gives rows of w that may be zero; asked only where the support of z leaves more than one point
/// @param settled  gives a point, or none, in another way; asked when the support of z gave none
template <class Rows, class Settled, class Accepts>
std::optional<ExactPoint> certified_near(const ExactSystem& system, const Vector& z, const Deadline& deadline,
                                         Rows&& more_rows, Settled&& settled, Accepts&& accepts) {
  std::vector<Index> basis = support(z, system.size());
  for (int round = 0; round <= kExchanges; ++round) {
    std::optional<ExactPoint> point = basis_point(system, basis, deadline);
    if (!point) point = purified_point(system, basis, round == 0 ? more_rows() : std::vector<Index>{}, deadline);
    if (!point) return std::nullopt;
    if (accepts(*point)) return point;
    if (round == 0) {
      if (std::optional<ExactPoint> other = settled()) return other;
    }
    std::vector<Index> next = exchanged_basis(system, *point, deadline);
    if (next == basis) return std::nullopt;
    basis = std::move(next);
  }
  return std::nullopt;
}

/// min |L u|^2 + (1 + q'u)^2 over u >= 0, as a frictionless contact problem of inertia 1.
Problem contradiction_problem(const ContactProblem& contact) {
  const Matrix N = to_dense(contact.N);
  Matrix B = N;
  if (const auto* factors = std::get_if<FactoredInertia>(&contact.inertia)) B = factors->X.transpose() * N;
  if (const auto* inverse = std::get_if<InverseInertia>(&contact.inertia)) B = inverse->Ginv * N;
  Vector q = N.transpose() * contact.v;
  if (contact.has_offset()) q += contact.b;
  if (contact.compliance_n.size() > 0) {  // u is zero where a contact yields
    B.conservativeResize(B.rows() + N.cols(), Eigen::NoChange);
    B.bottomRows(N.cols()) = contact.compliance_n.asDiagonal();
  }
  const auto unit = [](const Matrix& a) {
    const double largest = a.size() > 0 ? a.cwiseAbs().maxCoeff() : 0.0;
    return largest > 0 ? largest : 1.0;
  };
  ContactProblem squares;
  squares.N = Matrix(B.rows() + 1, N.cols());
  std::get<Matrix>(squares.N) << B / unit(B), q.transpose() / unit(q);
  squares.v = Vector::Unit(B.rows() + 1, B.rows());
  squares.D = Matrix(B.rows() + 1, 0);
  squares.edges.assign(index(N.cols()), 0);
  squares.mu = Vector::Zero(N.cols());
  squares.inertia = DenseInertia{Matrix::Identity(B.rows() + 1, B.rows() + 1)};
  return {"contradiction", std::move(squares)};
}

/// Certifies a problem of finite data.
///
/// A bare LCP: bases from `lemke` and `auto`, exact Lemke up to an order that it can be afforded for, branch
/// and bound until the deadline.
///
/// Contacts without friction, and M proven semidefinite: complete. A basis from `active_set`, corrected by exact
/// exchanges if it is wrong; a contradiction from the nonnegative least squares problem min |L u|^2 + (1 + q'u)^2,
/// which has the residual 0 exactly when the problem is unsolvable; last, exact Lemke on M with its potentials
/// eliminated.
///
/// Contacts with friction: bases from `contact_lemke` and `lemke`; the contradiction of the normals alone; the velocity
/// inside the dual friction cones, the solution of a frictionless problem whose contacts are the cones' edges; for few
/// unknowns exact Lemke; branch and bound until the deadline.
class TruthSearch {
 public:
  /// @throws TimePassed, as run() does
  TruthSearch(const Problem& problem, const CertifyOptions& options, const Deadline& deadline, Candidates& candidates)
      : problem_(problem),
        contact_(problem.contact()),
        options_(options),
        deadline_(deadline),
        candidates_(candidates),
        truth_(problem, deadline) {}

  Certificate run() {
    if (!truth_.inertia().refusal.empty()) return open(truth_.inertia().refusal);
    const bool decided = contact_ == nullptr ? decide_bare()
                         : truth_.monotone() ? decide_monotone()
                                             : decide_frictional();
    if (!decided) return open(deadline_.passed() ? "the time limit passed" : "no proof was found either way");
    // Without a positive mu no friction acts, and M of the normals is semidefinite.
    const bool one_velocity = solution_ && truth_.inertia().semidefinite && contact_->mu.isZero(0);
    if (one_velocity) certificate_.velocity_unique = true;
    if (options_.seek_other_velocity && solution_ && truth_.frictional() && !one_velocity) {
      try {
        seek_other_velocity();
      } catch (const TimePassed&) {  // what was found stays
      }
    }
    return std::move(certificate_);
  }

 private:
  bool decide_bare() {
    return solved_by(kLemke) || solved_by("auto") || settled_by_exact_lemke() || branched();
  }

  bool decide_monotone() {
    if (solved_by("active_set")) return true;
    if (may_be_contradicted() && contradicted()) return true;
    return solved_by(kInQuad) || settled_by_exact_lemke();
  }

  bool decide_frictional() {
    if (solved_by("contact_lemke")) return true;
    if (may_be_contradicted() && contradicted()) return true;
    if (solved_by(kLemke) || solved_by("contact_lemke{covering=classic}")) return true;
    if (truth_.system().size() <= kLargestQuad && solved_by(kInQuad)) return true;
    return solvable_by_velocity() || settled_by_exact_lemke() || branched();
  }

  bool solved_by(const char* spec) {
    if (deadline_.passed()) return false;
    const Answer& answer = candidates_.answer(spec, problem_, deadline_.left_s());
    return answer.claim == Claim::kSolved && solved_near(answer.z, std::string("basis of ") + spec);
  }

  bool solved_near(const Vector& z, const std::string& detail) {
    std::optional<ExactPoint> point = point_near(z);
    if (!point) return false;
    take_solution(truth_.stated(std::move(*point)), detail);
    return true;
  }

  bool solves(const ExactPoint& point) const { return is_solution(truth_.stated(), truth_.stated(point), deadline_); }

  std::optional<ExactPoint> point_near(const Vector& z) const {
    return certified_near(
        truth_.system(), z, deadline_, [&] { return tight_rows(problem_, z); }, [&] { return settled_near_answer(z); },
        [&](const ExactPoint& point) { return solves(point); });
  }

  std::optional<ExactPoint> settled_near_answer(const Vector& z) const {
    const Guess guess = classified(problem_, z, kClear);
    if (guess.unclear.empty() || guess.unclear.size() > kMostUnclear) return std::nullopt;
    return settled_near(truth_.system(), guess, deadline_, [&](const ExactPoint& point) { return solves(point); });
  }

  /// @param point  of stated(), checked
  void take_solution(ExactPoint point, const std::string& detail) {
    const ScaledVector z = truth_.z(point);
    certificate_.kind = CertificateKind::kSolution;
    certificate_.proof = ProofKind::kExactBasis;
    certificate_.exact_z = to_text(z);
    certificate_.z = to_doubles(z);
    certificate_.detail = detail;
    if (contact_ != nullptr) {
      const ScaledVector velocity = truth_.velocity_after(point);
      certificate_.exact_potential = to_text(truth_.potential(point));
      certificate_.exact_velocity = to_text(velocity);
      certificate_.velocity = to_doubles(velocity);
    }
    solution_ = std::move(point);
  }

  // Impulses that move nothing need not be able to bring contacts to rest: neither can those that move all where
  // contacts ask for more than rest.
  bool may_be_contradicted() const { return !truth_.inertia().full_rank || contact_->has_offset(); }

  bool contradicted() {
    if (deadline_.passed() || contact_->nc() == 0) return false;
    const Problem squares = contradiction_problem(*contact_);
    const Answer& answer = candidates_.answer("active_set", squares, deadline_.left_s());
    const std::optional<IntegerVector> u = annihilator(truth_.system(), support(answer.z, contact_->nc()), deadline_);
    return u && take_contradiction(*u, "support of a nonnegative least squares solution");
  }

  bool take_contradiction(IntegerVector u, const std::string& detail) {
    u.resize(index(truth_.system().size()));
    if (!is_contradiction(truth_.stated(), u, deadline_)) return false;
    std::vector<slong> exponents = truth_.stated().w_exponent;  // u_i w_i has the unit of w_i: u_i the inverse of it
    const slong largest = exponents.empty() ? 0 : *std::max_element(exponents.begin(), exponents.end());
    for (slong& exponent : exponents) exponent = largest - exponent;
    if (contact_ != nullptr) {
      u.resize(index(contact_layout(*contact_).lambda_offset()));
      exponents.assign(u.size(), 0);
    }
    take_proof(CertificateKind::kUnsolvable, ProofKind::kFarkas, {std::move(u), std::move(exponents), Integer(1)},
               detail);
    return true;
  }

  void take_proof(CertificateKind kind, ProofKind proof, const ScaledVector& vector, const std::string& detail) {
    certificate_.kind = kind;
    certificate_.proof = proof;
    certificate_.exact_farkas = to_text(vector);
    certificate_.farkas = to_unit_doubles(vector);
    certificate_.detail = detail;
  }

  // On monotone problems Lemke ends at a solution or at a proof that there is none. On others it need not do either.
  bool settled_by_exact_lemke() {
    const Index order = std::max(truth_.system().size(), truth_.system().potentials());
    const Index largest = contact_ == nullptr ? kLargestBareLemke
                          : truth_.monotone() ? kLargestMonotoneLemke
                                              : kLargestContactLemke;
    if (order > largest || deadline_.passed()) return false;
    const std::optional<ReducedSystem> eliminated = without_potentials(truth_.system(), deadline_);
    if (!eliminated) return false;
    const LemkeOutcome outcome = exact_lemke(eliminated->lcp, deadline_);
    if (outcome.ending == LemkeEnding::kSolution) {
      ExactPoint point = expanded(*eliminated, truth_.system(), outcome.z, outcome.denominator);
      if (!solves(point)) return false;
      take_solution(truth_.stated(std::move(point)), "exact lexicographic Lemke");
      return true;
    }
    return outcome.ending == LemkeEnding::kRay && !truth_.frictional() &&
           take_contradiction(outcome.z, "ray of exact lexicographic Lemke");
  }

  bool branched() {
    if (deadline_.passed()) return false;
    BranchingOutcome outcome = branch(problem_.lcp(), truth_.system(), deadline_,
                                      [this](const Vector& z) { return solved_near(z, "branch and bound"); });
    if (outcome.solved) return true;
    if (outcome.solution && solves(*outcome.solution)) {
      take_solution(truth_.stated(std::move(*outcome.solution)), "branch and bound");
      return true;
    }
    if (outcome.proof.empty()) return false;
    if (contact_ == nullptr && outcome.proof.size() == 1) {
      return take_contradiction(multipliers(outcome.proof.front()), "the linear inequalities contradict each other");
    }
    const auto is_leaf = [](const ProofNode& node) { return node.row < 0; };
    const auto leaves = std::count_if(outcome.proof.begin(), outcome.proof.end(), is_leaf);
    certificate_.kind = CertificateKind::kUnsolvable;
    certificate_.proof = ProofKind::kBranching;
    certificate_.detail = "branch and bound: " + std::to_string(leaves) + " contradictions";
    certificate_.branches = std::move(outcome.proof);
    return true;
  }

  IntegerVector multipliers(const ProofNode& leaf) const {
    const std::vector<slong>& exponents = truth_.system().w_exponent;
    IntegerVector y(exponents.size());
    const slong least = *std::min_element(exponents.begin(), exponents.end());
    for (const Multiplier& entry : leaf.multipliers) {
      const auto row = index(entry.row);
      fmpz_set_str(y[row].get(), entry.value.c_str(), 10);
      shift_left(y[row], exponents[row] - least);
    }
    return y;
  }

  // Where contacts can bring everything to rest and ask for no more, v + Y p = 0 will do; else v + Y p is the
  // post-impact velocity of the frictionless problem whose contacts are the cones' edges.
  bool solvable_by_velocity() {
    if (!truth_.inertia().semidefinite || deadline_.passed()) return false;
    const bool rests = truth_.inertia().full_rank && (contact_->b.array() >= 0).all() && contact_->offset_t.size() == 0;
    const bool all_yield =
        contact_->nc() > 0 && contact_->compliance_n.size() > 0 && contact_->compliance_n.minCoeff() > 0;
    std::optional<ExactPoint> point;
    if (all_yield) {
      point = ExactPoint{IntegerVector(index(truth_.system().potentials())),
                         IntegerVector(index(truth_.system().size()))};
    } else {
      point = rests ? point_at_rest(truth_, deadline_) : point_within_cones();
    }
    if (!point) return false;
    *point = truth_.stated(std::move(*point));
    if (!is_solvability_proof(truth_.stated(), *contact_, *point, deadline_)) return false;
    take_proof(CertificateKind::kSolution, ProofKind::kLp, truth_.potential(*point),
               "a velocity within the dual friction cones");
    return true;
  }

  std::optional<ExactPoint> point_within_cones() {
    const Dyadic edges = cone_edges(*contact_);
    const Dyadic offsets = offsets_of_edges(*contact_);
    const Dyadic q = velocities_before(edges, truth_.velocity(), offsets, deadline_);
    const ExactSystem cones = frictionless_system(truth_.inertia(), edges, q, deadline_);
    ContactProblem frictionless;
    frictionless.v = contact_->v;
    frictionless.inertia = contact_->inertia;
    frictionless.N = to_doubles(edges);
    if (offsets.m.rows() > 0) frictionless.b = to_doubles(offsets);
    frictionless.D = Matrix(contact_->ngc(), 0);
    frictionless.edges.assign(index(edges.m.cols()), 0);
    frictionless.mu = Vector::Zero(edges.m.cols());
    const Answer& answer =
        candidates_.answer("active_set", Problem("edges", std::move(frictionless)), deadline_.left_s());
    if (answer.claim != Claim::kSolved) return std::nullopt;
    return certified_near(
        cones, answer.z, deadline_, [] { return std::vector<Index>{}; }, [] { return std::optional<ExactPoint>(); },
        [&](const ExactPoint& point) { return is_solvability_proof(truth_.system(), *contact_, point, deadline_); });
  }

  // The contacts in other orders and units lead pivoting methods along other paths.
  template <class Found>
  bool in_a_variant(const char* spec, Found&& found) {
    for (Index number = 0; contact_->nc() > 0 && number < kVelocityVariants && !deadline_.passed(); ++number) {
      const ContactVariant variant(*contact_, number);
      const Answer& answer = candidates_.answer(spec, Problem("variant", variant.problem), deadline_.left_s());
      if (answer.claim == Claim::kSolved && found(variant.of_original(answer.z))) return true;
    }
    return false;
  }

  // Every combination of contact modes, where these are few.
  template <class Found>
  bool in_another_mode(Found&& found) {
    for (const std::vector<Index>& basis : contact_modes(*contact_, kModes)) {
      if (deadline_.passed()) return false;
      const std::optional<ExactPoint> point = basis_point(truth_.system(), basis, deadline_);
      if (point && solves(*point) && found(*point)) return true;
    }
    return false;
  }

  void seek_other_velocity() {
    if (in_another_mode([&](const ExactPoint& point) { return differs(point); })) return;
    const auto differs_near = [&](const Vector& z) {
      const std::optional<ExactPoint> point = point_near(z);
      return point && differs(*point);
    };
    if (!in_a_variant("contact_lemke{precision=double}", differs_near)) in_a_variant(kLemke, differs_near);
  }

  bool differs(const ExactPoint& point) {
    const ExactPoint other = truth_.stated(point);
    if (same_potential(*solution_, other)) return false;
    certificate_.velocity_unique = false;
    certificate_.exact_other_z = to_text(truth_.z(other));
    certificate_.exact_other_potential = to_text(truth_.potential(other));
    return true;
  }

  static Certificate open(const std::string& why) {
    Certificate certificate;
    certificate.detail = why;
    return certificate;
  }

  const Problem& problem_;
  const ContactProblem* contact_;  ///< nullptr: a bare LCP
  const CertifyOptions& options_;
  const Deadline& deadline_;
  Candidates& candidates_;
  ExactProblem truth_;
  Certificate certificate_;
  std::optional<ExactPoint> solution_;
};

/// FLINT keeps memory for each thread; this gives it back when the thread ends.
struct FlintMemory {
  ~FlintMemory() { flint_cleanup(); }
};

}  // namespace
}  // namespace exact

Certificate Certifier::certify(const Problem& problem) {
  // A solver that takes every problem is refused only one with NaN or infinity.
  if (const std::string why = why_not({}, problem); !why.empty()) {
    throw InputError(problem.name() + ": " + why + "; nothing is exact");
  }
  [[maybe_unused]] static thread_local exact::FlintMemory memory;
  const exact::Deadline deadline = options_.most_work > 0 ? exact::Deadline::after_work(options_.most_work)
                                                          : exact::Deadline(options_.time_limit_s);
  Certificate certificate;
  // Whatever one problem makes fail leaves this problem open, and the next ones as they are.
  try {
    certificate = exact::TruthSearch(problem, options_, deadline, candidates_).run();
  } catch (const exact::TimePassed& passed) {
    certificate.detail = passed.what();
  } catch (const std::exception& error) {
    const bool no_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    certificate.detail = no_memory ? "the memory did not suffice" : std::string("the search failed: ") + error.what();
    candidates_ = {};  // a solver that was interrupted is not asked again
  }
  certificate.seconds = deadline.elapsed_s();
  return certificate;
}

const char* to_string(CertificateKind kind) {
  constexpr const char* kNames[] = {"solution", "unsolvable", "open"};
  return kNames[static_cast<std::size_t>(kind)];
}

const char* to_string(ProofKind proof) {
  constexpr const char* kNames[] = {"none", "exact_basis", "farkas", "lp", "branching"};
  return kNames[static_cast<std::size_t>(proof)];
}

}  // namespace lcpbench
