#pragma once

#include <cfloat>

namespace lcpbench {

/// A binary floating-point type of 113 significant bits (IEEE binary128): the arithmetic of the evaluation, and of
/// the last stage of native solvers.
///
/// `__float128` where the compiler has it (x86-64), `long double` where that is binary128 (AArch64, RISC-V, s390x).
#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 Quad;
#elif LDBL_MANT_DIG == 113
using Quad = long double;
#else
#error "this processor has no 128-bit binary floating-point type"
#endif

/// Unit round-off of Quad, 2^-113.
constexpr double kQuadUnitRoundoff = 0x1p-113;

inline double to_double(Quad x) { return static_cast<double>(x); }
inline Quad abs(Quad x) { return x < 0 ? -x : x; }

/// False for NaN and for both infinities.
inline bool is_finite(Quad x) { return x - x == 0; }

/// Square root of x >= 0 to within two units in the last place (two Newton steps from the double result).
/// Returns 0 for x <= 0, NaN for NaN, infinity for infinity; arguments outside the range of double are scaled by powers
/// of four.
Quad sqrt(Quad x);

}  // namespace lcpbench
