#pragma once

// Templates of Eigen that are compiled once, in eigen_instances.cpp, and not again in every file that multiplies or factors
// a matrix, which took the compiler up to six seconds a file. No result depends on it: without contraction a sum is
// rounded alike wherever it is compiled. Only the precompiled headers include this file
// (cmake/lcpbench_precompiled.cmake); everything compiles without it.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <vector>

#ifndef LCPBENCH_EIGEN_INSTANCE
#define LCPBENCH_EIGEN_INSTANCE extern template
#endif

namespace Eigen {

LCPBENCH_EIGEN_INSTANCE LLT<MatrixXd>& LLT<MatrixXd>::compute(const EigenBase<MatrixXd>&);
LCPBENCH_EIGEN_INSTANCE void PartialPivLU<MatrixXd>::compute();
LCPBENCH_EIGEN_INSTANCE SelfAdjointEigenSolver<MatrixXd>& SelfAdjointEigenSolver<MatrixXd>::compute(
    const EigenBase<MatrixXd>&, int);
LCPBENCH_EIGEN_INSTANCE SparseMatrix<double>& SparseMatrix<double>::operator=(
    const SparseMatrixBase<SparseMatrix<double, RowMajor>>&);

namespace internal {

using Destination = blas_data_mapper<double, Index, ColMajor>;
using Columns = const_blas_data_mapper<double, Index, ColMajor>;
using Rows = const_blas_data_mapper<double, Index, RowMajor>;
using Kernel = gebp_traits<double, double>;

LCPBENCH_EIGEN_INSTANCE struct gebp_kernel<double, double, Index, Destination, Kernel::mr, Kernel::nr>;
LCPBENCH_EIGEN_INSTANCE struct general_matrix_vector_product<Index, double, Columns, ColMajor, false, double, Columns, false>;
LCPBENCH_EIGEN_INSTANCE struct general_matrix_vector_product<Index, double, Columns, ColMajor, false, double, Rows, false>;
LCPBENCH_EIGEN_INSTANCE struct general_matrix_vector_product<Index, double, Rows, RowMajor, false, double, Columns, false>;
LCPBENCH_EIGEN_INSTANCE struct general_matrix_vector_product<Index, double, Rows, RowMajor, false, double, Rows, false>;
LCPBENCH_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Lower, false, ColMajor, ColMajor, 1>;
LCPBENCH_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, ColMajor, ColMajor, 1>;
LCPBENCH_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, UnitLower, false, ColMajor, ColMajor, 1>;
LCPBENCH_EIGEN_INSTANCE struct triangular_solve_matrix<double, Index, OnTheLeft, Upper, false, RowMajor, ColMajor, 1>;
LCPBENCH_EIGEN_INSTANCE struct triangular_solve_vector<double, double, Index, OnTheLeft, Lower, false, ColMajor>;
LCPBENCH_EIGEN_INSTANCE struct triangular_solve_vector<double, double, Index, OnTheLeft, Upper, false, RowMajor>;
LCPBENCH_EIGEN_INSTANCE void assign_sparse_to_sparse(SparseMatrix<double>&, const SparseMatrix<double>&);
LCPBENCH_EIGEN_INSTANCE void set_from_triplets(
    const std::vector<Triplet<double>>::iterator&, const std::vector<Triplet<double>>::iterator&, SparseMatrix<double>&,
    scalar_sum_op<double>);

}  // namespace internal
}  // namespace Eigen
