#include "native/velocity_ipm/whitened_normals.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <type_traits>
#include <utility>
#include <vector>

#include "native/velocity_ipm/assembly_tree.h"

namespace lcpbench {
namespace {

/// Factors of the blocks of an inertia: G = L L', block by block.
class BlockRoots {
 public:
  /// False when a block is not positive definite.
  bool factor(const BlockInertia& inertia) {
    for (const Matrix& block : inertia.blocks) {
      factors_.emplace_back(block);
      if (factors_.back().info() != Eigen::Success) return false;
      begin_.push_back(size());
      block_of_row_.insert(block_of_row_.end(), static_cast<std::size_t>(block.rows()), factors_.size() - 1);
    }
    return true;
  }

  Index size() const { return static_cast<Index>(block_of_row_.size()); }

  /// The inertia block that a coordinate is of.
  std::size_t block_of(Index row) const { return block_of_row_[static_cast<std::size_t>(row)]; }
  Index begin(std::size_t block) const { return begin_[block]; }
  Index size(std::size_t block) const { return factors_[block].rows(); }

  /// part := L^-1 part, in one block.
  template <class Part>
  void whiten(std::size_t block, Part part) const {
    factors_[block].matrixL().solveInPlace(part);
  }

 private:
  std::vector<Eigen::LLT<Matrix>> factors_;
  std::vector<Index> begin_;
  std::vector<std::size_t> block_of_row_;
};

SparseMatrix sparse(const Jacobian& J) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return dense->sparseView();
  SparseMatrix compressed = std::get<SparseMatrix>(J);
  compressed.makeCompressed();
  return compressed;
}

constexpr int kChunk = 16;  // rows whose sums are kept on the stack: those of two bodies, and more

/// Consecutive columns of W that touch the same bodies, as one dense matrix.
struct ColumnGroup {
  int first_column = 0;
  int columns = 0;
  int size = 0;            // rows
  std::size_t rows = 0;    // where they begin in the list of all groups' rows
  std::size_t values = 0;  // where the matrix begins, by columns
};

/// L^-1 N by groups of columns, without the rows that are zero in all columns of a group.
struct ColumnGroups {
  std::vector<ColumnGroup> groups;
  std::vector<int> rows;
  std::vector<double> values;

  /// @param coupled  its blocks are in one group each
  ColumnGroups(const BlockRoots& roots, const SparseMatrix& N, const CoupledCompliance& coupled);

  /// Numbers rows anew, increasing in each group. @param number  of each row
  void renumber(const std::vector<int>& number);

  const double* column(const ColumnGroup& group, int c) const {
    return values.data() + group.values + static_cast<std::ptrdiff_t>(c) * group.size;
  }

  /// f(begin, count) for parts of a group's rows, each of at most kChunk. `count` is a constant for the rows of one
  /// body or two, so that compilers unroll the loops over them.
  template <class F>
  static void for_each_chunk(const ColumnGroup& group, F&& f) {
    switch (group.size) {
      case 3: return f(0, std::integral_constant<int, 3>());
      case 6: return f(0, std::integral_constant<int, 6>());
      case 12: return f(0, std::integral_constant<int, 12>());
      default:
        for (int begin = 0; begin < group.size; begin += kChunk) f(begin, std::min(kChunk, group.size - begin));
    }
  }

  /// f(row, column) for each pair row >= column of a group's rows, by columns.
  template <class F>
  void for_each_pair(const ColumnGroup& group, F&& f) const {
    const int* const row = rows.data() + group.rows;
    for (int c = 0; c < group.size; ++c) {
      for (int r = c; r < group.size; ++r) f(row[r], row[c]);
    }
  }

