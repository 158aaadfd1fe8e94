#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lcpbench {

/// Options in the order they were written: key = value.
using Options = std::vector<std::pair<std::string, std::string>>;

/// `name` or `name{key=value,key=value}`: the notation for solvers and problem sets everywhere.
/// A value may be empty, or itself a spec with braces: `regularized{solver=lemke{engine=kernel}}`.
struct Spec {
  std::string name;
  Options options;

  /// The text that parse_spec() reads back as this spec, if that is where the spec came from: nothing is quoted.
  std::string text() const;
};

/// White space around names, keys and values is dropped. @throws InputError on an empty name or one with '}', '=' or
/// ',', unbalanced braces, a missing '=', an empty or repeated key or one with braces, text after the closing brace,
/// more than 256 options, or more than 16 nested braces inside of the outer ones.
Spec parse_spec(std::string_view text);

/// Splits at the commas outside of all braces, and trims the parts: "a{b,c}, d" gives "a{b,c}" and "d". Parts may be
/// empty; an empty text is one empty part. @throws InputError on unbalanced braces, or more than 16 nested ones.
std::vector<std::string> split_top_level(std::string_view text);

}  // namespace lcpbench
