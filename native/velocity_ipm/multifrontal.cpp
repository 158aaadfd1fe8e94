#include "native/velocity_ipm/multifrontal.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "native/kernels/cholesky_engine.h"
#include "native/velocity_ipm/assembly_tree.h"

namespace lcpbench {
namespace {

using Node = AssemblyTree::Node;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// Both factorizations. A front is one lower triangle, or two: that of the matrix and that of its transpose.
class Multifrontal final : public SparseFactorization, public UnsymmetricFactorization {
 public:
  Multifrontal(IsaLevel level, std::size_t triangles) : kernels_(cholesky::engine(level)), triangles_(triangles) {}

  void analyze(const SparseMatrix& lower) override;
  bool factor(const SparseMatrix& lower) override { return factor(lower.valuePtr(), nullptr); }
  bool factor(const double* lower, const double* upper) override;
  void solve(Vector& x) override;
  Cost cost() const override;

 private:
  /// Where a node's front and its columns of the factors stand. Fronts are columns of stride() entries.
  struct Front {
    std::size_t memory = 0;  // 0 or 1
    std::size_t begin = 0;   // in memory_[memory]
    std::size_t factor = 0;  // in factor_
  };

  static std::ptrdiff_t stride(const Node& node) { return node.rows + cholesky::kMargin; }
  static std::size_t size(const Node& node) { return static_cast<std::size_t>(stride(node) * stride(node)); }
  double* entries(std::size_t node, std::size_t triangle) {
    return memory_[fronts_[node].memory].data() + fronts_[node].begin + triangle * size(tree_.nodes[node]);
  }
  double* factor_of(std::size_t node, std::size_t triangle) {
    const Node& of = tree_.nodes[node];
    return factor_.data() + fronts_[node].factor + triangle * index(of.rows) * index(of.columns);
  }

  void place_fronts();
  void find_places(const SparseMatrix& lower);
  void assemble(std::size_t node, std::size_t triangle, const double* values);
  void add_child(const Node& child, const double* from, const Node& parent, double* to) const;
  bool eliminate(std::size_t node);

