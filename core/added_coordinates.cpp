#include "core/added_coordinates.h"

namespace lcpbench {

Inertia AddedCoordinates::inertia(const Inertia& of) const {
  if (inertia_.empty()) return of;
  const auto count = static_cast<Index>(inertia_.size());
  const Vector own = Eigen::Map<const Vector>(inertia_.data(), count);
  if (const auto* factors = std::get_if<FactoredInertia>(&of)) {
    FactoredInertia all{Matrix::Zero(next_, factors->X.cols() + count), Vector(factors->alpha.size() + count)};
    all.X.topLeftCorner(factors->X.rows(), factors->X.cols()) = factors->X;
    all.X.bottomRightCorner(count, count).setIdentity();
    all.alpha << factors->alpha, own;
    return all;
  }
  if (const auto* inverse = std::get_if<InverseInertia>(&of)) {
    InverseInertia all{Matrix::Zero(next_, next_)};
    all.Ginv.topLeftCorner(next_ - count, next_ - count) = inverse->Ginv;
    all.Ginv.diagonal().tail(count) = own.cwiseInverse();
    return all;
  }
  BlockInertia all;
  if (const auto* dense = std::get_if<DenseInertia>(&of)) all.blocks.push_back(dense->G);
  if (const auto* bodies = std::get_if<BlockInertia>(&of)) all.blocks = bodies->blocks;
  for (const double each : inertia_) all.blocks.push_back(Matrix::Constant(1, 1, each));
  return all;
}

}  // namespace lcpbench
