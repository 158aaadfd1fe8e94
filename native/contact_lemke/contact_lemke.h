#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>

#include "core/isa.h"
#include "core/settings.h"
#include "core/solver.h"
#include "native/contact_lemke/engine.h"
#include "native/contacts/contact_input.h"
#include "native/contacts/growing_vector.h"
#include "native/contacts/budgeted_solver.h"
#include "native/contact_lemke/contact_farkas.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {

enum class ContactLemkePrecision { kDouble, kQuad, kCascade };
enum class ContactLemkeCovering { kBoth, kNormals, kClassic };

struct ContactLemkeSettings {
  ContactLemkePrecision precision = ContactLemkePrecision::kCascade;
  ContactLemkeCovering covering = ContactLemkeCovering::kBoth;
  double accept_residual = 1e-6;
  std::int64_t max_pivots = 0;

  void visit(auto&& field) {
    using Precision = ContactLemkePrecision;
    using Covering = ContactLemkeCovering;
    field(
        "precision", precision,
        Choices<Precision>{{{"double", Precision::kDouble},
                            {"quad", Precision::kQuad},
                            {"cascade", Precision::kCascade}}},
        "arithmetic: 53 or 113 bits; cascade: 53, and 113 only where that does not pass the test of its answer");
    field("covering", covering,
          Choices<Covering>{
              {{"both", Covering::kBoth}, {"normals", Covering::kNormals}, {"classic", Covering::kClassic}}},
          "covering vector: on normal rows only, positive on every row, or the second where the first fails");
    field("accept_residual", accept_residual, RealRange{.min = 0, .max = 5e-5},
          "velocity residual relative to the scale of the island below which no further stage of the cascade is tried");
    field("max_pivots", max_pivots, IntegerRange{.min = 0, .max = std::int64_t{1} << 40},
          "limit on pivots over all stages together; 0: none but those of the stages");
  }
};

enum class ContactArithmetic { kDouble, kQuad };
struct ContactStage;

/// The engine in 113 bits. Few solves come to it, so that solvers that take turns may share it.
struct LaterEngines {
  LaterEngines();

  std::unique_ptr<contact_lemke::Engine> quad;
  const void* holder = nullptr;  ///< the solver whose problem it holds
};

/// Solves contact problems by Lemke's method on the factors (v, N, D, mu, G); M is never formed.
///
/// Friction rows exist only where a contact presses and the kernel of the basis has at most rank(G) + 1 rows. A stage
/// that does not pass the solver's own test of its answer is followed by the next: other covering vectors, among them
/// the one that is positive on every row, and 113-bit arithmetic. With mu >= 0, positive definite G and no ties that
/// last one ends in a solution. O(ngc (ngc + friction directions of pressing contacts)) per pivot; tens of pivots.
/// [Lemke 1965; Anitescu, Potra 1997; Cottle, Pang, Stone 1992, 4.4] See docs/reference/solvers/contact_lemke.md.
///
/// kSolved: the velocity residual with its estimated rounding is within 5e-5 of the scale of each island, evaluated from
/// the returned z; `detail` names the stage. kUnsolvable: with a proof in `farkas`. kIterationLimit, kTimeLimit;
/// kNumericalFailure: no stage gave an answer that passes. z is then the answer of all stages with the least residual,
/// if that is at most 1e-4 of the scale with its rounding; else zero, as it is if exact arithmetic refutes the answer
/// that was to be claimed. A start is ignored: a basis cannot be told from z where impulses are zero.
class ContactLemke final : public BudgetedSolver {
 public:
  /// @param level instruction-set level of the engine; must not exceed best_isa_level().
  explicit ContactLemke(const ContactLemkeSettings& settings, IsaLevel level = isa_level());
  /// @param later shared with solvers that never run at the same time as this one
  ContactLemke(const ContactLemkeSettings& settings, std::shared_ptr<LaterEngines> later, IsaLevel level = isa_level());

  static constexpr Capabilities kCapabilities{
      .needs = Needs::kFactored,
      .max_size = 3000,          // dense matrices of order ngc, which may be several times n
      .max_entries = 1'000'000,  // they take about 150 MB of addresses
      .compliance = true,
      .guarantees = "contact problems with mu >= 0 and positive definite G, without degeneracy",
      .obeys_time_limit = true,
      .allocation_free = true};
  const Capabilities& capabilities() const override { return kCapabilities; }

  /// Budget::error > 0 takes the place of accept_residual, but no more than the default of that.
  bool solve_within(const Budget& budget, Answer& answer) override;
  double work() const override { return progress_.work; }
  double residual(const Answer& answer) override;

  /// What load() takes, in the units of work(). @param idle coordinates that no contact moves, which are left out
  static double load_work(const Problem& problem, Index idle);

  /// Takes all memory that load() and solve() need for this problem, and touches hardly any of it: load() then
  /// allocates nothing for this and any other that was reserved. What was loaded must be loaded again.
  void reserve(const Problem& problem);

