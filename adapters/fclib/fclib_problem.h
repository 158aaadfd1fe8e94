#pragma once

#include <string>

#include "core/problem.h"

namespace lcpbench {

/// Reads a frictional contact problem from an FCLIB file (HDF5), global or local. Friction discs become pyramids of 4
/// edges along the file's two tangents; in the plane contacts have 2 edges. Stored solutions and guesses are not read.
///
///   global:  M v = H r + f,  u = H'v + w     G = M,  v = M^-1 f,  N and D from columns of H,  b = w_N,  offset_t = w_T
///   local:   u = W r + q                     G* = W,  v = q,  N and D from columns of the identity
///
/// @param symmetrize  whether M or W may differ from its transpose by more than 1e-10 of its largest entry. The mean
///        of the two is taken in any case.
/// @throws InputError naming the file and the dataset or field: damaged or asymmetric data, M not positive definite, W
///         not semidefinite, too large a dense matrix, or what is outside the model (equality constraints, rolling
///         friction)
Problem read_fclib(const std::string& file, bool symmetrize);

}  // namespace lcpbench
