#include <algorithm>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include <flint/flint.h>

#include "core/compliance.h"
#include "core/error.h"
#include "core/registry.h"
#include "core/selection.h"
#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/exact_lemke.h"

namespace lcpbench {
namespace exact {
namespace {

/// Of the exact search near an answer whose basis was no solution: so many rows may be unclear.
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
constexpr Index kVelocityVariants = 16;
/// Most combinations of contact modes to try one by one.
constexpr std::size_t kCombinations = 2500;

constexpr const char* kLemke = "lemke{test=none}";
constexpr const char* kInQuad = "contact_lemke{precision=quad}";

/// Rationals numerators / denominator.
ExactVector to_text(const Dyadic& numerators, const fmpz* denominator) {
  const auto shifted = [](const fmpz* value, slong shift) {
    Integer result;
    fmpz_mul_2exp(result.get(), value, static_cast<ulong>(std::max(shift, slong{0})));
    return text(result.get());
  };
  ExactVector result{shifted(denominator, -numerators.exponent), {}};
  for (Index i = 0; i < numerators.m.rows(); ++i) {
    result.numerators.push_back(shifted(numerators.m(i), numerators.exponent));
  }
  return result;
}

/// Each entry correctly rounded.
Vector to_doubles(const ExactVector& x) {
  Integer denominator;
  Integer numerator;
  fmpz_set_str(denominator.get(), x.denominator.c_str(), 10);
  Vector result(std::ssize(x.numerators));
  for (Index i = 0; i < result.size(); ++i) {
    fmpz_set_str(numerator.get(), x.numerators[index(i)].c_str(), 10);
    result(i) = rounded(numerator.get(), denominator);
  }
  return result;
}

/// The entries over the largest one, rounded. @pre that is not zero
Vector to_unit_doubles(const IntegerMatrix& x) {
  Integer largest;
  for (Index i = 0; i < x.rows(); ++i) {
    if (fmpz_cmpabs(x(i), largest.get()) > 0) fmpz_abs(largest.get(), x(i));
  }
  Vector result(x.rows());
  for (Index i = 0; i < x.rows(); ++i) result(i) = fmpz_is_zero(largest.get()) != 0 ? 0 : rounded(x(i), largest);
  return result;
}

bool has_friction_rows(const BoundedRows& rows) {
  return std::ranges::any_of(rows.bounds.friction_of, [](int of) { return of >= 0; });
}

/// The problem's coordinates with contacts of these columns and offsets, without friction.
ContactProblem without_friction(const ContactProblem& problem, Matrix N, Vector b) {
  ContactProblem contact;
  contact.v = problem.v;
  contact.D = Matrix(problem.ngc(), 0);
  contact.edges.assign(index(N.cols()), 0);
  contact.mu = Vector::Zero(N.cols());
  contact.inertia = problem.inertia;
  contact.N = std::move(N);
  if (!b.isZero(0)) contact.b = std::move(b);
  return contact;
}

/// Certifies a problem of finite data.
///
/// A bare LCP: bases from `lemke` and `auto`, the contradiction of its linear inequalities, exact Lemke up to an order
/// that it can be afforded for, for few unknowns every basis.
///
/// Contacts without friction, and M proven semidefinite: complete. A basis from `active_set`, corrected by exact
/// exchanges if it is wrong; a contradiction on the support of the one that `active_set` gives; last, exact Lemke.
///
/// Contacts with friction: bases from `contact_lemke` and `lemke`; the contradiction of the normals alone; the velocity
/// inside the dual friction cones, the solution of a frictionless problem whose contacts are the cones' edges; for few
/// unknowns exact Lemke, and for very few every basis, which is complete.
class TruthSearch {
 public:
  /// @throws TimePassed, as run() does
  TruthSearch(const Problem& problem, const CertifyOptions& options, const Deadline& deadline, Candidates& candidates)
      : problem_(problem),
        contact_(problem.contact()),
        is_frictional_(contact_ != nullptr && (contact_->frictional() || has_friction_rows(contact_->rows))),
        options_(options),
        deadline_(deadline),
        candidates_(candidates),
        truth_(problem, deadline),
        system_(truth_.system) {}

