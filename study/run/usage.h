#pragma once

namespace lcpbench {

/// Processor time of this process and of the programs that it started and that have ended [s].
double processor_seconds();

/// The most memory that this process and those of its programs that live had, each at its time, added up [bytes].
double memory_bytes();

}  // namespace lcpbench
