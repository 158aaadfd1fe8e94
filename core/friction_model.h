#pragma once

#include <string_view>

namespace lcpbench {

/// The friction law that the impulses of a solver obey. Problems have the pyramid; without friction all three agree.
enum class FrictionModel {
  kPyramid,
  kCone,    ///< the round Coulomb cone
  kConvex,  ///< the round cone in Anitescu's convex relaxation, in which what slides lifts off
};

/// "pyramid", "cone", "convex".
constexpr const char* to_string(FrictionModel model) {
  switch (model) {
    case FrictionModel::kPyramid: break;
    case FrictionModel::kCone: return "cone";
    case FrictionModel::kConvex: return "convex";
  }
  return "pyramid";
}

/// The inverse of to_string; the pyramid for any other word.
constexpr FrictionModel friction_model_of(std::string_view text) {
  for (const FrictionModel model : {FrictionModel::kCone, FrictionModel::kConvex}) {
    if (text == to_string(model)) return model;
  }
  return FrictionModel::kPyramid;
}

}  // namespace lcpbench