  Certificate run() {
    if (!truth_.refusal.empty()) return {.detail = truth_.refusal};
    const bool decided = contact_ == nullptr                      ? decide_bare()
                         : truth_.semidefinite && !is_frictional_ ? decide_monotone()
                                                                  : decide_frictional();
    if (!decided) return {.detail = deadline_.passed() ? "the time limit passed" : "no proof was found either way"};
    // Without a positive mu no friction acts, and M of the normals is semidefinite.
    const bool one_velocity =
        solution_ && truth_.semidefinite && contact_->mu.isZero(0) && contact_->rows.bounds.mu.isZero(0);
    if (one_velocity) certificate_.velocity_unique = true;
    const bool may_have_other = solution_ && is_frictional_ && !one_velocity && !truth_.rows;
    if (options_.seek_other_velocity && may_have_other) {
      try {
        seek_other_velocity();
      } catch (const TimePassed&) {  // what was found stays
      }
    }
    return std::move(certificate_);
  }

 private:
  bool decide_bare() {
    return solved_by(kLemke) || solved_by("auto") || contradicted() || settled_by_exact_lemke(kLargestBareLemke) ||
           settled_by_every_basis();
  }

  bool decide_monotone() {
    if (solved_by("active_set") || contradicted() || solved_by(kInQuad)) return true;
    return settled_by_exact_lemke(kLargestMonotoneLemke);
  }

  bool decide_frictional() {
    if (solved_by("contact_lemke") || contradicted()) return true;
    if (solved_by(kLemke) || solved_by("contact_lemke{covering=classic}")) return true;
    if (system_.size <= kLargestQuad && solved_by(kInQuad)) return true;
    return solvable_by_velocity() || settled_by_exact_lemke(kLargestContactLemke) || normals_contradicted_by_lemke() ||
           settled_by_every_basis();
  }

  bool solved_by(const char* spec) {
    if (deadline_.passed()) return false;
    const Answer& answer = candidates_.answer(spec, problem_, deadline_.left_s());
    if (answer.claim != Claim::kSolved) return false;
    const std::optional<Point> point = solution_near(unknowns(answer.z));
    return point && take_solution(*point, std::string("basis of ") + spec);
  }

  bool solves(const Point& point) const { return is_solution(system_, point, system_.values(point, deadline_)); }

  /// Of the system, from z.
  Vector unknowns(const Vector& z) const {
    if (!truth_.rows || z.size() != problem_.size() || !z.allFinite()) return z;
    return truth_.rows->unknowns(z, problem_.lcp().M * z + problem_.lcp().q);
  }

  /// The LCP of the system's unknowns, in double.
  const Lcp& lcp() {
    if (!truth_.rows) return problem_.lcp();
    if (!lcp_) lcp_ = truth_.rows->lcp(problem_.lcp());
    return *lcp_;
  }

  /// A solution near the float solution z.
  std::optional<Point> solution_near(const Vector& z) {
    const auto accepts = [&](const Point& point, const IntegerMatrix& values) {
      return is_solution(system_, point, values);
    };
    const auto settled = [&]() -> std::optional<Point> {
      const Guess guess = classified(lcp(), z);
      if (guess.unclear.empty() || guess.unclear.size() > kMostUnclear) return std::nullopt;
      LemkeOutcome lemke = exact_lemke(system_, guess.basis, guess.unclear, deadline_);
      if (lemke.ending != LemkeEnding::kSolution || !solves(lemke.x)) return std::nullopt;
      return std::move(lemke.x);
    };
    return certified_near(system_, z, settled, accepts);
  }

  /// A point near the float solution z that `accepts` takes.
  /// @param settled  gives a point, or none, in another way; asked when the support of z gave none
  template <class Settled, class Accepts>
  std::optional<Point> certified_near(const ExactSystem& system, const Vector& z, Settled&& settled,
                                      Accepts&& accepts) {
    std::vector<Index> basis = support(z, system.size);
    for (int round = 0; round <= kExchanges; ++round) {
      const auto tight = [&] {
        return round == 0 && &system == &system_ ? classified(lcp(), z).tight : std::vector<Index>();
      };
      Point point = point_on(system, basis, deadline_, tight);
      const IntegerMatrix values = system.values(point, deadline_);
      if (accepts(point, values)) return point;
      if (round == 0) {
        if (std::optional<Point> other = settled()) return other;
      }
      std::vector<Index> next = exchanged_basis(system, point, values);
      if (next == basis) return std::nullopt;
      basis = std::move(next);
    }
    return std::nullopt;
  }

