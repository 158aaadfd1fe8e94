#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lcpbench {

/// Options in the order they were written: key = value.
using Options = std::vector<std::pair<std::string, std::string>>;

/// `name` or `name{key=value,key=value}`: how solvers and problem sets are written everywhere.
/// A value may itself hold a spec in braces: `regularized{solver=lemke{engine=kernel}}`.
struct Spec {
  std::string name;
  Options options;

  /// The text that parses back to this spec.
  std::string text() const;
};

/// @throws InputError on an empty name, unbalanced braces, a missing '=', an empty or repeated key, or text after '}'.
Spec parse_spec(std::string_view text);

/// Splits at top-level commas: those outside every brace. "a{b,c},d" gives "a{b,c}" and "d".
/// @throws InputError on unbalanced braces.
std::vector<std::string> split_top_level(std::string_view text);

}  // namespace lcpbench
