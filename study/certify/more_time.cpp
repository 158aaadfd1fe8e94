#include "study/certify/more_time.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace lcpbench::exact {
namespace {

/// From clear to doubtful: the parts below which an entry may be zero.
constexpr double kClearParts[] = {1e-12, 1e-9, 1e-6, 1e-3};
/// Rows to settle exactly in the first round; each round takes twice as many.
constexpr double kFirstUnclear = 128;
constexpr double kFirstWork = 4e8;
constexpr double kWorkARefusal = 1e7;

}  // namespace

BranchingLimits longer_branching(Index round, const Deadline& deadline) {
  const double work = kFirstWork * std::pow(4.0, static_cast<double>(round));
  return {.deadline = deadline,
          .most_work = work,
          .most_work_without_proof = work,
          .most_refused = static_cast<int>(std::min(work / kWorkARefusal, 1e9))};
}

void GuessedCones::ask(const Deadline& deadline) {
  for (const std::string& solver : solvers_) {
    if (deadline.passed()) return;
    const Answer& answer = candidates_.answer(solver, problem_, deadline.left_s() / kTurns);
    if (answer.z.size() != problem_.size() || !answer.z.allFinite()) continue;
    const bool known =
        std::any_of(answers_.begin(), answers_.end(), [&](const Answered& a) { return a.z == answer.z; });
    if (!known) answers_.push_back({solver, answer.z});
  }
}

std::optional<GuessedCones::Found> GuessedCones::next_point(const ExactSystem& system, Index round,
                                                            const Deadline& deadline,
                                                            const std::function<bool(const ExactPoint&)>& accepts) {
  if (round == 0) ask(deadline);
  const double most = std::min(kFirstUnclear * std::pow(2.0, static_cast<double>(round)), 1e9);
  const double fewer = round == 0 ? -1 : most / 2;
  for (const double clear : kClearParts) {
    for (const Answered& answered : answers_) {
      if (deadline.passed()) return std::nullopt;
      const Guess guess = classified(problem_, answered.z, clear);
      const auto unclear = static_cast<double>(guess.unclear.size());
      if (unclear > most || unclear <= fewer) continue;
      const Deadline turn = deadline.within(deadline.left_s() / kTurns);
      try {
        if (std::optional<ExactPoint> point = settled_near(system, guess, turn, accepts)) {
          return Found{std::move(*point), answered.solver};
        }
      } catch (const TimePassed&) {
        continue;
      }
    }
  }
  return std::nullopt;
}

}  // namespace lcpbench::exact
