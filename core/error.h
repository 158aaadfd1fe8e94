#pragma once

#include <stdexcept>
#include <string>

namespace lcpbench {

/// An error in the input that a user can correct: a file, an option, a name.
///
/// `what()` is one line that names where (file or option), which field, and the cause. The command line prints it as it
/// is and exits with code 2. Every other exception is a defect of lcpbench.
///
/// Messages repeat words of the input, which may hold anything: control characters become '?', so that the message
/// stays one line and sends nothing to a terminal.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(without_control_characters(message)) {}

 private:
  static std::string without_control_characters(std::string text) {
    for (char& c : text) {
      const auto byte = static_cast<unsigned char>(c);
      if (byte < 0x20 || byte == 0x7f) c = '?';
    }
    return text;
  }
};

}  // namespace lcpbench
