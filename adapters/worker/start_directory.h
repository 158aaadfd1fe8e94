#pragma once

#include <filesystem>

namespace lcpbench {

/// The folder that lcpbench ran in when it started this worker, which itself runs elsewhere: what relative names that
/// the user gave are relative to. Empty where it could not be told.
const std::filesystem::path& start_directory();

/// How long a program that this worker starts may take for its first answer [s].
double program_start_s();

}  // namespace lcpbench