  /// @param point  checked
  bool take_solution(const Point& point, const std::string& detail) {
    certificate_.kind = CertificateKind::kSolution;
    certificate_.proof = ProofKind::kExactBasis;
    certificate_.exact_z = z_of(point);
    certificate_.z = to_doubles(certificate_.exact_z);
    certificate_.detail = detail;
    solution_ = point;
    if (contact_ == nullptr) return true;
    const Dyadic p{part(point, range(1, system_.column_of(0)), {0}), 0};
    certificate_.exact_potential = to_text(p, point(0));
    const Dyadic velocity = truth_.v * Dyadic{part(point, {0}, {0}), 0} + truth_.shape * p;
    certificate_.exact_velocity = to_text(velocity, point(0));
    certificate_.velocity = to_doubles(certificate_.exact_velocity);
    return true;
  }

  ExactVector z_of(const Point& point) const {
    const Dyadic x{part(point, range(system_.column_of(0), point.rows()), {0}), 0};
    if (!truth_.rows) return to_text(x, point(0));
    Vector origin = Vector::Zero(problem_.size());
    origin.tail(truth_.rows->origin.size()) = truth_.rows->origin;
    const Dyadic denominator{part(point, {0}, {0}), 0};
    return to_text(to_dyadic(truth_.rows->to_impulses()) * x + to_dyadic(origin) * denominator, point(0));
  }

  /// The contacts without friction and the bounded rows that have none.
  Problem without_any_friction() const {
    ContactProblem normals = without_friction(*contact_, to_dense(contact_->N), contact_->b);
    normals.compliance_n = contact_->compliance_n;
    normals.rows = contact_->rows;
    return {"normals", select_rows(normals, rows_without_friction())};
  }

  std::vector<Index> rows_without_friction() const {
    std::vector<Index> rows;
    for (Index row = 0; row < contact_->rows.size(); ++row) {
      if (contact_->rows.bounds.friction_of[index(row)] < 0) rows.push_back(row);
    }
    return rows;
  }

  /// A vector that contradicts the inequalities of contacts' normals and bounded rows, or of a bare LCP.
  bool contradicted() {
    if (deadline_.passed()) return false;
    if (contact_ == nullptr) return 2 * system_.size <= kLargestMonotoneLemke && contradicted_by_lemke();
    // Impulses that move nothing need not be able to bring contacts to rest: neither can those that move all where
    // contacts ask for more than rest.
    if (truth_.full_rank && !asks_for_more_than_rest()) return false;
    const Index nc = contact_->nc();
    const std::vector<Index> rows = rows_without_friction();
    const Answer& answer = candidates_.answer("active_set", without_any_friction(), deadline_.left_s());
    if (answer.farkas.size() != nc + std::ssize(rows) || !answer.farkas.allFinite()) return false;
    std::vector<Index> columns = support(answer.farkas.head(nc), nc);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double weight = answer.farkas(nc + static_cast<Index>(i));
      const std::optional<Index> column = truth_.rows->with_sign(rows[i], weight > 0 ? 1 : -1);
      if (weight != 0 && column) columns.push_back(*column);
    }
    // q'u = -1 and B u = 0
    const Dyadic q{part(truth_.q.m, columns, {0}), truth_.q.exponent};
    const Dyadic B{part(truth_.B.m, range(0, truth_.B.m.rows()), columns), truth_.B.exponent};
    const IntegerMatrix equations = transposed(beside(q, transposed(B)).m);
    IntegerMatrix minus_one(equations.rows());
    fmpz_set_si(minus_one(0), -1);
    Integer denominator;
    const IntegerMatrix found = determined(equations, minus_one, denominator, deadline_);
    IntegerMatrix u(system_.size);
    for (Index j = 0; j < found.rows(); ++j) fmpz_set(u(columns[index(j)]), found(j));
    return take_contradiction(u, "support of the contradiction of active_set");
  }

