#pragma once

#include <memory>
#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/active_set.h"
#include "native/auto/islands.h"
#include "native/auto/report.h"
#include "native/auto/settings.h"
#include "native/block_inverse.h"
#include "native/contact_lemke.h"

namespace lcpbench {

/// What is left of a solve's limits.
struct AutoLimits {
  double deadline_s = 0;        ///< on wall_clock_s(); infinity: none
  std::int64_t max_pivots = 0;  ///< 0: none

  /// Seconds left.
  double time() const;
  /// Pivots left when so many are done; meaningless without a limit.
  std::int64_t pivots(const Counters& done) const { return max_pivots - done.pivots; }
  bool exhausted(const Counters& done) const { return max_pivots > 0 && pivots(done) <= 0; }
};

/// Solves the contacts of one island, with as few of them as will do.
///
/// Where no contact approaches, none presses and nothing is solved. In large islands of bodies, contacts that separate
/// faster than any other approaches are left out; those that the answer's velocity has approaching are brought back,
/// and the rest solved again, until there are none: an answer of the whole island, since contacts left out need no
/// impulse when they do not approach. Once brought back, a contact stays until the next load().
class IslandSolver {
 public:
  explicit IslandSolver(const AutoSettings& settings) : settings_(settings) {}

  /// @param whole must outlive the next load()
  /// @param v velocity of the whole problem
  /// @param carries per contact of the whole; kept at 1 for those whose lambda the answer of solve() includes
  void load(ProblemCutter& whole, Island island, const Vector& v, std::vector<char>& carries);

  /// Another velocity. Loads anew only when contacts that were left out now approach.
  void update(const Vector& v);

  /// Adds the island's impulses to z and its change of velocity to u, both of the whole problem. u arrives as v.
  /// @param start of the whole problem, or nullptr
  /// @returns kSolved, or why not; answer() then says more
  Claim solve(const Vector* start, const AutoLimits& limits, Vector& z, Vector& u, AutoReport& report);

  /// The last solver's answer for the contacts in contacts().
  const Answer& answer() const { return answer_; }
  const std::vector<Index>& contacts() const { return kept_; }
  /// The last solve gave a velocity of the solver's own, which is in u.
  bool gave_velocity() const { return method_ == Method::kNone || answer_.velocity.size() > 0; }
  /// False where solve() may need memory.
  bool allocation_free() const { return !is_sparse(method_) && !leaves_some_out(); }

 private:
  enum class Method { kNone, kActiveSet, kContactLemke, kVelocityIpm, kFrictionIpm };

  static bool is_sparse(Method method) { return method == Method::kVelocityIpm || method == Method::kFrictionIpm; }

  bool is_scene() const { return std::holds_alternative<BlockInertia>(cutter_->whole().inertia); }
  bool leaves_some_out() const { return method_ != Method::kNone && kept_.size() < island_.contacts.size(); }
  bool measure_approach(const Vector& v);
  bool keep_what_may_press();
  void build(const Vector& v);
  Method choose_method() const;
  void load_method(Method method);
  void place_unknowns(const ContactProblem& part);
  Solver& solver();
  Claim run(const Vector* start, const AutoLimits& limits, AutoReport& report);
  Claim run_once(const Vector* start, const AutoLimits& limits, AutoReport& report);
  void add_velocity(Vector& u);
  Index bring_back(const Vector& u);

  const AutoSettings& settings_;
  ProblemCutter* cutter_ = nullptr;
  std::vector<char>* carries_ = nullptr;
  Island island_;
  std::vector<char> is_kept_;  ///< by position in island_.contacts
  std::vector<Index> kept_;    ///< contacts of part_
  Vector approach_;            ///< N'v by position in island_.contacts
  double fastest_ = 0;         ///< the largest of -N'v
  double scale_ = 0;           ///< max|N'v|

  Method method_ = Method::kNone;
  Problem part_;
  std::vector<Index> place_;  ///< in z of the whole, of each unknown of the part
  bool needs_velocity_ = false;
  BlockInverse inverse_;
  Vector v_, u_, impulse_, start_;
  Answer answer_;

  std::unique_ptr<ActiveSet> active_set_;
  std::unique_ptr<ContactLemke> contact_lemke_;
  std::unique_ptr<Solver> velocity_ipm_, friction_ipm_;
};

}  // namespace lcpbench
