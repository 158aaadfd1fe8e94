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
  std::vector<Index> basis;    ///< z_i is clearly positive and w_i is not
  std::vector<Index> unclear;  ///< both z_i and w_i are clearly positive, or neither is
};

/// @param clear  w_i is clearly positive above this part of |q_i| + sum_j |M_ij z_j|; z_i, where some |M_ji| z_i is
///               above this part of that sum in row j
Guess classified(const Problem& problem, const Vector& z, double clear);

/// The i with z_i > 0, the largest first; none where z is not n finite numbers.
std::vector<Index> support(const Vector& z, Index n);

/// The rows that z leaves at zero to rounding and that are not in its support.
std::vector<Index> tight_rows(const Problem& problem, const Vector& z);

}  // namespace lcpbench::exact
