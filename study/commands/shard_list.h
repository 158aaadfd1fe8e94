#pragma once

#include <cstdint>
#include <string>

#include "study/run/study.h"

namespace lcpbench {

struct ShardListOptions {
  std::int64_t shards = 1;
  std::string stores;  ///< where {} stands for the shard's number; "": none is looked at
  int jobs = 1;        ///< threads of a shard
  bool json = false;
  bool every = false;  ///< in text: a line for each shard
};

/// `run --list-shards N`: prints what the shards will cost, and which of them are not finished. @returns the exit code
int list_shards(const Study& study, const ShardListOptions& options);

}  // namespace lcpbench
