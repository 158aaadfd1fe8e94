#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/problem.h"

namespace lcpbench {

/// A body in space as its block of the inertia reads: diag(mass I, inertia).
struct BodyBlock {
  double mass = 0;
  Eigen::Matrix3d inertia;
};

/// The bodies of an inertia that consists of one block diag(m I, 3 x 3) for each body, and of exact zeros elsewhere. Of
/// InverseInertia the blocks of the inverse, as they stand. Empty for any other inertia.
std::vector<BodyBlock> rigid_bodies(const Inertia& inertia);

/// Whether nothing couples coordinates as joints do: the inertia, or each block of BlockInertia, is that of free rigid
/// bodies, or it is given and diagonal. False for any other inertia, and for a bare LCP.
bool has_free_bodies(const Problem& problem);

/// Whether the inverse of the block is the likelier inertia: its principal moments obey the triangle inequality that
/// every mass distribution obeys, and the block's own do not. Where that decides nothing, arms tell: those of 0.3 to 3
/// radii of gyration are plausible. True if the arm is plausible for the inverse (of all, or of the moments alone) and
/// below 0.05 or above 20 radii for the block; false if it is plausible for the block. nullopt: neither holds, or a
/// principal moment is not positive.
/// @param arm  largest |r x d| of the body's contacts, d a normal or a friction direction [m]; 0 without contacts
std::optional<bool> reads_as_inverse(const BodyBlock& body, double arm);

/// Whether the body looks as if its lengths were in smaller units than metres: its mass is below 1e-2 kg/m^3 times its
/// cubed radius of gyration (the air in its place has 20), and its longest arm is 0.1 to 10 of these radii or it has no
/// contacts; or the arm is above 100 of these radii and above 10 m. @param body  its inertia, not the inverse
/// @param arm  as in reads_as_inverse()
bool lengths_look_too_large(const BodyBlock& body, double arm);

}  // namespace lcpbench
