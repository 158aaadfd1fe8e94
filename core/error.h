#pragma once

#include <stdexcept>
#include <string>

#include "core/utf8.h"

namespace lcpbench {

/// An error in the input that a user can correct: a file, an option, a name.
///
/// `what()` is one line that names where (file or option), which field, and the cause. The command line prints it as it
/// is and exits with code 2. Every other exception is a defect of lcpbench.
///
/// Messages repeat words of the input, which may hold anything: they are printable(), so that one stays one line and
/// sends nothing to a terminal.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(printable(message)) {}
};

}  // namespace lcpbench
