#pragma once

#include "core/contact_problem.h"
#include "core/scene.h"
#include "generators/paper.h"
#include "generators/planted.h"
#include "generators/rigid.h"

namespace lcpbench {

/// The sample's numbers, unchanged, as a contact problem with dense N and D.
ContactProblem to_contact_problem(const PaperSample& sample);

/// The sample's numbers, unchanged, as a scene. Every contact is frictionless; its unused tangent keeps the default.
RigidScene to_scene(const RigidSample& sample);

/// The sample's numbers, unchanged, as a contact problem whose LCP they are: v = q, N = I, G* = M.
ContactProblem to_contact_problem(const PlantedSample& sample);

/// The sample's (q, M), unchanged.
Lcp to_lcp(const PlantedSample& sample);

}  // namespace lcpbench
