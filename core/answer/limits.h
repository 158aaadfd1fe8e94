#pragma once

// The bounds of the verdict: docs/explanation/verdicts.md.

namespace lcpbench {

/// On the relative velocity residual rho of an answer to contacts.
inline constexpr double kSolvedVelocityResidual = 1e-4;
/// On the error of a velocity that an answer to contacts comes with.
inline constexpr double kSolvedReturnedVelocity = 1e-4;
/// On the backward error of an answer to a bare LCP.
inline constexpr double kSolvedBackwardError = 1e-6;

}  // namespace lcpbench
