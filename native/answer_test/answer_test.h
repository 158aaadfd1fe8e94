#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/answer/contact_residual.h"
#include "core/problem.h"
#include "core/solver.h"
#include "native/contact_lemke/contact_farkas.h"
#include "native/answer_test/bare_lcp_test.h"
#include "native/answer_test/contact_test.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/contacts/contact_input.h"
#include "native/proofs/doubtful_inertia.h"

namespace lcpbench {

/// Of the verdict's 1e-4: in 113 bits nothing is lost to rounding but that of the returned lambdas.
inline constexpr double kClaimedQuadResidual = 0.999e-4;

/// The last test of an answer before it is claimed as solved, from the data of the problem, by the measure of the
/// verdict. Methods that work on M need it most: M as rounded is another problem where the inertia is near singular,
/// and its exact solution may be none of the contacts'.
class AnswerTest {
 public:
  AnswerTest();

  /// Of contacts O(nonzeros), by factors O(ngc^3), of bare LCPs O(n^2).
  /// @param problem must stay as it is until the next load
  /// @param numbers of the problem's islands, where they are known
  void load(const Problem& problem, const IslandNumbers* numbers = nullptr);

  /// The same contacts, another velocity before the impact (ngc). @pre a contact problem was loaded
  void set_velocity(const Vector& v);

  /// Contacts between separate bodies (BlockInertia) may leave this velocity residual from now on, even if the verdict allows less;
  /// not where there may be no solution.
  void allow(double residual) { allowed_ = residual; }

  /// Where the claim is not solved, nothing. Else: entries of z below zero count as zero, and so do friction of
  /// contacts that do not press and impulses of islands where none approaches; lambda is the least that the friction
  /// impulses allow. If that solves the problem it is the answer. If not, z stays and the claim becomes
  /// kNumericalFailure (`detail` "residual" or "unconfirmed"), kTimeLimit where the deadline came first, or kUnsolvable where `farkas`
  /// shows that there is no solution: of bare LCPs exactly, of contacts in 113 bits. Of contact problems the velocity
  /// residual with its estimated rounding has to be within kClaimedResidual of the scale in double, or within what the
  /// verdict allows by ContactResidual; of bare LCPs the backward error within kClaimedBackwardError. O(ngc n), with
  /// the cubes of the orders of the blocks of G the first time. Only a proof for contacts allocates, and the first test
  /// by ContactResidual. A velocity is not tested.
  ///
  /// With singular inertia contacts may miss a solution by little: there the residual has to be at most kSureResidual.
  /// An answer with more is "unconfirmed", unless the problem is proven to have no solution (ContactFarkas).
  /// @param deadline_s on wall_clock_s(), for 113 bits of contacts and for proofs; infinity: none
  /// @returns whether the claim is still solved
  bool settle(Answer& answer, double deadline_s);

  /// Of a method that ended in a ray, which proves nothing for most matrices. The claim becomes kUnsolvable where the
  /// problem is proven to have no solution as in settle(), else kNumericalFailure, `detail` "ray". z stays.
  /// @param u nearly a proof for a bare LCP, where the method has one; else nullptr
  void settle_ray(Answer& answer, double deadline_s, const Vector* u = nullptr);

  /// Of the bare LCP's answer in the last settle(). @pre its claim was solved
  double backward_error() const { return backward_error_; }

  /// Multiplications of doubles that take as long as the test of contacts in 113 bits of the last settle(), about; 0
  /// where double decided. It depends on the data alone. Of bare LCPs 0.
  double work_in_quad() const { return work_in_quad_; }

 private:
  enum class Outcome { kSolved, kUnsolvable, kResidual, kUnconfirmed, kOutOfTime };

  bool solves(const Vector& z);
  void release();
  bool solves_contacts();
  bool measure_in_quad();
  Outcome confirm(double deadline_s);
  bool is_disproved(double deadline_s);
  void report_proof(Answer& answer);

  std::unique_ptr<contact_lemke::Engine> judge_;  // of inertia by factors, as is contacts_
  ContactInput contacts_;
  BareLcpTest bare_test_;
  ContactTest contact_test_;              // of other contacts
  std::optional<ContactResidual> exact_;  // once double was in doubt
  ContactResidual::Point point_;          // of completed_, by exact_
  DoubtfulInertia doubtful_;
  const ContactProblem* contact_ = nullptr;  // nullptr: bare
  bool by_blocks_ = false, by_factors_ = false;  // how the inertia is given
  bool bare_ = true;
  bool may_be_unsolvable_ = false;  // the inertia of contacts may be singular, or their offset asks for too much
  bool is_singular_ = false;        // for all that double tells
  ContactFarkas farkas_;
  double deadline_s_ = 0;    // of settle()
  bool lacks_time_ = false;  // for a test in 113 bits, of settle()
  double work_in_quad_ = 0;
  double residual_ = 0;  // of completed_, of contacts
  double least_ = 0;     // a lower bound on residual_ but for rounding: more bits cannot make it less
  double allowed_ = 0;
  double backward_error_ = 0;
  Vector velocity_;          // v of contacts
  std::vector<char> moves_;  // by island: a contact approaches there
  Vector completed_;         // n
};

}  // namespace lcpbench
