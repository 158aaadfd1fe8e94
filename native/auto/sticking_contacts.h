#pragma once

#include <cstddef>
#include <vector>

#include "core/islands.h"
#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/auto/sticking_system.h"

namespace lcpbench {

/// The guess that contacts which pressed in the last step press again and none of them slips: what holds in a scene
/// that rests.
///
/// With the columns a of these contacts the velocity is then the projection of v onto {u : a'u + b = 0}, in the metric
/// of the inertia. The impulses are the least that give this velocity, each contact's measured against its load in the
/// last step, or the last impulses and the least such change of them, whichever is in the friction cones. Both are
/// found by Newton's steps on G (u - v) = A f and A'u + b = 0 through the Cholesky factors of G + A W A', whose weights
/// W stand in for the inverse of the singular A'G*A. A contact that would have to pull is let go, one that approaches
/// becomes a sticking one, and the guess tried again, a few times. The answer is tested as those of friction_ipm are.
///
/// An answer is handed out only if its velocity is that of least energy: contacts that do not stick leave the pyramids'
/// (N + mu d)'u + b >= 0. So a step that can rest is brought to rest.
///
/// Needs the inertia as blocks or as one matrix G. Keeps the order of elimination and all memory where the contacts of
/// the next problem touch the same bodies.
class StickingContacts {
 public:
  /// @param follow each problem is the next step of the last
  explicit StickingContacts(bool follow) : follow_(follow) {}

  /// Whether it can be loaded: G itself is given.
  static bool takes(const ContactProblem& contact);

  /// Whether a guess costs little of what a method takes, and is right often enough: hard contacts with friction from a
  /// size on. @param is_loaded whether the first method of the race is loaded
  static bool is_worth_a_guess(const ContactProblem& contact, bool is_loaded);

  /// Whether a quarter of the contacts or more pressed in the last answer, brought to these contacts, and none of them
  /// slipped. O(n)
  static bool sticking(const ContactProblem& contact, const Vector& v, const Vector& start);

  /// O(nonzeros of N and D), and of another graph than the last its order of elimination.
  /// @param problem must outlive the next load @pre takes()
  void load(const Problem& problem, const Vector& v);
  void set_velocity(const Vector& v);

  /// A factorization of the sparse G + A W A' for each guess, and one test of the answer. Allocates nothing.
  /// @param start the last answer brought to these contacts (n)
  /// @param tries guesses at most: the first, and those after contacts changed between sticking and free
  /// @param work counts the factorizations
  /// @returns whether the guess was right: answer is then kSolved
  bool solve(const Vector& start, int tries, double deadline_s, Answer& answer, Counters& work);

 private:
  void take_room();
  void see(const Vector& u);
  void measure_scale();
  void take_start(const Vector& start);
  void weigh();
  void respond();
  double miss();
  double largest_held_miss() const;
  void improve();
  double let_go();
  double largest_load() const;
  bool may_be_confirmed() const;
  double approach(double now);
  bool starts(const Vector& start);
  bool is_confirmed(double left);
  bool is_definite();
  double clearance(std::size_t contact) const;
  bool change_guess();
  void write(Answer& answer) const;
  void load_test();
  double offset(std::size_t contact) const { return contact_->offset(static_cast<Index>(contact)); }

  IslandNumbers islands_;  ///< where it is one
  bool follow_ = false;
  const Problem* problem_ = nullptr;
  const ContactProblem* contact_ = nullptr;
  AnswerTest test_;
  bool has_test_ = false;   ///< test_ holds the problem
  bool from_loads_ = true;  ///< impulses from the last loads are tried before those from the last impulses
  StickingSystem system_;

  Vector v_, u_, step_, residual_;
  std::vector<char> sticking_;             ///< by contact
  std::vector<double> load_;               ///< by contact: the weight of its columns
  std::vector<double> impulses_, misses_;  ///< by column: f, and A'u + b
  std::vector<double> scaled_;             ///< by column: of the weights, and of a step
  double scale_ = 0;                       ///< largest |A'v + b|; infinity where one is not a number
};

}  // namespace lcpbench
