#pragma once

#include <stdexcept>
#include <string>

namespace lcpbench {

/// Input that a user can mend: a file, an option, a name.
///
/// `what()` is one line that names where (file or option), which field, and the cause. The command line prints it as it
/// is and exits with code 2. Everything else that is thrown is a defect of ours.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace lcpbench
