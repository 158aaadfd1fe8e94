#pragma once

#include <cstdint>

#include "core/settings.h"

namespace lcpbench {

struct AutoSettings {
  double error = 0;
  bool islands = true;
  bool leave_out = true;
  std::int64_t leave_out_from = 64;
  std::int64_t sparse_from = 100;
  std::int64_t sparse_friction_from = 1200;
  std::int64_t max_pivots = 0;
  std::int64_t threads = 1;

  void visit(auto&& field) {
    constexpr std::int64_t kMost = std::int64_t{1} << 40;
    field("error", error, RealRange{.min = 0, .max = 0.1},
          "velocity residual of every island, relative to its max|q|, at which iterative methods may stop; 0: each "
          "method's own");
    field("islands", islands, "solve parts that no inertia and no contact couple one by one");
    field("leave_out", leave_out, "leave contacts out that cannot be pressed, and test that on the answer");
    field("leave_out_from", leave_out_from, IntegerRange{.min = 1, .max = kMost},
          "contacts of an island of bodies from which some may be left out; smaller ones are solved with all or none");
    field("sparse_from", sparse_from, IntegerRange{.min = 1, .max = kMost},
          "contacts of a frictionless island of bodies from which the interior-point method takes over");
    field("sparse_friction_from", sparse_friction_from, IntegerRange{.min = 1, .max = kMost},
          "unknowns of a frictional island of bodies from which the sparse method is tried before contact_lemke");
    field("max_pivots", max_pivots, IntegerRange{.min = 0, .max = kMost},
          "limit on pivots and changes of active sets over all islands together; 0: those of the methods");
    field("threads", threads, IntegerRange{.min = 1, .max = 256},
          "islands solved at a time, each on a thread; the answer is the same for any number");
  }
};

}  // namespace lcpbench
