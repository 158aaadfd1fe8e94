#include "native/contacts/contact_columns.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "core/entries.h"
#include "native/contacts/block_inverse.h"

namespace lcpbench {
namespace {

class Builder {
 public:
  Builder(const BlockInverse& inertia, Index columns, std::size_t entries, bool with_response, ContactColumns& result)
      : inertia_(inertia), with_response_(with_response), column_(Vector::Zero(inertia_.dimension())), result_(result) {
    result_.J.clear();
    result_.J.reserve(columns, entries);
    result_.response.clear();
    if (with_response_) result_.response.reserve(columns, entries);
    result_.diagonal.resize(columns);
  }

  void add_column(const Jacobian& J, Index column) {
    for_each_entry(J, column, [this](Index row, double value) { scatter(row, value); });
    finish_column();
  }

  void add_empty_column() { finish_column(); }

 private:
  void scatter(Index row, double value) {
    column_(row) += value;
    const std::size_t block = inertia_.block_of(row);
    if (touched_.empty() || touched_.back() != block) touched_.push_back(block);
  }

  void finish_column() {
    const bool ascends = std::adjacent_find(touched_.begin(), touched_.end(), std::greater_equal<>()) == touched_.end();
    if (!ascends) {
      std::sort(touched_.begin(), touched_.end());
      touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    }
    result_.J.add_column();
    if (with_response_) result_.response.add_column();
    double diagonal = 0;
    double rounding = 0;
    for (const std::size_t block : touched_) {
      const Matrix& inverse = inertia_.inverse(block);
      const Index size = inverse.rows();
      auto part = column_.segment(inertia_.offset(block), size);
      response_.setZero(size);
      magnitudes_.setZero(size);
      for (Index k = 0; k < size; ++k) {
        const double entry = part(k);
        if (entry == 0) continue;
        const double* const column = inverse.data() + k * size;
        for (Index i = 0; i < size; ++i) {
          response_(i) += column[i] * entry;
          magnitudes_(i) += std::abs(column[i] * entry);
        }
      }
      result_.J.add_run(inertia_.offset(block), part);
      if (with_response_) result_.response.add_run(inertia_.offset(block), response_);
      double terms = 0;
      for (Index i = 0; i < size; ++i) {
        diagonal += part(i) * response_(i);
        terms += std::abs(part(i)) * magnitudes_(i);
      }
      // The block's part of J_i'G*J_i is a sum of size^2 products, each of them rounded about 2 size times.
      rounding += 2 * static_cast<double>(size) * std::numeric_limits<double>::epsilon() * terms;
      part.setZero();
    }
    result_.diagonal(result_.J.cols() - 1) = diagonal > rounding ? diagonal : 0.0;
    touched_.clear();
  }

  const BlockInverse& inertia_;
  bool with_response_;
  Vector column_;  // scratch: zero between columns
  Vector response_, magnitudes_;
  std::vector<std::size_t> touched_;
  ContactColumns& result_;
};

std::size_t entries(const Jacobian& J) {
  const auto* sparse = std::get_if<SparseMatrix>(&J);
  return static_cast<std::size_t>(sparse != nullptr ? sparse->nonZeros() : rows(J) * cols(J));
}

}  // namespace

void find_contact_columns(const ContactProblem& problem, const BlockInverse& inverse, Opposites opposites,
                          bool with_response, ContactColumns& columns) {
  const std::size_t friction_entries = entries(problem.D);
  Builder builder(inverse, problem.nc() + cols(problem.D),
                  entries(problem.N) + (opposites == Opposites::kEmpty ? friction_entries / 2 : friction_entries),
                  with_response, columns);
  for (Index contact = 0; contact < problem.nc(); ++contact) builder.add_column(problem.N, contact);
  if (opposites == Opposites::kStored) {
    for (Index column = 0; column < cols(problem.D); ++column) builder.add_column(problem.D, column);
    return;
  }
  Index column = 0;
  for (const int edges : problem.edges) {
    for (int t = 0; t < edges; ++t, ++column) {
      if (2 * t < edges) {
        builder.add_column(problem.D, column);
      } else {
        builder.add_empty_column();
      }
    }
  }
}

ContactColumns contact_columns(const ContactProblem& problem) {
  ContactColumns columns;
  find_contact_columns(problem, BlockInverse(problem.inertia), Opposites::kStored, true, columns);
  return columns;
}

}  // namespace lcpbench
