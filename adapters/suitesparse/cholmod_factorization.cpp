#include "adapters/suitesparse/cholmod_factorization.h"

#include <new>

#include <cholmod.h>

namespace lcpbench {
namespace {

int supernodal_option(CholmodFactor factor) {
  switch (factor) {
    case CholmodFactor::kAuto: return CHOLMOD_AUTO;
    case CholmodFactor::kSimplicial: return CHOLMOD_SIMPLICIAL;
    case CholmodFactor::kSupernodal: return CHOLMOD_SUPERNODAL;
  }
  return CHOLMOD_AUTO;
}

int ordering_method(CholmodOrdering ordering) {
  switch (ordering) {
    case CholmodOrdering::kGiven: return CHOLMOD_NATURAL;
    case CholmodOrdering::kAmd: return CHOLMOD_AMD;
    case CholmodOrdering::kMetis: return CHOLMOD_METIS;
  }
  return CHOLMOD_NATURAL;
}

/// CHOLMOD's view of a lower triangle that the caller owns. The library takes pointers to mutable data, but does not
/// change the data.
cholmod_sparse view_of(const SparseMatrix& lower) {
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(lower.rows());
  view.ncol = static_cast<std::size_t>(lower.cols());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = const_cast<int*>(lower.outerIndexPtr());
  view.i = const_cast<int*>(lower.innerIndexPtr());
  view.x = const_cast<double*>(lower.valuePtr());
  view.stype = -1;  // symmetric, lower triangle
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

class CholmodCholesky final : public SparseFactorization {
 public:
  explicit CholmodCholesky(const CholmodOptions& options) : options_(options) {
    cholmod_start(&common_);
    common_.print = 0;
    common_.dbound = 0;  // no pivot is raised to a bound
    common_.nmethods = 1;
    common_.method[0].ordering = ordering_method(options.ordering);
    common_.postorder = 1;  // supernodes need it, and fill does not change
    common_.supernodal = supernodal_option(options.factor);
  }
  CholmodCholesky(const CholmodCholesky&) = delete;
  CholmodCholesky& operator=(const CholmodCholesky&) = delete;
  ~CholmodCholesky() override {
    cholmod_free_dense(&solution_, &common_);
    cholmod_free_dense(&scratch_y_, &common_);
    cholmod_free_dense(&scratch_e_, &common_);
    cholmod_free_factor(&factor_, &common_);
    cholmod_finish(&common_);
  }

  void analyze(const SparseMatrix& lower) override {
    cholmod_sparse view = view_of(lower);
    factor_ = cholmod_analyze(&view, &common_);
    check(factor_ != nullptr);
    cost_ = {.factor = common_.fl / 2, .solve = 2 * common_.lnz};
  }

  bool factor(const SparseMatrix& lower) override {
    matrix_ = &lower;
    cholmod_sparse view = view_of(lower);
    check(cholmod_factorize(&view, factor_, &common_) != 0);
    return common_.status == CHOLMOD_OK && factor_->minor == factor_->n;
  }

  void solve(Vector& x) override {
    right_hand_side_ = x;
    solve_once(right_hand_side_, x);
    for (std::int64_t round = 0; round < options_.refinements; ++round) {
      residual_ = right_hand_side_;
      residual_.noalias() -= matrix_->selfadjointView<Eigen::Lower>() * x;
      solve_once(residual_, correction_);
      x += correction_;
    }
  }

  Cost cost() const override { return cost_; }

 private:
  /// Errors (status below 0) are thrown: memory, or more entries than 32-bit indices count. Warnings are breakdowns.
  void check(bool done) const {
    if (!done || common_.status < CHOLMOD_OK) throw std::bad_alloc();
  }

  void solve_once(Vector& b, Vector& x) {
    cholmod_dense view{};
    view.nrow = view.nzmax = view.d = static_cast<std::size_t>(b.size());
    view.ncol = 1;
    view.x = b.data();
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    check(cholmod_solve2(CHOLMOD_A, factor_, &view, nullptr, &solution_, nullptr, &scratch_y_, &scratch_e_, &common_) !=
          0);
    x = Eigen::Map<const Vector>(static_cast<const double*>(solution_->x), b.size());
  }

  CholmodOptions options_;
  cholmod_common common_{};
  cholmod_factor* factor_ = nullptr;
  Cost cost_;
  const SparseMatrix* matrix_ = nullptr;
  cholmod_dense* solution_ = nullptr;  // these three are kept by CHOLMOD from one solution to the next
  cholmod_dense* scratch_y_ = nullptr;
  cholmod_dense* scratch_e_ = nullptr;
  Vector right_hand_side_;
  Vector residual_;
  Vector correction_;
};

}  // namespace

std::unique_ptr<SparseFactorization> cholmod_factorization(const CholmodOptions& options) {
  return std::make_unique<CholmodCholesky>(options);
}

}  // namespace lcpbench