 private:
  void add(const BlockRoots& roots, const SparseMatrix& N, int first_column, int end_column,
           const std::vector<std::size_t>& bodies);
};

/// The inertia blocks that columns have entries in, increasing.
void find_bodies(const BlockRoots& roots, const SparseMatrix& N, int first, int end, std::vector<std::size_t>& bodies) {
  bodies.clear();
  for (int column = first; column < end; ++column) {
    for (SparseMatrix::InnerIterator entry(N, column); entry; ++entry) {
      const std::size_t block = roots.block_of(entry.row());
      if (bodies.empty() || bodies.back() != block) bodies.push_back(block);
    }
  }
  if (end - first == 1) return;
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
}

ColumnGroups::ColumnGroups(const BlockRoots& roots, const SparseMatrix& N, const CoupledCompliance& coupled) {
  std::vector<std::size_t> bodies, next_bodies;
  const int columns = static_cast<int>(N.cols());
  std::size_t next = 0;  // of the blocks
  const auto end_of_unit = [&](int column) {
    return coupled.empty() ? column + 1 : column + static_cast<int>(coupled.blocks()[next++].size);
  };
  int unit_end = columns > 0 ? end_of_unit(0) : 0;
  if (columns > 0) find_bodies(roots, N, 0, unit_end, bodies);
  for (int first = 0, end = 0; first < columns; first = end, bodies.swap(next_bodies)) {
    for (end = unit_end; end < columns; end = unit_end) {
      unit_end = end_of_unit(end);
      find_bodies(roots, N, end, unit_end, next_bodies);
      if (next_bodies != bodies) break;
    }
    add(roots, N, first, end, bodies);
  }
}

void ColumnGroups::add(const BlockRoots& roots, const SparseMatrix& N, int first_column, int end_column,
                       const std::vector<std::size_t>& bodies) {
  std::vector<int> candidates;
  for (const std::size_t body : bodies) {
    for (Index r = 0; r < roots.size(body); ++r) candidates.push_back(static_cast<int>(roots.begin(body) + r));
  }
  Matrix part = Matrix::Zero(static_cast<Index>(candidates.size()), end_column - first_column);
  for (Index c = 0; c < part.cols(); ++c) {
    Index begin = 0;
    std::size_t body = 0;
    for (SparseMatrix::InnerIterator entry(N, first_column + c); entry; ++entry) {
      for (; roots.block_of(entry.row()) != bodies[body]; ++body) begin += roots.size(bodies[body]);
      part(begin + entry.row() - roots.begin(bodies[body]), c) += entry.value();
    }
  }
  Index begin = 0;
  for (const std::size_t body : bodies) {
    roots.whiten(body, part.middleRows(begin, roots.size(body)));
    begin += roots.size(body);
  }
  ColumnGroup group{
      .first_column = first_column, .columns = end_column - first_column, .rows = rows.size(), .values = values.size()};
  std::vector<Index> kept;
  for (Index r = 0; r < part.rows(); ++r) {
    if ((part.row(r).array() == 0).all()) continue;
    kept.push_back(r);
    rows.push_back(candidates[static_cast<std::size_t>(r)]);
  }
  group.size = static_cast<int>(kept.size());
  for (Index c = 0; c < part.cols(); ++c) {
    for (const Index r : kept) values.push_back(part(r, c));
  }
  groups.push_back(group);
}

void ColumnGroups::renumber(const std::vector<int>& number) {
  std::vector<std::pair<int, int>> order;  // new row, old place
  std::vector<double> column;
  for (const ColumnGroup& group : groups) {
    order.clear();
    int* const row = rows.data() + group.rows;
    for (int r = 0; r < group.size; ++r) order.emplace_back(number[static_cast<std::size_t>(row[r])], r);
    std::sort(order.begin(), order.end());
    for (int r = 0; r < group.size; ++r) row[r] = order[static_cast<std::size_t>(r)].first;
    for (int c = 0; c < group.columns; ++c) {
      double* const value = values.data() + group.values + static_cast<std::ptrdiff_t>(c) * group.size;
      column.assign(value, value + group.size);
      for (int r = 0; r < group.size; ++r) {
        value[r] = column[static_cast<std::size_t>(order[static_cast<std::size_t>(r)].second)];
      }
    }
  }
}

/// Coordinates that no contact changes are left out.
class SparseNormals final : public WhitenedNormals {
 public:
  SparseNormals(BlockRoots roots, const Jacobian& N, std::unique_ptr<SparseFactorization> factorization,
                const CoupledCompliance& coupled)
      : roots_(std::move(roots)),
        columns_(cols(N)),
        W_(roots_, sparse(N), coupled),
        scaled_(coupled.empty() ? 0 : W_.values.size()),
        factorization_(std::move(factorization)) {
    leave_out_untouched();
    order_rows();
    matrix_ = pattern();
    find_positions();
    factorization_->analyze(matrix_);
  }

