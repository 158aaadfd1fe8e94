#pragma once

#include <array>
#include <memory>

#include "native/answer_test/answer_test.h"
#include "native/auto/methods.h"
#include "native/auto/order.h"
#include "native/auto/sticking_contacts.h"

namespace lcpbench {

/// Of one solve.
struct AutoLimits {
  double deadline_s = 0;  ///< on wall_clock_s(); infinity: none
  double error = 0;       ///< that the answer may leave; 0: none is stated
};

/// The problem of an island, the methods that solve it, and what they came to in one solve: shared by all that looks
/// for its answer.
class IslandTask {
 public:
  enum class Progress { kNone, kBegun, kEnded };

  /// @param is_one each problem is one island with all its contacts and coordinates, and the next step of the last
  explicit IslandTask(bool is_one) : is_whole(is_one) {}

  /// @param problem must outlive the next load
  void load(const Problem& problem, const Vector& v);
  void set_velocity(const Vector& v);
  /// Begins a solve.
  void begin(const AutoLimits& limits);

  const ContactProblem& contact() const { return *problem->contact(); }
  Progress& progress_of(AutoMethod method) { return progress[static_cast<std::size_t>(method)]; }

  /// The largest residual that AnswerTest confirms.
  double largest_claimed() const;
  /// The stated error, as far as AnswerTest allows it: that of contacts whose inertia is not given by blocks is that of
  /// the verdict.
  double aim_of(double error) const;

  /// Whether z is an answer, or leads to a proof that there is none. Writes that. Allocates once after each load.
  bool passes(const Vector& z, Answer& answer);
  /// Whether a proof is found that there is no answer. Writes it.
  bool disproves(Answer& answer);
  StickingContacts& loaded_sticking();

  const bool is_whole;  ///< see IslandTask()
  const Problem* problem = nullptr;
  Vector v;
  Index idle = 0;  ///< coordinates that no contact moves
  Methods* methods = nullptr;
  Order order;
  AutoLimits limits;
  std::array<Progress, kAutoMethods> progress{};
  AutoMethod answered_by = AutoMethod::kFrictionIpm;

 private:
  AnswerTest& loaded_test();

  AnswerTest test_;
  bool has_test_ = false;  ///< it holds the problem
  std::unique_ptr<StickingContacts> sticking_;
  bool has_sticking_ = false;
};

}  // namespace lcpbench
