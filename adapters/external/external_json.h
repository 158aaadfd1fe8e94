#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "adapters/worker/worker_protocol.h"
#include "core/problem.h"
#include "core/solver.h"

/// The command of an external program, and the messages that the program and its worker exchange: each is one JSON
/// object on one line (docs/reference/external.md). Here they are without the line end. Functions that read an answer
/// throw worker::BadMessage for any other text.
namespace lcpbench::external {

/// Splits a command into words at spaces; single or double quotes keep spaces inside a word. Nothing is expanded, and
/// backslashes are ordinary characters. @throws InputError when the first word is missing or empty, or a quote is open.
std::vector<std::string> command_words(std::string_view command);

/// The size of the first line of a text, its end included; 0 while the line has no end.
inline std::size_t line_size(std::string_view text) { return text.find('\n') + 1; }

/// The newest version of the protocol. A program of version 2 repeats the number of each question; one of version 1
/// need not.
inline constexpr int kVersion = 2;

std::string start_message(int version);

/// The problem as in its problem file, with dense N, D and G (factors remain factors).
/// @throws InputError for a problem that read_problem() would refuse
std::string problem_message(const Problem& problem);

std::string setup_message();
/// @param time_limit_s  infinity is written as null
/// @param start  a guess at z, finite; nullptr: there is none
std::string solve_message(double time_limit_s, const Vector* start);

/// The message with the number of the question as its first field.
std::string numbered(const std::string& message, std::uint64_t sequence);

/// The number that an answer has to repeat.
struct Expected {
  std::uint64_t sequence = 0;
  bool required = true;  ///< false: the answer may leave the number out, but may not have another one
};

/// Reads the answer to "start". @returns the version of the protocol that the program speaks: 2 when it repeats the
/// number. @throws BadMessage.
int parse_start(const std::string& text, std::uint64_t sequence);

/// Checks the answer to "problem" or "setup": an object with no field but the number. @throws BadMessage.
void parse_acknowledgement(const std::string& text, const Expected& expected);

/// Reads the answer to "solve". @throws BadMessage unless the text is an object of known fields and types, none of them
/// twice, with the expected number, a claim other than `crashed`, vectors of the right lengths, finite numbers only,
/// counts from 0 to 2^53 - 1, and z where the claim is `solved`.
Answer parse_answer(const std::string& text, const worker::AnswerSizes& sizes, const Expected& expected);

/// A bound on the bytes of an answer: 64 for each number and 64 KiB besides. A longer line is refused.
std::size_t longest_answer(const worker::AnswerSizes& sizes);

}  // namespace lcpbench::external
