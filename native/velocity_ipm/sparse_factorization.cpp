#include "native/velocity_ipm/sparse_factorization.h"

#include <Eigen/SparseCholesky>

namespace lcpbench {
namespace {

class SimplicialLdlt final : public SparseFactorization {
 public:
  void analyze(const SparseMatrix& lower) override { factor_.analyzePattern(lower); }
  bool factor(const SparseMatrix& lower) override {
    factor_.factorize(lower);
    return factor_.info() == Eigen::Success;
  }
  void solve(Vector& x) override { x = factor_.solve(x).eval(); }

 private:
  Eigen::SimplicialLDLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> factor_;
};

}  // namespace

std::unique_ptr<SparseFactorization> simplicial_ldlt() { return std::make_unique<SimplicialLdlt>(); }

}  // namespace lcpbench
