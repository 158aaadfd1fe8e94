#include "native/velocity_ipm/multifrontal_cholesky.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "native/kernels/cholesky_engine.h"
#include "native/velocity_ipm/assembly_tree.h"

namespace lcpbench {
namespace {

using Node = AssemblyTree::Node;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

class MultifrontalCholesky final : public SparseFactorization {
 public:
  explicit MultifrontalCholesky(IsaLevel level) : kernels_(cholesky::engine(level)) {}

  void analyze(const SparseMatrix& lower) override;
  bool factor(const SparseMatrix& lower) override;
  void solve(Vector& x) override;
  Cost cost() const override;

 private:
  /// Where a node's front and its columns of L stand. Fronts are columns of stride() entries.
  struct Front {
    std::size_t memory = 0;  // 0 or 1
    std::size_t begin = 0;   // in memory_[memory]
    std::size_t factor = 0;  // in factor_
  };

  static std::ptrdiff_t stride(const Node& node) { return node.rows + cholesky::kMargin; }
  double* entries(std::size_t node) { return memory_[fronts_[node].memory].data() + fronts_[node].begin; }

  void place_fronts();
  void find_places(const SparseMatrix& lower);
  void assemble(std::size_t node, const double* values);
  void add_child(const Node& child, const double* from, const Node& parent, double* to) const;
  void keep_columns(std::size_t node);

