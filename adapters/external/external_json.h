#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/worker/worker_protocol.h"
#include "core/problem.h"
#include "core/solver.h"

/// The command of an external program, and the texts that it and its worker exchange: one JSON object a line.
/// docs/reference/external.md documents them. What is no such text throws worker::BadMessage.
namespace lcpbench::external {

/// Splits a command into words at spaces; single or double quotes keep spaces inside a word. Nothing is expanded.
/// @throws InputError on an empty command or an open quote.
std::vector<std::string> command_words(std::string_view command);

/// The size of the line that a text begins with, its end included; 0 while it has no end.
inline std::size_t line_size(std::string_view text) { return text.find('\n') + 1; }

/// The newest version of the protocol. Its programs repeat the number of each question; those of version 1 need not.
inline constexpr int kVersion = 2;

std::string start_message(int version);

/// The problem as its problem file has it, all matrices dense, on one line. @throws InputError where it has no file
std::string problem_message(const Problem& problem);

std::string setup_message();
/// @param start a guess at z, finite; nullptr: there is none
std::string solve_message(double time_limit_s, const Vector* start);

/// A message with the number of the question put in.
std::string numbered(const std::string& message, std::uint64_t sequence);

/// The number that an answer has to repeat.
struct Expected {
  std::uint64_t sequence = 0;
  bool required = true;  ///< false: the answer may have no number, but no other one
};

/// Reads the answer to "start". @returns the version of the protocol that the program speaks: 2 when it repeats the
/// number. @throws BadMessage.
int parse_start(const std::string& text, std::uint64_t sequence);

/// Checks the answer to "problem" and "setup": an object with at most the number. @throws BadMessage.
void parse_acknowledgement(const std::string& text, const Expected& expected);

/// @throws BadMessage unless the text is an object of known fields and types, none of them twice, with the expected
/// number, with vectors of the right lengths, finite numbers only, and z where `solved` is claimed.
Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes, const Expected& expected);

/// Bytes that any answer worth reading fits in.
std::size_t longest_answer(const worker::AnswerSizes& sizes);

}  // namespace lcpbench::external
