#pragma once

#include <filesystem>

namespace lcpbench {

/// The folder that lcpbench ran in when it started this worker, which itself runs elsewhere: what relative names that
/// the user gave are relative to. Empty where it could not be told.
const std::filesystem::path& start_directory();

}  // namespace lcpbench