  bool asks_for_more_than_rest() const { return contact_->has_offset() || contact_->rows.b.size() > 0; }

  /// What active_set takes for solvable, as the normals contradict each other by less than it can see.
  bool normals_contradicted_by_lemke() {
    if (!asks_for_more_than_rest() || deadline_.passed()) return false;
    const Problem problem = without_any_friction();
    const ExactProblem truth(problem, deadline_);
    if (truth.system.size > kLargestContactLemke) return false;
    const LemkeOutcome lemke = exact_lemke(truth.system, {}, range(0, truth.system.size), deadline_);
    if (lemke.ending != LemkeEnding::kRay) return false;
    IntegerMatrix u(system_.size);
    for (Index i = 0; i < contact_->nc(); ++i) fmpz_set(u(i), lemke.x(i));
    const std::vector<Index> rows = rows_without_friction();
    for (Index k = 0; truth.rows && k < std::ssize(truth.rows->parts); ++k) {
      const auto [row, sign] = truth.rows->parts[index(k)];
      fmpz_set(u(truth_.rows->with_sign(rows[index(row)], sign).value()), lemke.x(truth.rows->part_offset() + k));
    }
    return take_contradiction(u, "ray of exact lexicographic Lemke on the normals");
  }

  /// Lemke's method on the monotone LCP of [0 -M'; M 0] and (0, q) ends on a ray if no z >= 0 has q + M z >= 0.
  bool contradicted_by_lemke() {
    const Index n = system_.size;
    const IntegerMatrix w = system_.w_in_one_unit();
    const Dyadic q{part(w, range(0, n), {0}), 0};
    const Dyadic M{part(w, range(0, n), range(1, 1 + n)), 0};
    const Dyadic zeros{IntegerMatrix(n, n), 0};
    const ExactSystem both({IntegerMatrix(0, 1 + 2 * n), 0}, beside(Dyadic{IntegerMatrix(n), 0}, zeros, -transposed(M)),
                           beside(q, M, zeros));
    const LemkeOutcome lemke = exact_lemke(both, {}, range(0, 2 * n), deadline_);
    return lemke.ending == LemkeEnding::kRay &&
           take_contradiction(part(lemke.x, range(n, 2 * n), {0}), "the linear inequalities contradict each other");
  }

  bool take_contradiction(IntegerMatrix u, const std::string& detail) {
    if (!is_contradiction(system_, u)) return false;
    if (truth_.rows) {
      u = weights_of_rows(u);
    } else if (contact_ != nullptr) {
      u = part(u, range(0, contact_layout(*contact_).lambda_offset()), {0});
    }
    take_proof(CertificateKind::kUnsolvable, ProofKind::kFarkas, u, Integer(1).get(), detail);
    return true;
  }

  /// One weight for each contact, and for each bounded row that of w less that of -w.
  IntegerMatrix weights_of_rows(const IntegerMatrix& u) const {
    const Index nc = contact_->nc();
    IntegerMatrix weights(nc + contact_->rows.size());
    for (Index i = 0; i < nc; ++i) fmpz_set(weights(i), u(i));
    for (Index k = 0; k < std::ssize(truth_.rows->parts); ++k) {
      const auto [row, sign] = truth_.rows->parts[index(k)];
      fmpz_addmul_si(weights(nc + row), u(truth_.rows->part_offset() + k), sign);
    }
    return weights;
  }

  void take_proof(CertificateKind kind, ProofKind proof, const IntegerMatrix& vector, const fmpz* denominator,
                  const std::string& detail) {
    certificate_.kind = kind;
    certificate_.proof = proof;
    certificate_.exact_farkas = to_text({vector, 0}, denominator);
    certificate_.farkas = to_unit_doubles(vector);
    certificate_.detail = detail;
  }

  // On monotone problems Lemke ends at a solution or at a proof that there is none. On others it need not do either.
  bool settled_by_exact_lemke(Index largest) {
    if (std::max(system_.size, system_.potentials) > largest || deadline_.passed()) return false;
    const LemkeOutcome lemke = exact_lemke(system_, {}, range(0, system_.size), deadline_);
    if (lemke.ending == LemkeEnding::kSolution) {
      return solves(lemke.x) && take_solution(lemke.x, "exact lexicographic Lemke");
    }
    return lemke.ending == LemkeEnding::kRay && !is_frictional_ &&
           take_contradiction(lemke.x, "ray of exact lexicographic Lemke");
  }

