// Lemke's pivoting by the rules of 2012: compiled once, for all instruction-set levels, without fused multiply-add.
#include "native/lemke/ordered_basis.h"
#include "native/lemke/path_tree.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

Engine* create_engine() { return new SweepingEngine<OrderedBasis>; }

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
