#pragma once

#include "core/settings.h"

namespace lcpbench {

struct AutoSettings {
  double error = 0;
  bool islands = true;

  void visit(auto&& field) {
    field("error", error, RealRange{.min = 0, .max = 0.1},
          "velocity residual of every island, relative to its max|q|, at which iterative methods may stop; 0: each "
          "method's own");
    field("islands", islands, "solve parts that no inertia and no contact couple one by one");
  }
};

}  // namespace lcpbench
