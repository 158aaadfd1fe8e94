#pragma once

#include <string>

#include "core/problem.h"

namespace lcpbench {

/// Reads a frictional contact problem of the FCLIB format (HDF5), global or local. Friction discs become pyramids along
/// the file's two tangents; a problem in the plane has its two directions. Stored solutions and guesses are not read.
///
///   global:  M v = H r + f,  u = H'v + w     G = M,  v = M^-1 f,  N and D are the columns of H,  b = w_N
///   local:   u = W r + q                     G* = W,  v = q,  N and D pick the entries of r
///
/// @param symmetrize  take (W + W') / 2 of a matrix that is not symmetric, whatever the difference
/// @throws InputError naming the file, the dataset, and what is outside the model: equality constraints, rolling
///         friction, tangential w, matrices that are not symmetric
Problem read_fclib(const std::string& file, bool symmetrize);

}  // namespace lcpbench
