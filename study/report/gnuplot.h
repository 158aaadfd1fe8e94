#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace lcpbench::report {

/// gnuplot is missing, failed, or drew nothing; what() says which, in one line.
class FigureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Runs a gnuplot script, without the user's start-up file, in a process of its own.
/// @returns what the script writes to its standard output.  @throws FigureError
std::string run_gnuplot(const std::string& script);

/// A string literal of gnuplot, without interpretation of its content; control characters become spaces.
std::string gnuplot_quote(std::string_view text);

}  // namespace lcpbench::report
