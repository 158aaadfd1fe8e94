#pragma once

#include "core/contact_problem.h"
#include "core/scene.h"
#include "generators/hard/hard.h"
#include "generators/made/made.h"
#include "generators/paper/paper.h"
#include "generators/planted.h"
#include "generators/rigid/rigid.h"

// The samples of the generators as problems of core. Their numbers are the samples', unchanged.

namespace lcpbench {

ContactProblem to_contact_problem(const PaperSample& sample);  ///< with dense N and D
ContactProblem to_contact_problem(const MadeSample& sample);   ///< with blocks of inertia, sparse N and D, or all dense
/// Its LCP is that of the sample: v = q, N = I, G* = M.
ContactProblem to_contact_problem(const PlantedSample& sample);
Lcp to_lcp(const PlantedSample& sample);
/// @pre a bare LCP: its contact problem, where it has one, is that of *problem.contact.
Lcp to_lcp(const HardCase& problem);

/// The unused tangent of a frictionless contact keeps its default.
/// @pre sample.edges is 0 or 4: a scene has no other pyramid.
RigidScene to_scene(const RigidSample& sample);
/// With the pyramid of sample.edges edges, sparse N and D: up to 4 edges the problem of the scene, with more that of
/// friction_directions().
ContactProblem to_contact_problem(const RigidSample& sample);

}  // namespace lcpbench
