#include "native/velocity_ipm/assembly_tree.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstddef>
#include <numeric>

namespace lcpbench {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

/// The lists of ints of(0), of(1), ..., one behind the other in `entries`.
struct Lists {
  std::vector<std::size_t> begin;
  std::vector<int> entries;

  auto of(int i) const { return std::pair(entries.begin() + offset(i), entries.begin() + offset(i + 1)); }

 private:
  std::ptrdiff_t offset(int i) const { return static_cast<std::ptrdiff_t>(begin[index(i)]); }
};

/// Puts each i into list number list_of[i], in increasing order; an i with list_of[i] = -1 into none. A counting sort.
Lists invert(const std::vector<int>& list_of, std::size_t count) {
  Lists lists;
  lists.begin.assign(count + 1, 0);
  for (const int k : list_of) {
    if (k >= 0) ++lists.begin[index(k) + 1];
  }
  std::partial_sum(lists.begin.begin(), lists.begin.end(), lists.begin.begin());
  lists.entries.resize(lists.begin.back());
  std::vector<std::size_t> next(lists.begin.begin(), lists.begin.end() - 1);
  for (std::size_t i = 0; i < list_of.size(); ++i) {
    if (list_of[i] >= 0) lists.entries[next[index(list_of[i])]++] = static_cast<int>(i);
  }
  return lists;
}

/// The symbolic factorization of Eigen. `parent` is the elimination tree: the row of the first entry below the diagonal
/// in each column of L, -1 if there is none. `counts` has the number of entries in each column of L, with the diagonal.
struct Symbolic : Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> {
  explicit Symbolic(const SparseMatrix& lower) {
    analyzePattern(lower);
    parent.assign(m_parent.data(), m_parent.data() + m_parent.size());
    for (const int below : m_nonZerosPerCol) counts.push_back(below + 1);
  }
  std::vector<int> parent;
  std::vector<int> counts;
};

/// The rough cost of a front in nanoseconds: a constant, and parts for the multiplications of its elimination, for the
/// entries of L in the solutions, and for the entries that are added to the parent.
double cost(double columns, double rows) {
  constexpr double kFront = 60;
  constexpr double kMultiplication = 0.1;
  constexpr double kFactorEntry = 0.6;
  constexpr double kPassedOn = 0.8;
  const double below = rows - columns;
  const auto sum_of_squares = [](double n) { return n * (n + 1) * (2 * n + 1) / 6; };
  return kFront + kMultiplication * (sum_of_squares(rows) - sum_of_squares(below)) +
         kFactorEntry * 0.5 * (rows * (rows + 1) - below * (below + 1)) + kPassedOn * 0.5 * below * (below + 1);
}

/// For each column the last column of its group. A column takes the groups of its children into its own group, where
/// one front is cheaper than two.
std::vector<int> group_columns(const std::vector<int>& parent, const std::vector<int>& counts) {
  const int n = static_cast<int>(parent.size());
  const Lists children = invert(parent, parent.size());
  std::vector<int> size(index(n), 1);
  std::vector<int> last(index(n));
  std::iota(last.begin(), last.end(), 0);
  std::vector<int> by_count;
  for (int j = 0; j < n; ++j) {
    const auto [begin, end] = children.of(j);
    by_count.assign(begin, end);
    std::stable_sort(by_count.begin(), by_count.end(),
                     [&](int a, int b) { return counts[index(a)] > counts[index(b)]; });
    const double below = counts[index(j)] - 1;
    for (const int child : by_count) {
      const double own = size[index(j)];
      const double others = size[index(child)];
      const double apart = cost(own, own + below) + cost(others, others + counts[index(child)] - 1);
      if (cost(own + others, own + others + below) > apart) continue;
      size[index(j)] += size[index(child)];
      last[index(child)] = j;
    }
  }
  for (int j = n; j-- > 0;) last[index(j)] = last[index(last[index(j)])];
  return last;
}

/// Nodes of a forest in postorder.
std::vector<int> postorder(const std::vector<int>& parent) {
  const Lists children = invert(parent, parent.size());
  std::vector<int> order;
  order.reserve(parent.size());
  std::vector<int> open;
  for (int node = 0; node < static_cast<int>(parent.size()); ++node) {
    if (parent[index(node)] < 0) open.push_back(node);
  }
  while (!open.empty()) {  // parents before children, reversed at the end
    const int node = open.back();
    open.pop_back();
    order.push_back(node);
    const auto [begin, end] = children.of(node);
    open.insert(open.end(), begin, end);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// Nodes with their columns, parents and children, and the order of elimination.
AssemblyTree skeleton(const std::vector<int>& parent, const std::vector<int>& last) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> group_of(index(n), -1);  // numbered by their last columns
  int groups = 0;
  for (int j = 0; j < n; ++j) {
    if (last[index(j)] == j) group_of[index(j)] = groups++;
  }
  std::vector<int> parent_group(index(groups), -1);
  for (int j = 0; j < n; ++j) {
    const int above = parent[index(j)];
    if (last[index(j)] == j && above >= 0)
      parent_group[index(group_of[index(j)])] = group_of[index(last[index(above)])];
  }
  for (int j = 0; j < n; ++j) group_of[index(j)] = group_of[index(last[index(j)])];
  const Lists columns = invert(group_of, index(groups));

  AssemblyTree tree;
  tree.nodes.resize(index(groups));
  tree.position.resize(index(n));
  const std::vector<int> order = postorder(parent_group);
  std::vector<int> node_of(index(groups));
  for (int k = 0; k < groups; ++k) node_of[index(order[index(k)])] = k;
  std::vector<int> parents(index(groups), -1);
  int next = 0;
  for (int k = 0; k < groups; ++k) {
    AssemblyTree::Node& node = tree.nodes[index(k)];
    const int above = parent_group[index(order[index(k)])];
    node.parent = parents[index(k)] = above < 0 ? -1 : node_of[index(above)];
    node.first_column = next;
    const auto [begin, end] = columns.of(order[index(k)]);
    for (auto column = begin; column != end; ++column) tree.position[index(*column)] = next++;
    tree.column_at.insert(tree.column_at.end(), begin, end);
    node.columns = next - node.first_column;
  }
  Lists children = invert(parents, index(groups));
  for (std::size_t k = 0; k < tree.nodes.size(); ++k) {
    tree.nodes[k].first_child = children.begin[k];
    tree.nodes[k].end_child = children.begin[k + 1];
  }
  tree.children = std::move(children.entries);
  return tree;
}

/// The rows below the columns of each node, from the matrix and the children.
void find_rows(const SparseMatrix& lower, AssemblyTree& tree) {
  std::vector<int> seen_by(tree.position.size(), -1);
  for (int k = 0; k < static_cast<int>(tree.nodes.size()); ++k) {
    AssemblyTree::Node& node = tree.nodes[index(k)];
    node.below = tree.below.size();
    const int end = node.first_column + node.columns;
    const auto reach = [&](int row) {
      if (row < end || seen_by[index(row)] == k) return;
      seen_by[index(row)] = k;
      tree.below.push_back(row);
    };
    for (int column = node.first_column; column < end; ++column) {
      for (SparseMatrix::InnerIterator entry(lower, tree.column_at[index(column)]); entry; ++entry) {
        reach(tree.position[index(static_cast<int>(entry.row()))]);
      }
    }
    for (std::size_t c = node.first_child; c < node.end_child; ++c) {
      const AssemblyTree::Node& child = tree.nodes[index(tree.children[c])];
      for (int r = 0; r < child.rows_below(); ++r) reach(tree.below[child.below + index(r)]);
    }
    node.rows = node.columns + static_cast<int>(tree.below.size() - node.below);
    std::sort(tree.below.begin() + static_cast<std::ptrdiff_t>(node.below), tree.below.end());
  }
}

void find_targets(AssemblyTree& tree) {
  tree.target.resize(tree.below.size());
  for (const AssemblyTree::Node& node : tree.nodes) {
    if (node.parent < 0) continue;
    const AssemblyTree::Node& parent = tree.nodes[index(node.parent)];
    for (int r = 0; r < node.rows_below(); ++r) {
      tree.target[node.below + index(r)] = tree.row_in_front(parent, tree.below[node.below + index(r)]);
    }
  }
}

}  // namespace

int AssemblyTree::row_in_front(const Node& node, int row) const {
  if (row < node.first_column + node.columns) return row - node.first_column;
  const auto begin = below.begin() + static_cast<std::ptrdiff_t>(node.below);
  return node.columns + static_cast<int>(std::lower_bound(begin, begin + node.rows_below(), row) - begin);
}

std::vector<int> elimination_order(const SparseMatrix& lower) {
  if (lower.rows() == 0) return {};
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(lower.selfadjointView<Eigen::Lower>(), order);
  return {order.indices().data(), order.indices().data() + order.size()};
}

AssemblyTree assembly_tree(const SparseMatrix& lower) {
  const Symbolic symbolic(lower);
  AssemblyTree tree = skeleton(symbolic.parent, group_columns(symbolic.parent, symbolic.counts));
  find_rows(lower, tree);
  find_targets(tree);
  return tree;
}

}  // namespace lcpbench
