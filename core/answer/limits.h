#pragma once

// The bounds of the verdict: docs/explanation/verdicts.md.

namespace lcpbench {

/// On the relative velocity residual rho of an answer to contacts.
inline constexpr double kSolvedVelocityResidual = 1e-4;
/// On the error of a velocity that an answer to contacts comes with.
inline constexpr double kSolvedReturnedVelocity = 1e-4;
/// On the error of 113 bits in a residual, relative to its scale: above it the inertia counts as unresolved.
inline constexpr double kResolvedError = 1e-5;
/// On the error of an answer to a bare or mixed LCP, and on the margin of a proof that a bare LCP has no solution.
inline constexpr double kSolvedBackwardError = 1e-6;

}  // namespace lcpbench