  Index coordinates() const override { return static_cast<Index>(rows_.size()); }
  Vector squared_norms() const override;
  void combine(const Vector& f, Vector& y) const override;
  void project(const Vector& y, Vector& s) const override;
  bool factor(const Vector& weights) override {
    return factor_with(W_.values.data(), [&](int column) { return weights(column); });
  }
  bool factor_coupled(const CoupledCompliance& coupled) override;
  void solve(Vector& y) const override { factorization_->solve(y); }
  Cost cost() const override;

 private:
  void leave_out_untouched();
  void order_rows();
  SparseMatrix pattern() const;
  void find_positions();
  template <class Weight>
  bool factor_with(const double* of_columns, const Weight& weight);

  BlockRoots roots_;
  Index columns_ = 0;
  ColumnGroups W_;         // rows in the order of elimination
  std::vector<double> scaled_;  // the values of W K
  std::vector<int> rows_;  // the coordinates that contacts change, in that order
  SparseMatrix matrix_;    // lower triangle
  std::vector<int> diagonal_;
  std::vector<int> position_;  // in matrix_, of the groups' pairs of rows
  std::unique_ptr<SparseFactorization> factorization_;
};

void SparseNormals::leave_out_untouched() {
  std::vector<int> number(static_cast<std::size_t>(roots_.size()), -1);
  for (const int row : W_.rows) number[static_cast<std::size_t>(row)] = 0;
  for (std::size_t row = 0; row < number.size(); ++row) {
    if (number[row] < 0) continue;
    number[row] = static_cast<int>(rows_.size());
    rows_.push_back(static_cast<int>(row));
  }
  W_.renumber(number);
}

void SparseNormals::order_rows() {
  const std::vector<int> order = elimination_order(pattern());
  std::vector<int> number(order.size());
  std::vector<int> ordered(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    number[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
    ordered[k] = rows_[static_cast<std::size_t>(order[k])];
  }
  rows_ = std::move(ordered);
  W_.renumber(number);
}

/// The lower triangle of I + W W'.
SparseMatrix SparseNormals::pattern() const {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < static_cast<int>(rows_.size()); ++i) entries.emplace_back(i, i, 1.0);
  for (const ColumnGroup& group : W_.groups) {
    W_.for_each_pair(group, [&](int row, int column) { entries.emplace_back(row, column, 1.0); });
  }
  SparseMatrix matrix(coordinates(), coordinates());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Where the diagonal is in matrix_, and where each pair of a group's rows is.
void SparseNormals::find_positions() {
  const auto position = [&](int row, int column) {
    const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column];
    const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + 1];
    return static_cast<int>(std::lower_bound(begin, end, row) - matrix_.innerIndexPtr());
  };
  for (int i = 0; i < static_cast<int>(rows_.size()); ++i) diagonal_.push_back(position(i, i));
  for (const ColumnGroup& group : W_.groups) {
    W_.for_each_pair(group, [&](int row, int column) { position_.push_back(position(row, column)); });
  }
}

Vector SparseNormals::squared_norms() const {
  Vector norms(columns_);
  for (const ColumnGroup& group : W_.groups) {
    for (int c = 0; c < group.columns; ++c) {
      norms(group.first_column + c) = Eigen::Map<const Vector>(W_.column(group, c), group.size).squaredNorm();
    }
  }
  return norms;
}

void SparseNormals::combine(const Vector& f, Vector& y) const {
  y.setZero(coordinates());
  for (const ColumnGroup& group : W_.groups) {
    W_.for_each_chunk(group, [&](int begin, auto count) {
      double sums[kChunk] = {};
      for (int c = 0; c < group.columns; ++c) {
        const double* const column = W_.column(group, c) + begin;
        for (int r = 0; r < count; ++r) sums[r] += f(group.first_column + c) * column[r];
      }
      const int* const row = W_.rows.data() + group.rows + begin;
      for (int r = 0; r < count; ++r) y(row[r]) += sums[r];
    });
  }
}

