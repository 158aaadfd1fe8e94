// Lemke's pivoting in other arithmetic than double: once per instruction-set level in 24 bits, and once in 113 bits
// (LCPBENCH_QUAD). Apart from lemke_engine.cpp, so that nothing here can change the code of that.
#if defined(LCPBENCH_QUAD)
#include "native/contact_lemke/arithmetic.h"
#endif
#include "native/lemke/interface.h"
#include "native/lemke/kernel_basis.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

#if defined(LCPBENCH_QUAD)
const Engine kKernelEngine = engine_over<Quad, Held<KernelBasis<Quad>>>(nullptr, nullptr);
#else
const Engine kFloatKernelEngine = engine_over<float, Held<KernelBasis<float>>>(nullptr, nullptr);
#endif

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
