// Lemke's pivoting with LEMKE's rules over two representations of the basis. Compiled once per instruction-set level
// into the namespace LCPBENCH_LEVEL; see lemke_engine.h for what may cross the border.
#include "native/lemke/lemke_engine.h"

#include "native/lemke/dense_basis.h"
#include "native/lemke/kernel_basis.h"
#include "native/lemke/path.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

Engine* create_dense_engine() { return new BasisEngine<DenseBasis>; }
Engine* create_kernel_engine() { return new BasisEngine<KernelBasis>; }

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
