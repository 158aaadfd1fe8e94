#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/solver.h"

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

/// What an answer says of the complementary cone of a solution.
struct Guess {
  std::vector<Index> basis;    ///< w_i = 0 and z_i > 0, clearly
  std::vector<Index> unclear;  ///< neither z_i nor w_i is clearly zero while the other is not
};

/// @param clear  what is above this part of the terms that it meets in the rows of q + M z is not zero
Guess classified(const Problem& problem, const Vector& z, double clear);

/// The i with z_i > 0, the largest first; none where z is not n finite numbers.
std::vector<Index> support(const Vector& z, Index n);

/// The rows that z leaves at zero to rounding and that are not in its support.
std::vector<Index> tight_rows(const Problem& problem, const Vector& z);

}  // namespace lcpbench::exact
