#pragma once

#include <vector>

#include "core/types.h"

namespace lcpbench {

/// What is eliminated together, and what comes of it. A node's front is the dense symmetric matrix of its columns and
/// of the rows below them that their elimination reaches; what elimination leaves of these goes to the parent's front.
struct AssemblyTree {
  struct Node {
    int first_column = 0;  ///< in the order of elimination; a node's columns follow each other
    int columns = 0;
    int rows = 0;                 ///< of the front: columns and rows below them
    int parent = 0;               ///< a later node; -1: none
    std::size_t below = 0;        ///< where its rows below begin in AssemblyTree::below and ::target
    std::size_t first_child = 0;  ///< where its children begin in AssemblyTree::children
    std::size_t end_child = 0;

    int rows_below() const { return rows - columns; }
  };

  std::vector<Node> nodes;    ///< children before parents, and the subtree of each without a gap
  std::vector<int> children;  ///< nodes
  std::vector<int> below;     ///< rows of the fronts, increasing, in the order of elimination
  std::vector<int> target;    ///< the same rows' place in the parent's front
  std::vector<int> position;  ///< of each row of the matrix in the order of elimination

  /// The row of the front where `row` (in the order of elimination) stands. @pre it is one of them
  int row_in_front(const Node& node, int row) const;
};

/// Of Cholesky's factorization of a matrix in the order given, or in one with the same fill: columns are put together
/// where the fronts' cost becomes smaller. O(nnz(L)) time.
/// [Liu 1990, The role of elimination trees in sparse factorization; Duff, Reid 1983]
/// @param lower  lower triangle with all of the diagonal, compressed, columns sorted
AssemblyTree assembly_tree(const SparseMatrix& lower);

}  // namespace lcpbench
