#pragma once

#include "adapters/worker/message.h"
#include "core/problem.h"

/// A problem as the fields of a message.
namespace lcpbench::worker {

void write_problem(const Problem& problem, MessageWriter& writer);

/// Every shape is checked against those that it must agree with; the numbers may be anything. @throws BadMessage
Problem read_problem(MessageReader& reader);

}  // namespace lcpbench::worker
