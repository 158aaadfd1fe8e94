#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace lcpbench {

/// Where results come from, so that someone else can get them again: version, commit, compiler, flags, processor,
/// instruction-set level, operating system, library versions, command line, start time. No host or user names.
/// @param command_line  the arguments, as typed
nlohmann::ordered_json provenance(const std::string& command_line, const std::string& started);

/// Now, UTC, "2026-01-31T12:00:00Z".
std::string utc_now();

/// Processor time of this process and of the programs that it started and that have ended [s].
double processor_seconds();

/// The sum of the peak memory of this process and of its living child processes, whose peaks need not coincide [bytes].
double memory_bytes();

}  // namespace lcpbench
