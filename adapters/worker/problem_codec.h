#pragma once

#include "adapters/worker/byte_stream.h"
#include "core/problem.h"

/// A problem as the fields of a message.
namespace lcpbench::worker {

void write_problem(const Problem& problem, ByteWriter& writer);

/// Every shape is checked against those that it must agree with; the numbers may be anything. @returns an empty problem
/// when the reader has failed.
Problem read_problem(ByteReader& reader);

}  // namespace lcpbench::worker
