#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace lcpbench {

using Index = Eigen::Index;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using SparseMatrix = Eigen::SparseMatrix<double>;

}  // namespace lcpbench
