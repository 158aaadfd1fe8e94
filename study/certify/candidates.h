#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/solver.h"
#include "study/certify/exact_problem.h"

namespace lcpbench::exact {

/// Float solvers, made when first asked for and kept: where exact arithmetic gets its guesses from.
class Candidates {
 public:
  /// The solver's answer, whatever it claims; valid until the same solver is asked again.
  /// @param spec  a native solver: "contact_lemke{precision=quad}"
  const Answer& answer(const std::string& spec, const Problem& problem, double time_limit_s);

 private:
  struct Kept {
    std::unique_ptr<Solver> solver;
    Answer answer;
  };
  std::map<std::string, Kept> kept_;
};

/// What an answer says of the complementary cone of a solution. w_i is clearly positive above a part of the terms of
/// its row, and z_i where its term in some row is above that part of them.
struct Guess {
  std::vector<Index> basis;    ///< z_i is clearly positive and w_i is not
  std::vector<Index> unclear;  ///< both z_i and w_i are clearly positive, or neither is
  std::vector<Index> tight;    ///< w_i is zero to rounding, and z_i is not positive
};
Guess classified(const Lcp& lcp, const Vector& z);

/// The i with z_i > 0, the largest first; none where z is not n finite numbers.
std::vector<Index> support(const Vector& z, Index n);

/// The point at which z is zero but for `basis`, and w is zero there: one exact solve. Where these equations depend on
/// each other, w is zero on `more_rows` too, and of p and `basis`, the most important first, as many entries as the
/// equations determine are found; the rest stay zero. Signs are not looked at. @throws TimePassed
Point point_on(
    const ExactSystem& system, const std::vector<Index>& basis, const Deadline& deadline,
    const std::function<std::vector<Index>()>& more_rows = [] { return std::vector<Index>(); });

/// The next basis to try after a point that is no solution: without the z_i < 0, with the w_i < 0.
/// [Kostreva, block principal pivoting, 1978] @param values  system.values(point)
std::vector<Index> exchanged_basis(const ExactSystem& system, const Point& point, const IntegerMatrix& values);

/// Where other solutions are looked for: for each combination of what the contacts may do (open, stick, slide along a
/// direction), the i whose z_i may be positive. None when there would be more than `limit`.
std::vector<std::vector<Index>> combinations(const ContactProblem& contact, std::size_t limit);

/// An LCP with its unknowns backwards, from another one on for each number, and from number 1 on in other units, whole
/// powers of two up to 2^6: what changes the paths of pivoting methods, and which of several solutions they end at.
struct Variant {
  Variant(const Lcp& original, Index number);
  /// z of the original problem.
  Vector of_original(const Vector& z) const;

  std::vector<Index> order;  ///< unknown i is unknown order[i] of the original
  Vector unit;
  Lcp lcp;
};

}  // namespace lcpbench::exact
