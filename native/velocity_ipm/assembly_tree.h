#pragma once

#include <vector>

#include "core/types.h"

namespace lcpbench {

/// The plan of a multifrontal factorization of a matrix with a symmetric pattern. Each node is a group of columns that
/// are eliminated together. The front of a node is a dense matrix: it has the node's columns, and the rows below them
/// that the elimination changes. The Schur complement in these rows is added to the front of the parent.
struct AssemblyTree {
  struct Node {
    int first_column = 0;  ///< in the order of elimination; a node's columns follow each other
    int columns = 0;
    int rows = 0;                 ///< of the front: the node's columns and the rows below them
    int parent = 0;               ///< a later node; -1: none
    std::size_t below = 0;        ///< where the rows below its columns begin in AssemblyTree::below and ::target
    std::size_t first_child = 0;  ///< where its children begin in AssemblyTree::children
    std::size_t end_child = 0;

    int rows_below() const { return rows - columns; }
  };

  std::vector<Node> nodes;    ///< in postorder: children before parents, each subtree contiguous
  std::vector<int> children;  ///< nodes
  std::vector<int> below;     ///< rows of the fronts, increasing, in the order of elimination
  std::vector<int> target;    ///< the place of each of these rows in the parent's front
  std::vector<int> position;  ///< of each row of the matrix, in the order of elimination
  std::vector<int> column_at;  ///< the inverse of `position`

  /// The place of `row` (in the order of elimination) in the front of a node. @pre the front has this row
  int row_in_front(const Node& node, int row) const;
};

/// An elimination order for a sparse symmetric matrix, by approximate minimum degree: entry k is the row that is
/// eliminated k-th. [Amestoy, Davis, Duff 1996; Eigen::AMDOrdering]
/// @param lower  the lower triangle (the values are not looked at)
std::vector<int> elimination_order(const SparseMatrix& lower);

/// The assembly tree of a matrix with rows in an order of elimination. The tree's own order may be another one with
/// the same fill. Columns are grouped if one front, with its added zeros, costs no more than two. O(nnz(L) log n) time.
/// [Liu 1990, The role of elimination trees in sparse factorization; Duff, Reid 1983]
/// @param lower  lower triangle with all of the diagonal, compressed, columns sorted
AssemblyTree assembly_tree(const SparseMatrix& lower);

}  // namespace lcpbench
