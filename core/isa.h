#pragma once

#include <iosfwd>
#include <string>

namespace lcpbench {

/// Instruction-set levels of the vector kernels: kAvx2 is AVX2 and FMA, kAvx512 adds AVX-512 F, DQ and VL. A kernel
/// that has no build for AVX-512 runs its AVX2 build at that level.
enum class IsaLevel { kBaseline, kAvx2, kAvx512 };

/// "baseline", "avx2", "avx512".
const char* to_string(IsaLevel level);

/// The highest level of this processor; builds for other processors than x86-64 have the baseline alone.
IsaLevel best_isa_level();

/// The level in use: best_isa_level(), or the one that the environment variable LCPBENCH_ISA names. Read once; an
/// empty value counts as unset.
/// @throws InputError when LCPBENCH_ISA names no level, or one above best_isa_level()
IsaLevel isa_level();

/// Name of the processor from Linux's /proc/cpuinfo, which each call reads; "unknown" without one.
std::string processor_name();

/// The first processor's name in a text in the format of /proc/cpuinfo: "model name" (x86), "cpu" (POWER) or "uarch"
/// (RISC-V). Arm has numbers in place of a name: "CPU implementer 0x41 part 0xd0c". "unknown" without any of these.
std::string processor_name(std::istream& cpuinfo);

}  // namespace lcpbench
