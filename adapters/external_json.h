#pragma once

#include <stdexcept>
#include <string>

#include "adapters/worker_protocol.h"
#include "core/problem.h"
#include "core/solver.h"

/// The texts that an external program and its worker exchange: one JSON object a line. docs/external.md documents them.
namespace lcpbench::external {

/// What is wrong with an answer, in one clause.
class BadAnswer : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

std::string start_message();

/// The problem as its problem file has it, on one line. Forms M for kind kLcp.
/// @pre the problem has what the kind needs: contacts for kContact, bodies for kScene.
std::string problem_message(const Problem& problem, ProblemKind kind, const Lcp& lcp);

std::string setup_message();
std::string solve_message(double time_limit_s);

/// Checks the answer to anything but "solve": an empty object. @throws BadAnswer.
void parse_acknowledgement(const std::string& text);

/// @throws BadAnswer unless the text is an object of known fields and types with vectors of the right lengths, finite
/// numbers only, and z where `solved` is claimed.
Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes);

/// Bytes that any answer worth reading fits in.
std::size_t longest_answer(const worker::AnswerSizes& sizes);

}  // namespace lcpbench::external
