#pragma once

#include <optional>

#include "study/stability/transformations.h"

namespace lcpbench {

/// Units, permutation, duplicates, neighbouring doubles: what a scene can say of itself. Friction directions are turned
/// and columns scaled only in a contact problem.
bool is_of_scenes(TransformationKind kind);

/// See draw_transformation. @pre is_of_scenes(kind)
std::optional<Transformation> draw_for_scene(TransformationKind kind, DrawSequence& draws, const RigidScene& scene);

}  // namespace lcpbench
