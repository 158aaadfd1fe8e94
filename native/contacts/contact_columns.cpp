#include "native/contacts/contact_columns.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "native/contacts/block_inverse.h"

namespace lcpbench {
namespace {

class Builder {
 public:
  explicit Builder(const Inertia& inertia) : inertia_(inertia), column_(Vector::Zero(inertia_.dimension())) {}

  void add_columns(const Jacobian& J) {
    for (Index j = 0; j < cols(J); ++j) {
      if (const auto* dense = std::get_if<Matrix>(&J)) {
        for (Index i = 0; i < dense->rows(); ++i) scatter(i, (*dense)(i, j));
      } else {
        for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(J), j); entry; ++entry) {
          scatter(entry.row(), entry.value());
        }
      }
      finish_column();
    }
  }

  ContactColumns result() {
    result_.diagonal = Eigen::Map<const Vector>(diagonal_.data(), static_cast<Index>(diagonal_.size()));
    return std::move(result_);
  }

 private:
  void scatter(Index row, double value) {
    if (value == 0) return;
    column_(row) += value;
    touched_.push_back(inertia_.block_of(row));
  }

  void finish_column() {
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    result_.J.add_column();
    result_.response.add_column();
    double diagonal = 0;
    double rounding = 0;
    for (const std::size_t block : touched_) {
      const Matrix& inverse = inertia_.inverse(block);
      auto part = column_.segment(inertia_.offset(block), inverse.rows());
      const Vector response = inverse * part;
      result_.J.add_run(inertia_.offset(block), part);
      result_.response.add_run(inertia_.offset(block), response);
      diagonal += part.dot(response);
      // Each entry of J'(G*J) is a sum of rows^2 products, rounded 2 rows times at most.
      rounding += 2 * static_cast<double>(inverse.rows()) * std::numeric_limits<double>::epsilon() *
                  part.cwiseAbs().dot(inverse.cwiseAbs() * part.cwiseAbs());
      part.setZero();
    }
    diagonal_.push_back(diagonal > rounding ? diagonal : 0.0);
    touched_.clear();
  }

  BlockInverse inertia_;
  Vector column_;  // scratch: zero between columns
  std::vector<std::size_t> touched_;
  std::vector<double> diagonal_;
  ContactColumns result_;
};

}  // namespace

ContactColumns contact_columns(const ContactProblem& problem) {
  Builder builder(problem.inertia);
  builder.add_columns(problem.N);
  builder.add_columns(problem.D);
  return builder.result();
}

}  // namespace lcpbench
