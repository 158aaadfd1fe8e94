// Lemke's pivoting with LEMKE's rules over two representations of the basis. Compiled once per instruction-set level
// into the namespace LCPBENCH_LEVEL; see lemke_engine.h for what may cross the border.
#include "native/lemke/lemke_engine.h"

#include "native/lemke/dense_basis.h"
#include "native/lemke/interface.h"
#include "native/lemke/kernel_basis.h"
#include "native/lemke/path_tree.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {
namespace {

template <class Scalar>
using HeldWithRoom = HeldForSweeps<KernelBasis<Scalar>>;

template <class Scalar>
Count walk(void* object, const Cell* cells, Count count, const WalkRules& rules, double* z) {
  auto& [basis, room] = *static_cast<HeldWithRoom<Scalar>*>(object);
  if (rules.resolve) return PathTree<true, KernelBasis<Scalar>>(basis, room, cells, rules, z).walk(count);
  return PathTree<false, KernelBasis<Scalar>>(basis, room, cells, rules, z).walk(count);
}

}  // namespace

const Engine kDenseEngine = engine_over<double, Held<DenseBasis<double>>>(nullptr);
const Engine kKernelEngine = engine_over<double, HeldWithRoom<double>>(walk<double>);

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
