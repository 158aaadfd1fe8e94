#pragma once

#include <cstdint>
#include <string>

#include "study/run/study.h"

namespace lcpbench {

/// `run --list-shards N`: prints what the shards will cost, and which of them are not finished.
/// @param stores  where {} stands for the shard's number; "": none is looked at
/// @param jobs    threads of a shard
/// @param every   in text: a line for each shard
void list_shards(const Study& study, std::int64_t shards, const std::string& stores, int jobs, bool json, bool every);

}  // namespace lcpbench
