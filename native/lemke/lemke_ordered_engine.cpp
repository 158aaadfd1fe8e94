// Lemke's pivoting by the rules of 2012: compiled once, for all instruction-set levels, without fused multiply-add.
#include "native/lemke/interface.h"
#include "native/lemke/ordered_basis.h"
#include "native/lemke/path_tree.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {
namespace {

using HeldWithRoom = HeldForSweeps<OrderedBasis>;

Count walk(void* object, const Cell* cells, Count count, const WalkRules& rules, double* z) {
  auto& [basis, room] = *static_cast<HeldWithRoom*>(object);
  return PathTree<false, OrderedBasis>(basis, room, cells, rules, z).walk(count);
}

}  // namespace

const Engine kOrderedEngine = engine_over<double, HeldWithRoom>(walk);

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
