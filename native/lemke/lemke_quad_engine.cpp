// Lemke's pivoting in 113 bits. Apart from lemke_engine.cpp, so that nothing here can change the code of that.
#include "native/kernels/arithmetic.h"
#include "native/lemke/interface.h"
#include "native/lemke/kernel_basis.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

const Engine kKernelEngine = engine_over<Quad, Held<KernelBasis<Quad>>>(nullptr);

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
