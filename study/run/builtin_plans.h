#pragma once

#include <string_view>
#include <vector>

namespace lcpbench {

struct BuiltinPlan {
  std::string_view name;
  std::string_view text;  ///< JSON, equal in form to a user's plan file
};

/// The files of study/run/plans/ that study/CMakeLists.txt names, in that order.
extern const std::vector<BuiltinPlan> kBuiltinPlans;

}  // namespace lcpbench
