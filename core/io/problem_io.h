#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/problem.h"

namespace lcpbench {

// docs/reference/problem-file.md describes the fields and their units.

/// Reads a problem: a file in JSON ("lcpbench-problem", kinds lcp, contact, scene), Siconos dense LCP or MLCP text, a
/// Matrix Market pair (either of X.M.mtx and X.q.mtx names both), or one step of captured contacts (X.scenes#STEP). The
/// format is told from the name and the first bytes. Numbers are read correctly rounded. What is read and written again
/// is bit-identical, but for offsets and compliances that are all zero: they are left out.
/// @throws InputError, one line: file, field, cause. Sizes are bounded before memory is asked for.
Problem read_problem(const std::filesystem::path& file);

/// The same from text in memory, with the same errors; `origin` stands for the file in them.
Problem parse_problem_json(std::string_view text, const std::string& origin);
/// The same of a parsed document, or of a part of one.
Problem problem_of_json(const nlohmann::ordered_json& json, const std::string& origin);
Problem parse_siconos_lcp(std::string_view text, const std::string& origin);
Problem parse_matrix_market(std::string_view M_text, std::string_view q_text, const std::string& origin);

/// The problem file's text: JSON with one matrix row a line, ending in a newline. A function of the problem alone.
/// A contact problem that is stored sparse is written sparse where dense matrices would take more than 2^16 numbers.
/// @throws InputError for a problem that read_problem() would refuse
std::string problem_json(const Problem& problem);

/// The same object, with the same errors, in one line without its end, for files that hold many: what is stored sparse
/// is written sparse, unless `dense`.
std::string problem_json_line(const Problem& problem, bool dense = false);

/// Writes problem_json to a file, whole or not at all (WholeFile). @throws InputError when it cannot.
void write_problem(const Problem& problem, const std::filesystem::path& file);

/// 128-bit hash of the problem's data (not its name), 32 hexadecimal digits: the same where kind, shapes and every
/// number agree bit for bit, however matrices are stored (dense, sparse, by blocks). What has no effect is no data: mu
/// and the scene's tangent of a contact without friction, and offsets and compliances of zero. Independent of machine
/// and byte order.
std::string problem_hash(const Problem& problem);

}  // namespace lcpbench
