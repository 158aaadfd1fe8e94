#pragma once

#include <iosfwd>
#include <string>

namespace lcpbench {

/// Instruction-set levels of the vector kernels. A kernel without a build for AVX-512 runs its AVX2 build there.
enum class IsaLevel { kBaseline, kAvx2, kAvx512 };

/// "baseline", "avx2", "avx512".
const char* to_string(IsaLevel level);

/// The highest level of this processor. Builds for x86-64 have all levels, others have the baseline alone.
IsaLevel best_isa_level();

/// The level in use: best_isa_level(), or the one that the environment variable LCPBENCH_ISA names. Read once; an
/// empty value counts as unset.
/// @throws InputError when LCPBENCH_ISA is no level's name or asks for more than the processor has.
IsaLevel isa_level();

/// Name of the processor as the system tells it; "unknown" where it does not.
std::string processor_name();

/// The first processor's name in a text of the form of Linux's /proc/cpuinfo: "model name" (x86), "cpu" (POWER),
/// "uarch" (RISC-V), or Arm's numbers, which have no name there: "CPU implementer 0x41 part 0xd0c". "unknown" without
/// any.
std::string processor_name(std::istream& cpuinfo);

}  // namespace lcpbench