  /// ContactLemkeSettings::max_pivots from now on.
  void limit_pivots(std::int64_t max_pivots) { settings_.max_pivots = max_pivots; }

  /// Limits the number of stages; 0: no limit. Stages whose path is ended by their own limit on pivots, mostly since it
  /// cycles, are not counted, nor is the warm one.
  void limit_stages(std::int64_t max_stages) { max_stages_ = max_stages; }

  /// From now on a solve first goes on from the basis of the last one, pivot by pivot as contacts change between the
  /// two velocities (`detail` is then "warm").
  void resume_bases() { resumes_ = true; }

  /// Whether all contacts and coordinates of the problems loaded from now on are known to be one island. They are then
  /// not searched for islands.
  void expect_one_island(bool is_known) { data_.is_one_island = is_known; }

  /// Sets the lambdas of z (n) to the least that its impulses allow. @returns its residual for the loaded problem at
  /// the velocity now, in double, relative to the scale of each island
  contact_lemke::Residual complete(double* z) { return double_->complete(z); }

  /// velocity := v + G* [N D] z, for z (n) and velocity (ngc) of the loaded problem, in the highest precision that its
  /// solves came to. O(ngc^2)
  void respond(const Vector& z, Vector& velocity);

 private:
  /// Of one solve, over all its stages.
  struct Progress {
    double deadline_s = 0;
    double accepted = 0;  ///< an answer of at most this residual ends the solve
    double work = 0;
    double most_work = std::numeric_limits<double>::infinity();  ///< `work` at which the solve ends
    bool is_fresh = true;  ///< the caller's z is zero
  };

  /// What a solve has found. Apart from Progress: one struct of both would be cleared by an instruction that takes as
  /// long as a hundred others.
  struct Findings {
    double best = std::numeric_limits<double>::infinity();  ///< residual and its rounding, relative to the scale
    contact_lemke::Ending ending = contact_lemke::Ending::kBreakdown;
    int long_paths = 0;  ///< that were ended by the limit on pivots of their stage
    const char* stage = "";  ///< of the best answer
    std::ptrdiff_t pivots = 0;
    std::ptrdiff_t factorizations = 0;
    bool is_asked = false;          ///< whether it was tried to prove that there is no solution
    bool is_disproved = false;      ///< that is proven
    bool is_best = false;           ///< the caller's z is the best answer
    bool can_claim = false;         ///< the best answer may be claimed as solved
    bool is_beyond_double = false;  ///< solved in 113 bits, but not by the doubles nearest to these impulses

    std::ptrdiff_t pivots_left(std::int64_t limit) const {
      return limit > 0 ? static_cast<std::ptrdiff_t>(limit) - pivots : std::numeric_limits<std::ptrdiff_t>::max();
    }
  };

  void on_load(const Problem& problem) override;
  void on_update(const Vector& v) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

  enum class Climbed {
    kOutOfWork,  ///< the budget is over
    kFailed,     ///< other stages may do better
    kLast        ///< nothing remains to be tried
  };

  void reserve_later_stages(const contact_lemke::Input& input);
  contact_lemke::Engine& engine_of(ContactArithmetic arithmetic);
  bool holds(ContactArithmetic arithmetic) const;
  double work_until_loaded(ContactArithmetic arithmetic) const;
  bool has_time_for(double work) const;
  std::ptrdiff_t pivots_of(const ContactStage& stage) const;
  bool asks_for_given_velocity() const { return may_be_unsolvable_ || doubtful_.may_be_singular(); }
  void begin(const Budget& budget);
  bool follow_stages(double* z);
  bool begins(const ContactStage& stage);
  Climbed climb(const ContactStage& stage, double* z);
  Climbed judge(const ContactStage& stage, contact_lemke::Ending ending, double* z);
  bool is_confirmed_exactly(const double* z);
  contact_lemke::Outcome run(const ContactStage& stage, double* z);
  bool is_disproved();
  void report(Answer& answer);

  ContactLemkeSettings settings_;
  std::int64_t max_stages_ = 0;
  bool resumes_ = false;    ///< see resume_bases()
  bool has_basis_ = false;  ///< the engine in double holds that of the last answer
  ContactInput data_;
  std::array<std::ptrdiff_t, 8> room_in_later_stages_{};  ///< see reserve_later_stages()
  std::unique_ptr<contact_lemke::Engine> double_;
  std::shared_ptr<LaterEngines> later_;
  ContactFarkas farkas_;
  DoubtfulInertia doubtful_;
  bool may_be_unsolvable_ = false;  ///< the inertia may be singular, or an offset may ask for too much
  GrowingVector given_v_;           ///< where either may be so, the velocity in the units of the problem
  Progress progress_;
  Findings found_;
  contact_lemke::Rules rules_;    ///< of the present stage
  GrowingVector z_;               ///< scratch
  GrowingVector best_;
};

/// In double. @throws std::invalid_argument when this processor lacks the level
std::unique_ptr<contact_lemke::Engine> make_contact_lemke_engine(IsaLevel level);

}  // namespace lcpbench
