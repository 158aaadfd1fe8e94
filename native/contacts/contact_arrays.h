#pragma once

#include <cstddef>

// A contact problem as plain arrays, which cross the border between solvers and their engines
// (kernels/engine_border.h).

namespace lcpbench::contact_lemke {

/// Blocks of the inertia respond to impulses in groups of at least so many coordinates. Up to so many in all, zeros of
/// J are multiplied like other entries: to look for them would take as long.
inline constexpr std::ptrdiff_t kLeastRange = 32;

/// How the inertia is given. X, alpha and Ginv are read during load() only, the blocks later, too.
struct InertiaInput {
  std::ptrdiff_t blocks = 0;                ///< G = diag(blocks); 0 when it is given otherwise
  const std::ptrdiff_t* offsets = nullptr;  ///< blocks + 1
  const double* const* G = nullptr;         ///< each block by columns
  std::ptrdiff_t factors = -1;              ///< G = X diag(alpha) X' when >= 0
  const double* X = nullptr;                ///< ngc x factors by columns
  const double* alpha = nullptr;
  const double* Ginv = nullptr;  ///< G* itself, ngc x ngc, or nullptr
};

/// A contact problem. v, N, D, friction_begin, mu and the blocks of the inertia must stay valid until the next load().
///
/// An offset b of the normal rows comes as one coordinate more, the last: no impulse moves it, so that the inertia has
/// no row for it, nor have velocities that are returned. With its speed s in v and b / s in N, velocities that N'v
/// gives have b in them.
struct Input {
  std::ptrdiff_t ngc = 0;
  bool has_offset = false;
  std::ptrdiff_t nc = 0;
  const double* v = nullptr;                       ///< ngc
  const double* N = nullptr;                       ///< ngc x nc by columns
  const double* D = nullptr;                       ///< ngc x friction_begin[nc] by columns
  const std::ptrdiff_t* friction_begin = nullptr;  ///< nc + 1
  const double* mu = nullptr;                      ///< nc
  // Of soft contacts: all of these, or none where no contact is soft.
  const double* compliance_n = nullptr;  ///< nc
  const double* compliance_t = nullptr;  ///< nc
  const double* offset_t = nullptr;      ///< 2 nc
  const double* tangents = nullptr;      ///< 2 x friction_begin[nc] by columns: D by the two tangents of its contact
  /// Parts that nothing couples: answers are measured by the scale of each. nullptr: all is one part. -1: of none.
  std::ptrdiff_t islands = 1;
  const std::ptrdiff_t* island_of_contact = nullptr;     ///< nc
  const std::ptrdiff_t* island_of_coordinate = nullptr;  ///< ngc
  InertiaInput inertia;
};

/// What an answer is worth, evaluated from v, N, D, mu and the inertia in the engine's arithmetic, each island relative
/// to its own scale (ContactScale). Of the islands the worst.
struct Residual {
  double velocity = 0;  ///< bound on the velocity residual: max |w_i| where z_i > 0, max(0, -w_i) elsewhere
  /// The same with a bound on its rounding added, that of G's factors included: infinite where they have lost all.
  double certain = 0;
};

}  // namespace lcpbench::contact_lemke
