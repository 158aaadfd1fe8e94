#pragma once

#include <memory>
#include <string>

#include "tests/attack/subjects.h"

namespace lcpbench::attack {

/// "forged-answer", "forged-velocity".
std::vector<std::string> forger_names();

/// A subject that is no solver. It moves a right answer away, to both sides of the bound of the verdict and up to a
/// factor of two from it, and compares what the evaluation says with the exact judge. "forged-answer" moves z and
/// judges by pyramid, cone or convex model in turn; "forged-velocity" moves the returned velocity of contacts.
/// nullptr: not one of these names.
std::unique_ptr<Subject> make_forger(const std::string& name);

}  // namespace lcpbench::attack
