#pragma once

#include <cstddef>
#include <vector>

#include "core/islands.h"
#include "core/problem.h"
#include "core/solver.h"
#include "native/answer_test/answer_test.h"
#include "native/auto/sticking_system.h"

namespace lcpbench {

/// The impulses f of contacts along the columns A of a StickingSystem: of each contact the normal one, then one for
/// each pair of opposite directions.
class ColumnImpulses {
 public:
  explicit ColumnImpulses(const StickingSystem& system) : system_(system) {}

  /// @pre the system holds the contacts, which must outlive the next load
  void load(const ContactProblem& contact);
  /// Those of z (n).
  void read(const Vector& z);
  /// z (n) of the impulses. The lambdas become zero: AnswerTest sets them.
  void write(Vector& z) const;

  std::vector<double>& all() { return impulses_; }
  double* of(std::size_t contact) { return impulses_.data() + system_.contacts()[contact].first; }
  double normal(std::size_t contact) const { return impulses_[system_.contacts()[contact].first]; }
  /// Sum of magnitudes.
  double friction(std::size_t contact) const;
  void scale_friction(std::size_t contact, double factor);
  double largest_normal() const;
  /// Whether none is further out of its cone than that.
  bool are_in_cones(double tolerance) const;
  /// Those outside of their cones come inside, a little further than to the boundary. @returns whether there were none
  bool bring_inside();

 private:
  const StickingSystem& system_;
  const ContactProblem* contact_ = nullptr;
  std::vector<double> impulses_;
};

/// The guess that contacts which pressed in the last step press again and none of them slips: what holds in a scene
/// that rests.
///
/// With the columns A of these contacts the velocity u is then the projection of v onto {u : A'u + b = 0}, in the
/// metric of the inertia. A'G*A is singular where contacts are redundant, so that many impulses f give this u. Two are
/// tried: the least, and those nearest to the last step's. Both are in the norm sum |f_c|^2 / W_c, with a weight W_c of
/// each contact in proportion to its normal impulse in the last step. The first that is in the friction cones is taken.
/// The augmented Lagrangian method with penalties W finds them: it solves G (u - v) = A f and A'u + b = 0 by the
/// Cholesky factors of G + A W A'. A contact that would have to pull is released, one that approaches becomes a
/// sticking one, and the guess is tried again, a few times. AnswerTest has the last word.
///
/// Only the u of least energy (u - v)'G (u - v) subject to (N + mu d)'u + b >= 0, for all contacts and their directions
/// d, is returned: at contacts that do not stick this is tested. So a step that can come to rest does.
///
/// Needs the inertia as blocks or as one matrix G. Keeps the order of elimination and all memory where the contacts of
/// the next problem touch the same bodies.
class StickingContacts {
 public:
  /// @param follow each problem is the next step of the last
  explicit StickingContacts(bool follow) : follow_(follow) {}

  /// Whether it can be loaded: G itself is given.
  static bool takes(const ContactProblem& contact);

  /// Whether a guess costs little beside what the other methods cost, and is right often enough: for hard contacts with
  /// friction, from a size on. @param is_loaded whether the first method is loaded
  static bool is_worth_a_guess(const ContactProblem& contact, bool is_loaded);

  /// Whether a quarter of the contacts or more pressed in the last answer, and none of those with friction slipped.
  /// O(n) @param v gives the scale of slip @param start the last answer brought to these contacts; any size
  static bool sticking(const ContactProblem& contact, const Vector& v, const Vector& start);

  /// O(nonzeros of N and D), and a new order of elimination where contacts touch other bodies than in the last load.
  /// @param problem must outlive the next load @pre takes()
  void load(const Problem& problem, const Vector& v);
  void set_velocity(const Vector& v);

  /// A factorization of the sparse G + A W A' for each guess, one of a G that is one matrix, and one test of the
  /// answer. Only the first test after load(), and exact arithmetic in a test, may allocate.
  /// @param start the last answer brought to these contacts (n)
  /// @param tries guesses at most: the first, and those after contacts changed between sticking and free
  /// @param deadline_s on wall_clock_s(), for the test alone
  /// @param work counts the factorizations of the guesses
  /// @returns whether a guess was right: answer is then kSolved, else it is not to be used
  bool solve(const Vector& start, int tries, double deadline_s, Answer& answer, Counters& work);

  /// Changes the impulses of z (n) as little as possible, those that press more the most, until they balance the
  /// momentum G v of the island: those of rest. A factorization, and a solve for each step.
  /// @param power changes are in proportion to this power of the normal impulses, as far as may be
  /// @param touching contacts with a larger offset carry nothing
  /// @pre z is in the cones @returns whether the changed impulses are; z is then overwritten
  bool balance(Vector& z, int power, double touching);

 private:
  // Steps of solve(), in their order.
  void weigh();
  bool starts(const Vector& start);
  double release_all();
  double iterate(double residual);
  void improve();
  double velocity_residual();
  double held_residual() const;
  void find_velocities(const Vector& u);
  bool is_confirmed(double residual);
  double clearance(std::size_t contact) const;
  bool change_guess();
  // Of balance().
  void add_missing_momentum();

  IslandNumbers islands_;  ///< that all is one island, for test_
  bool follow_ = false;
  const Problem* problem_ = nullptr;
  const ContactProblem* contact_ = nullptr;
  AnswerTest test_;
  bool has_test_ = false;      ///< test_ holds the problem
  bool from_nothing_ = true;   ///< the least impulses are tried before those nearest to the last
  StickingSystem system_;
  ColumnImpulses impulses_{system_};

  Vector v_, u_, step_, residual_;
  std::vector<char> sticking_;      ///< by contact
  std::vector<double> weights_;     ///< by contact: W
  std::vector<double> velocities_;  ///< by column: A'u + b
  std::vector<double> scaled_;      ///< by column: scratch
  double scale_ = 0;                ///< largest |A'v + b|; infinity where one is not a number
};

}  // namespace lcpbench
