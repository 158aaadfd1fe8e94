#pragma once

#include <string>

#include "core/io/problem_io.h"
#include "tests/fuzz/harness.h"

namespace lcpbench::fuzz {

/// Whatever was parsed can be written, and what was written comes back with the same bits. Large dense problems are
/// left out: a few bytes of coordinate text can stand for millions of zeros.
inline void require_round_trip(const Problem& problem) {
  if (problem.size() > 200) return;
  const std::string written = problem_json(problem);
  const Problem again = parse_problem_json(written, "written");
  require(problem_json(again) == written, "written, read and written again is the same text");
  require(problem_hash(again) == problem_hash(problem), "written and read has the same hash");
  require(again.name() == problem.name(), "written and read has the same name");
}

}  // namespace lcpbench::fuzz