  /// Decides any problem of few unknowns. If there is a solution, one is a vertex of the polyhedron of those with its
  /// complementary cone: its support B, and rows T, T containing B, on which w = 0, have independent columns. So
  /// every B is tried, and where the rows of B leave something undetermined, every choice of so many rows more.
  bool settled_by_every_basis() {
    const Index n = system_.size, k = system_.potentials;
    if (n > Certifier::kFewUnknowns) return false;
    const std::vector<Index> equations = range(0, k), everything = range(0, k + n);
    if (rank(equations, range(1, 1 + k)) < k) return false;
    for (Index mask = 0; mask < Index{1} << n; ++mask) {
      if (deadline_.passed()) return false;
      std::vector<Index> basis, others, columns = range(1, 1 + k), rows = equations;
      for (Index i = 0; i < n; ++i) ((mask >> i & 1) != 0 ? basis : others).push_back(i);
      for (const Index i : basis) {
        columns.push_back(system_.column_of(i));
        rows.push_back(system_.row_of(i));
      }
      const Index order = std::ssize(columns), determined_by_basis = rank(rows, columns);
      if (determined_by_basis < order && rank(everything, columns) < order) continue;
      std::vector<Index> with_constants = columns;
      with_constants.push_back(0);
      if (determined_by_basis < order && rank(rows, with_constants) > determined_by_basis) continue;
      const auto is_vertex = [&](const std::vector<Index>& more) { return solved_at(basis, more); };
      if (any_choice(others, order - determined_by_basis, is_vertex)) return true;
    }
    certificate_.kind = CertificateKind::kUnsolvable;
    certificate_.proof = ProofKind::kEveryBasis;
    certificate_.detail = "every basis was tried";
    return true;
  }

  Index rank(const std::vector<Index>& rows, const std::vector<Index>& columns) const {
    return fmpz_mat_rank(part(system_.rows, rows, columns).get());
  }

  /// Whether the point with w = 0 on `basis` and `more`, and z = 0 but for the basis, is a solution; takes it.
  bool solved_at(const std::vector<Index>& basis, const std::vector<Index>& more) {
    const Point point = point_on(system_, basis, deadline_, [&] { return more; });
    return solves(point) && take_solution(point, "one of all bases");
  }

  /// Whether `holds` of some choice of `count` of them.
  template <class Holds>
  static bool any_choice(const std::vector<Index>& all, Index count, Holds&& holds) {
    if (count > std::ssize(all)) return false;
    std::vector<bool> chosen(all.size(), false);
    std::fill_n(chosen.begin(), count, true);
    do {
      std::vector<Index> choice;
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (chosen[i]) choice.push_back(all[i]);
      }
      if (holds(choice)) return true;
    } while (std::prev_permutation(chosen.begin(), chosen.end()));
    return false;
  }

  // Where contacts can bring everything to rest and ask for no more, v + Y p = 0 will do; where all yield, any
  // velocity; else the post-impact velocity of the frictionless problem whose contacts are the cones' edges.
  bool solvable_by_velocity() {
    if (!truth_.semidefinite || truth_.rows || deadline_.passed()) return false;
    const ExactSystem edges = edge_system(*contact_, truth_, deadline_);
    Point point(edges.rows.cols());
    fmpz_one(point(0));
    if (truth_.full_rank) {
      const IntegerMatrix both = beside(truth_.shape, truth_.v).m;
      const std::vector<Index> rows = range(0, both.rows());
      const Index k = edges.potentials;
      Integer denominator;
      const IntegerMatrix p = determined(part(both, rows, range(0, k)), part(both, rows, {k}), denominator, deadline_);
      fmpz_set(point(0), denominator.get());
      for (Index i = 0; i < k; ++i) fmpz_neg(point(1 + i), p(i));
    }
    const auto accepts = [&](const Point&, const IntegerMatrix& values) {
      return is_solvability_proof(*contact_, edges, values);
    };
    if (!accepts(point, edges.values(point, deadline_))) {
      const std::optional<Point> found = point_within_cones(edges, accepts);
      if (!found) return false;
      point = *found;
    }
    take_proof(CertificateKind::kSolution, ProofKind::kLp, part(point, range(1, edges.column_of(0)), {0}), point(0),
               "a velocity within the dual friction cones");
    return true;
  }

