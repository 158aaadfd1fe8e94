#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "adapters/worker/worker_protocol.h"
#include "core/problem.h"
#include "core/solver.h"

/// The texts that an external program and its worker exchange: one JSON object a line. docs/reference/external.md
/// documents them.
namespace lcpbench::external {

/// The fault of an answer, in one clause.
class BadAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The newest version of the protocol. Its programs repeat the number of each question; those of version 1 need not.
inline constexpr int kVersion = 2;

/// A problem in other units: M (of a bare LCP) times 2^matrix; q, v or the velocities of the bodies times 2^vector.
/// Both scalings are exact, and so are those of the answer.
struct Multiple {
  int matrix = 0;
  int vector = 0;

  bool is_problem() const { return matrix == 0 && vector == 0; }
  double of_matrix() const;
  double of_vector() const;  ///< also that of the velocity after the impact
  double of_z() const;
};

/// How many different multiples multiple_for() has.
inline constexpr int kMultiples = 16;

/// Multiple number `index` of [0, kMultiples) for a program that is given this kind of problem. No two of one kind have
/// the same q or v, nor the same M; none has the z of the problem itself or of the multiple before it.
Multiple multiple_for(ProblemKind kind, int index);

/// False when a number of the problem would overflow, or lose bits below the smallest normal number.
bool is_exact(const Multiple& multiple, const Problem& problem, ProblemKind kind, const Lcp& lcp);

/// Why `again`, the answer to the multiple of a problem, is not the multiple of `first`, its answer, in one clause; ""
/// when it is: the claims are equal, and so are z and velocity, scaled, but for 1e-6 of their largest entry.
std::string difference(const Answer& first, const Answer& again, const Multiple& multiple);

std::string start_message(int version);

/// The multiple of the problem as its problem file has it, on one line.
/// @param lcp  (q, M) for kind kLcp; not used for the others
/// @pre the problem has what the kind needs: contacts for kContact, bodies for kScene.
std::string problem_message(const Problem& problem, ProblemKind kind, const Lcp& lcp, const Multiple& multiple = {});

std::string setup_message();
std::string solve_message(double time_limit_s);

/// A message with the number of the question put in.
std::string numbered(const std::string& message, std::uint64_t sequence);

/// The number that an answer has to repeat.
struct Expected {
  std::uint64_t sequence = 0;
  bool required = true;  ///< false: the answer may have no number, but no other one
};

/// Reads the answer to "start". @returns the version of the protocol that the program speaks: 2 when it repeats the
/// number. @throws BadAnswer.
int parse_start(const std::string& text, std::uint64_t sequence);

/// Checks the answer to "problem" and "setup": an object with at most the number. @throws BadAnswer.
void parse_acknowledgement(const std::string& text, const Expected& expected);

/// @throws BadAnswer unless the text is an object of known fields and types, none of them twice, with the expected
/// number, with vectors of the right lengths, finite numbers only, and z where `solved` is claimed.
Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes, const Expected& expected);

/// Bytes that any answer worth reading fits in.
std::size_t longest_answer(const worker::AnswerSizes& sizes);

}  // namespace lcpbench::external