  const cholesky::Engine& kernels_;
  const std::size_t triangles_;
  AssemblyTree tree_;
  std::vector<Front> fronts_;                  // of each node
  std::array<std::vector<double>, 2> memory_;  // of the fronts at even and at odd depth, each a stack
  std::vector<double> factor_;                 // per node and triangle rows x columns, diagonal entries inverted
  std::vector<int> swaps_;                     // of each column: the row of its node that its own is exchanged with
  std::vector<std::size_t> entries_begin_;     // per node, in the next two
  std::vector<int> entry_;                     // of the matrix
  std::vector<std::ptrdiff_t> place_;          // in the front
  std::vector<double> work_;
  std::vector<double> x_;     // in the order of elimination
  std::vector<double> part_;  // of x, the rows of a front
};

void Multifrontal::analyze(const SparseMatrix& lower) {
  tree_ = assembly_tree(lower);
  place_fronts();
  find_places(lower);
  std::ptrdiff_t rows = 0;
  for (const Node& node : tree_.nodes) rows = std::max<std::ptrdiff_t>(rows, node.rows);
  work_.assign(triangles_ * static_cast<std::size_t>(cholesky::work_size(rows)), 0.0);
  swaps_.assign(tree_.position.size(), 0);
  x_.assign(tree_.position.size(), 0.0);
  part_.assign(static_cast<std::size_t>(rows), 0.0);
}

/// Children stand in one memory, their parent in the other, and both are stacks: when a parent is assembled its
/// children are the last ones in theirs, and go.
void Multifrontal::place_fronts() {
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
    factor += triangles_ * index(node.rows) * index(node.columns);
    used[front.memory] += triangles_ * size(node);
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

void Multifrontal::find_places(const SparseMatrix& lower) {
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

bool Multifrontal::factor(const double* lower, const double* upper) {
  for (std::size_t k = 0; k < tree_.nodes.size(); ++k) {
    assemble(k, 0, lower);
    if (triangles_ > 1) assemble(k, 1, upper);
    if (!eliminate(k)) return false;
  }
  return true;
}

/// One triangle of the node's front: its entries of the matrix, and what its children leave.
void Multifrontal::assemble(std::size_t node, std::size_t triangle, const double* values) {
  const Node& parent = tree_.nodes[node];
  double* const front = entries(node, triangle);
  std::fill(front, front + parent.rows * stride(parent), 0.0);
  for (std::size_t e = entries_begin_[node]; e < entries_begin_[node + 1]; ++e) {
    front[place_[e]] = values[entry_[e]];
  }
  for (std::size_t c = parent.first_child; c < parent.end_child; ++c) {
    const std::size_t child = index(tree_.children[c]);
    add_child(tree_.nodes[child], entries(child, triangle), parent, front);
  }
}

void Multifrontal::add_child(const Node& child, const double* from, const Node& parent, double* to) const {
  const int* const target = tree_.target.data() + child.below;
  const std::ptrdiff_t rows = child.rows_below();
  from += child.columns * (stride(child) + 1);
  for (std::ptrdiff_t c = 0; c < rows; ++c, from += stride(child)) {
    double* const column = to + target[c] * stride(parent);
    for (std::ptrdiff_t r = c; r < rows; ++r) column[target[r]] += from[r];
  }
}

bool Multifrontal::eliminate(std::size_t node) {
  const Node& of = tree_.nodes[node];
  double* const front = entries(node, 0);
  const bool is_regular =
      triangles_ == 1 ? kernels_.factor(front, stride(of), of.rows, of.columns, work_.data())
                      : kernels_.factor_lu(front, entries(node, 1), stride(of), of.rows, of.columns,
                                           swaps_.data() + of.first_column, work_.data());
  for (std::size_t t = 0; is_regular && t < triangles_; ++t) {
    cholesky::keep_columns(entries(node, t), stride(of), of.rows, of.columns, factor_of(node, t));
  }
  return is_regular;
}

void Multifrontal::solve(Vector& x) {
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
    for (int c = 0; c < node.columns && triangles_ > 1; ++c) {
      std::swap(part_[index(c)], part_[index(swaps_[index(node.first_column + c)])]);
    }
    kernels_.solve_lower(factor_of(k, 0), node.rows, node.columns, part_.data());
    std::copy_n(part_.data(), node.columns, x_.data() + node.first_column);
    for (int r = 0; r < node.rows_below(); ++r) {
      x_[index(tree_.below[node.below + index(r)])] = part_[index(node.columns + r)];
    }
  }
  for (std::size_t k = tree_.nodes.size(); k-- > 0;) {
    const Node& node = tree_.nodes[k];
    gather(node);
    kernels_.solve_transposed(factor_of(k, triangles_ - 1), node.rows, node.columns, part_.data());
    std::copy_n(part_.data(), node.columns, x_.data() + node.first_column);
  }
  for (std::size_t i = 0; i < x_.size(); ++i) x(static_cast<Index>(i)) = x_[index(tree_.position[i])];
}

/// The factors are fitted to times of walls and piles of 14 to 18,804 contacts, in units of 0.2 ns: four
/// multiplications of the dense kernels, what the assembly of a front does for each of its entries, and what a front
/// takes whatever its size.
Multifrontal::Cost Multifrontal::cost() const {
  Cost cost;
  for (const Node& node : tree_.nodes) {
    const auto all = static_cast<double>(node.rows);
    const auto below = static_cast<double>(node.rows_below());
    const double multiplications = (all * all * all - below * below * below) / 6;
    cost.factor += multiplications / 4 + 1.75 * all * all + 500;
    cost.solve += 1.25 * (all * all - below * below) + 350;
  }
  cost.factor *= static_cast<double>(triangles_);
  return cost;
}

}  // namespace

std::unique_ptr<SparseFactorization> multifrontal_cholesky(IsaLevel level) {
  return std::make_unique<Multifrontal>(level, 1);
}

std::unique_ptr<UnsymmetricFactorization> multifrontal_lu(IsaLevel level) {
  return std::make_unique<Multifrontal>(level, 2);
}

}  // namespace lcpbench