  template <class Accepts>
  std::optional<Point> point_within_cones(const ExactSystem& edges, Accepts&& accepts) {
    const ContactLayout layout = contact_layout(*contact_);
    const Matrix N = to_dense(contact_->N);
    Matrix all(N.rows(), edges.size);
    all << N, to_dense(contact_->D);
    Vector offsets = Vector::Zero(edges.size);
    const SoftRows<double> soft(*contact_, layout);
    for (Index i = 0; i < layout.nc; ++i) {
      offsets(i) = contact_->offset(i);
      for (Index t = layout.friction_begin[index(i)]; t < layout.friction_begin[index(i) + 1]; ++t) {
        const Index edge = layout.friction_offset() + t;
        all.col(edge) = N.col(i) + contact_->mu(i) * all.col(edge);
        offsets(edge) =
            offsets(i) + contact_->mu(i) * soft.along(i, t - layout.friction_begin[index(i)], soft.offset(i));
      }
    }
    ContactProblem cones = without_friction(*contact_, std::move(all), std::move(offsets));
    const Answer& answer = candidates_.answer("active_set", Problem("edges", std::move(cones)), deadline_.left_s());
    if (answer.claim != Claim::kSolved) return std::nullopt;
    return certified_near(
        edges, answer.z, [] { return std::optional<Point>(); }, accepts);
  }

  /// Whether a solution of some combination of contact modes, where these are few, is one that `found` takes.
  template <class Found>
  bool in_a_combination(Found&& found) {
    for (const std::vector<Index>& basis : combinations(*contact_, kCombinations)) {
      if (deadline_.passed()) return false;
      const Point point = point_on(system_, basis, deadline_);
      if (solves(point) && found(point)) return true;
    }
    return false;
  }

  void seek_other_velocity() {
    const auto differs = [&](const Point& point) {
      Point a = part(*solution_, range(0, system_.column_of(0)), {0});
      Point b = part(point, range(0, system_.column_of(0)), {0});
      fmpz_mat_scalar_mul_fmpz(a.get(), a.get(), point(0));
      fmpz_mat_scalar_mul_fmpz(b.get(), b.get(), (*solution_)(0));
      if (fmpz_mat_equal(a.get(), b.get()) != 0) return false;
      certificate_.velocity_unique = false;
      certificate_.exact_other_z = z_of(point);
      certificate_.exact_other_potential = to_text({part(point, range(1, system_.column_of(0)), {0}), 0}, point(0));
      return true;
    };
    if (in_a_combination(differs)) return;
    // Other orders and units lead pivoting methods along other paths.
    for (Index number = 0; system_.size > 0 && number < kVelocityVariants && !deadline_.passed(); ++number) {
      const Variant variant(problem_.lcp(), number);
      const Answer& answer = candidates_.answer(kLemke, Problem("variant", variant.lcp), deadline_.left_s());
      if (answer.claim != Claim::kSolved) continue;
      const std::optional<Point> point = solution_near(variant.of_original(answer.z));
      if (point && differs(*point)) return;
    }
  }

  const Problem& problem_;
  const ContactProblem* contact_;  ///< nullptr: a bare LCP
  bool is_frictional_;
  const CertifyOptions& options_;
  const Deadline& deadline_;
  Candidates& candidates_;
  ExactProblem truth_;
  const ExactSystem& system_;
  std::optional<Lcp> lcp_;
  Certificate certificate_;
  std::optional<Point> solution_;
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
  const exact::Deadline deadline =
      options_.most_work > 0 ? exact::Deadline::after_work(options_.most_work) : exact::Deadline(options_.time_limit_s);
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
  constexpr const char* kNames[] = {"none", "exact_basis", "farkas", "every_basis", "lp"};
  return kNames[static_cast<std::size_t>(proof)];
}

}  // namespace lcpbench