void SparseNormals::project(const Vector& y, Vector& s) const {
  s.setZero(columns_);
  for (const ColumnGroup& group : W_.groups) {
    W_.for_each_chunk(group, [&](int begin, auto count) {
      const int* const row = W_.rows.data() + group.rows + begin;
      double part[kChunk];
      for (int r = 0; r < count; ++r) part[r] = y(row[r]);
      for (int c = 0; c < group.columns; ++c) {
        const double* const column = W_.column(group, c) + begin;
        double sum = 0;
        for (int r = 0; r < count; ++r) sum += column[r] * part[r];
        s(group.first_column + c) += sum;
      }
    });
  }
}

/// The factors are fitted like those of the factorization: what a group and its rows take beside multiplications.
SparseNormals::Cost SparseNormals::cost() const {
  const SparseFactorization::Cost of = factorization_->cost();
  Cost cost{.product = 100 + 5 * static_cast<double>(columns_), .factor = of.factor, .solve = of.solve};
  for (const ColumnGroup& group : W_.groups) {
    const auto size = static_cast<double>(group.size);
    cost.product += 36 + 0.5 * group.columns * size;
    cost.factor += (2.5 * group.columns + 6) * size * size;
  }
  return cost;
}

bool SparseNormals::factor_coupled(const CoupledCompliance& coupled) {
  auto block = coupled.blocks().begin();
  for (const ColumnGroup& group : W_.groups) {
    for (int first = 0; first < group.columns; first += static_cast<int>(block++->size)) {
      const double* const K = coupled.root(*block);
      const auto size = static_cast<int>(block->size);
      W_.for_each_chunk(group, [&](int begin, auto count) {
        for (int j = 0; j < size; ++j) {
          double sums[kChunk] = {};
          for (int i = 0; i <= j; ++i) {
            const double* const column = W_.column(group, first + i) + begin;
            for (int r = 0; r < count; ++r) sums[r] += K[j * size + i] * column[r];
          }
          double* const to =
              scaled_.data() + group.values + static_cast<std::ptrdiff_t>(first + j) * group.size + begin;
          for (int r = 0; r < count; ++r) to[r] = sums[r];
        }
      });
    }
  }
  return factor_with(scaled_.data(), [](int) { return 1.0; });
}

/// @param of_columns  in the order of those of W
template <class Weight>
bool SparseNormals::factor_with(const double* of_columns, const Weight& weight) {
  double* const values = matrix_.valuePtr();
  std::fill(values, values + matrix_.nonZeros(), 0.0);
  for (const int diagonal : diagonal_) values[diagonal] = 1;
  const int* position = position_.data();
  for (const ColumnGroup& group : W_.groups) {
    for (int pivot = 0; pivot < group.size; ++pivot) {
      W_.for_each_chunk(group, [&](int begin, auto count) {
        if (begin + count <= pivot) return;
        double sums[kChunk] = {};
        for (int c = 0; c < group.columns; ++c) {
          const double* const column = of_columns + group.values + static_cast<std::ptrdiff_t>(c) * group.size;
          const double weighted = weight(group.first_column + c) * column[pivot];
          for (int r = 0; r < count; ++r) sums[r] += weighted * column[begin + r];
        }
        for (int r = std::max(pivot - begin, 0); r < count; ++r) values[*position++] += sums[r];
      });
    }
  }
  return factorization_->factor(matrix_);
}

}  // namespace

std::unique_ptr<WhitenedNormals> sparse_whitened_normals(const ContactProblem& problem,
                                                         std::unique_ptr<SparseFactorization> factorization,
                                                         const CoupledCompliance& coupled) {
  BlockRoots roots;
  const auto* blocks = std::get_if<BlockInertia>(&problem.inertia);
  if (blocks == nullptr || !roots.factor(*blocks)) return nullptr;
  return std::make_unique<SparseNormals>(std::move(roots), problem.N, std::move(factorization), coupled);
}

bool suits_sparse_algebra(const ContactProblem& problem) {
  return std::holds_alternative<SparseMatrix>(problem.N) && std::holds_alternative<BlockInertia>(problem.inertia);
}

}  // namespace lcpbench