  const cholesky::Engine& kernels_;
  AssemblyTree tree_;
  std::vector<Front> fronts_;                  // of each node
  std::array<std::vector<double>, 2> memory_;  // of the fronts at even and at odd depth, each a stack
  std::vector<double> factor_;                 // per node rows x columns, diagonal entries inverted
  std::vector<std::size_t> entries_begin_;     // per node, in the next two
  std::vector<int> entry_;                     // of the matrix
  std::vector<std::ptrdiff_t> place_;          // in the front
  std::vector<double> work_;
  std::vector<double> x_;     // in the order of elimination
  std::vector<double> part_;  // of x, the rows of a front
};

void MultifrontalCholesky::analyze(const SparseMatrix& lower) {
  tree_ = assembly_tree(lower);
  place_fronts();
  find_places(lower);
  std::ptrdiff_t rows = 0;
  for (const Node& node : tree_.nodes) rows = std::max<std::ptrdiff_t>(rows, node.rows);
  work_.assign(static_cast<std::size_t>(cholesky::work_size(rows)), 0.0);
  x_.assign(tree_.position.size(), 0.0);
  part_.assign(static_cast<std::size_t>(rows), 0.0);
}

/// Children stand in one memory, their parent in the other, and both are stacks: when a parent is assembled its
/// children are the last ones in theirs, and go.
void MultifrontalCholesky::place_fronts() {
  const std::size_t count = tree_.nodes.size();
  fronts_.assign(count, {});
  for (std::size_t k = count; k-- > 0;) {
    const int parent = tree_.nodes[k].parent;
    fronts_[k].memory = parent < 0 ? 0 : 1 - fronts_[index(parent)].memory;
  }
  std::array<std::size_t, 2> used{};
  std::array<std::size_t, 2> most{};
  std::size_t factor = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Node& node = tree_.nodes[k];
    Front& front = fronts_[k];
    front.begin = used[front.memory];
    front.factor = factor;
    factor += index(node.rows) * index(node.columns);
    used[front.memory] += static_cast<std::size_t>(stride(node) * stride(node));
    most[front.memory] = std::max(most[front.memory], used[front.memory]);
    if (node.first_child < node.end_child) {
      const Front& first = fronts_[index(tree_.children[node.first_child])];
      used[first.memory] = first.begin;
    }
    if (node.parent < 0) used[front.memory] = front.begin;
  }
  for (std::size_t m = 0; m < 2; ++m) memory_[m].assign(most[m], 0.0);
  factor_.assign(factor, 0.0);
}

void MultifrontalCholesky::find_places(const SparseMatrix& lower) {
  entries_begin_.assign(1, 0);
  entry_.clear();
  place_.clear();
  for (const Node& node : tree_.nodes) {
    for (int c = 0; c < node.columns; ++c) {
      const int column = tree_.column_at[index(node.first_column + c)];
      for (int e = lower.outerIndexPtr()[column]; e < lower.outerIndexPtr()[column + 1]; ++e) {
        const int row = tree_.row_in_front(node, tree_.position[index(lower.innerIndexPtr()[e])]);
        entry_.push_back(e);
        place_.push_back(c * stride(node) + row);
      }
    }
    entries_begin_.push_back(entry_.size());
  }
}

bool MultifrontalCholesky::factor(const SparseMatrix& lower) {
  for (std::size_t k = 0; k < tree_.nodes.size(); ++k) {
    const Node& node = tree_.nodes[k];
    assemble(k, lower.valuePtr());
    if (!kernels_.factor(entries(k), stride(node), node.rows, node.columns, work_.data())) return false;
    keep_columns(k);
  }
  return true;
}

/// The node's front: its entries of the matrix, and what its children leave.
void MultifrontalCholesky::assemble(std::size_t node, const double* values) {
  const Node& parent = tree_.nodes[node];
  double* const front = entries(node);
  std::fill(front, front + parent.rows * stride(parent), 0.0);
  for (std::size_t e = entries_begin_[node]; e < entries_begin_[node + 1]; ++e) {
    front[place_[e]] = values[entry_[e]];
  }
  for (std::size_t c = parent.first_child; c < parent.end_child; ++c) {
    const std::size_t child = index(tree_.children[c]);
    add_child(tree_.nodes[child], entries(child), parent, front);
  }
}

void MultifrontalCholesky::add_child(const Node& child, const double* from, const Node& parent, double* to) const {
  const int* const target = tree_.target.data() + child.below;
  const std::ptrdiff_t rows = child.rows_below();
  from += child.columns * (stride(child) + 1);
  for (std::ptrdiff_t c = 0; c < rows; ++c, from += stride(child)) {
    double* const column = to + target[c] * stride(parent);
    for (std::ptrdiff_t r = c; r < rows; ++r) column[target[r]] += from[r];
  }
}

void MultifrontalCholesky::keep_columns(std::size_t node) {
  const Node& of = tree_.nodes[node];
  cholesky::keep_columns(entries(node), stride(of), of.rows, of.columns, factor_.data() + fronts_[node].factor);
}

void MultifrontalCholesky::solve(Vector& x) {
  for (std::size_t i = 0; i < x_.size(); ++i) x_[index(tree_.position[i])] = x(static_cast<Index>(i));
  const auto gather = [&](const Node& node) {
    std::copy_n(x_.data() + node.first_column, node.columns, part_.data());
    for (int r = 0; r < node.rows_below(); ++r) {
      part_[index(node.columns + r)] = x_[index(tree_.below[node.below + index(r)])];
    }
  };
  for (std::size_t k = 0; k < tree_.nodes.size(); ++k) {
    const Node& node = tree_.nodes[k];
    gather(node);
    kernels_.solve_lower(factor_.data() + fronts_[k].factor, node.rows, node.columns, part_.data());
    std::copy_n(part_.data(), node.columns, x_.data() + node.first_column);
    for (int r = 0; r < node.rows_below(); ++r) {
      x_[index(tree_.below[node.below + index(r)])] = part_[index(node.columns + r)];
    }
  }
  for (std::size_t k = tree_.nodes.size(); k-- > 0;) {
    const Node& node = tree_.nodes[k];
    gather(node);
    kernels_.solve_transposed(factor_.data() + fronts_[k].factor, node.rows, node.columns, part_.data());
    std::copy_n(part_.data(), node.columns, x_.data() + node.first_column);
  }
  for (std::size_t i = 0; i < x_.size(); ++i) x(static_cast<Index>(i)) = x_[index(tree_.position[i])];
}

/// The factors are fitted to times of walls and piles of 14 to 18,804 contacts, in units of 0.2 ns: four
/// multiplications of the dense kernels, what the assembly of a front does for each of its entries, and what a front
/// takes whatever its size.
SparseFactorization::Cost MultifrontalCholesky::cost() const {
  Cost cost;
  for (const Node& node : tree_.nodes) {
    const auto all = static_cast<double>(node.rows);
    const auto below = static_cast<double>(node.rows_below());
    const double multiplications = (all * all * all - below * below * below) / 6;
    cost.factor += multiplications / 4 + 1.75 * all * all + 500;
    cost.solve += 1.25 * (all * all - below * below) + 350;
  }
  return cost;
}

}  // namespace

std::unique_ptr<SparseFactorization> multifrontal_cholesky(IsaLevel level) {
  return std::make_unique<MultifrontalCholesky>(level);
}

}  // namespace lcpbench
