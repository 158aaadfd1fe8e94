#pragma once

#include "core/contact_problem.h"
#include "core/scene.h"
#include "generators/hard/hard.h"
#include "generators/made/made.h"
#include "generators/paper/paper.h"
#include "generators/planted.h"
#include "generators/rigid/rigid.h"

namespace lcpbench {

/// The sample's numbers, unchanged, as a contact problem with dense N and D.
ContactProblem to_contact_problem(const PaperSample& sample);

/// The sample's numbers, unchanged, as a scene. The unused tangent of a frictionless contact keeps its default.
/// @pre sample.edges is 0 or 4: a scene has no other pyramid.
RigidScene to_scene(const RigidSample& sample);

/// The sample as a contact problem with the pyramid of sample.edges edges, sparse N and D. Up to 4 edges it is that of
/// the scene.
ContactProblem to_contact_problem(const RigidSample& sample);

/// The sample's numbers, unchanged, as a contact problem with blocks of inertia, sparse N and D.
ContactProblem to_contact_problem(const MadeSample& sample);

/// The sample's numbers, unchanged, as a contact problem whose LCP they are: v = q, N = I, G* = M.
ContactProblem to_contact_problem(const PlantedSample& sample);

/// The sample's (q, M), unchanged.
Lcp to_lcp(const PlantedSample& sample);

/// The case's (q, M), unchanged. @pre a bare LCP: its contact problem, where it has one, is that of *problem.contact.
Lcp to_lcp(const HardCase& problem);

}  // namespace lcpbench
