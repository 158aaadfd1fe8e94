// Lemke's pivoting by the rules of 2012: compiled once, for all instruction-set levels, without fused multiply-add.
#include "native/lemke/ordered_basis.h"
#include "native/lemke/path.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

Engine* create_engine() { return new BasisEngine<OrderedBasis>; }

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
