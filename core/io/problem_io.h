#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "core/problem.h"

namespace lcpbench {

/// Reads a problem file: JSON ("lcpbench-problem", kinds lcp, contact, scene), Siconos dense LCP text, or a Matrix
/// Market pair (either of X.M.mtx and X.q.mtx names both). The format is told from the name and the first bytes.
/// Numbers are read correctly rounded; what is read and written again is bit-identical.
/// @throws InputError, one line: file, field, cause. Sizes are bounded before memory is asked for.
Problem read_problem(const std::filesystem::path& file);

/// The same from text in memory; `origin` stands for the file in errors.
Problem parse_problem_json(std::string_view text, const std::string& origin);
/// The same of a parsed document, or of a part of one.
Problem problem_of_json(const nlohmann::ordered_json& json, const std::string& origin);
Problem parse_siconos_lcp(std::string_view text, const std::string& origin);
Problem parse_matrix_market(std::string_view M_text, std::string_view q_text, const std::string& origin);

/// The problem file's text: JSON with one matrix row a line, ending in a newline. A function of the problem alone.
/// A contact problem that is stored sparse is written sparse where dense matrices would take more than 2^16 numbers.
std::string problem_json(const Problem& problem);

/// The same object in one line without its end, for files that hold many: what is stored sparse is written sparse,
/// unless `dense`.
std::string problem_json_line(const Problem& problem, bool dense = false);

/// Writes problem_json to a file, whole or not at all (WholeFile). @throws InputError when it cannot.
void write_problem(const Problem& problem, const std::filesystem::path& file);

/// 128-bit hash of the problem's data (not its name), 32 hexadecimal digits: equal exactly when every number is equal
/// bit for bit and kind and shapes agree. Independent of machine and byte order.
std::string problem_hash(const Problem& problem);

}  // namespace lcpbench
