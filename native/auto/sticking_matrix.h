#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "native/auto/sticking_graph.h"
#include "native/velocity_ipm/cholesky_engine.h"
#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// The sparse matrix G + A W A' of a StickingGraph, A its columns and W a weight for each contact, with its Cholesky
/// factors. Where the graph is one body it is a dense one, which has no order to find.
class StickingMatrix {
 public:
  StickingMatrix();

  /// Finds the order of elimination and takes the memory. @param ngc the sum of the bodies' sizes
  void analyze(const StickingGraph& graph, Index ngc);
  /// Of each body, its first coordinate in the order of elimination.
  std::vector<int> places() const;

  /// Takes the memory that factor() needs for contacts as long as these.
  void take_room(const StickingGraph& graph);

  /// Allocates nothing. @param graph with the bodies and couplings of analyze() and its places
  /// @param weights by contact; of zero: the contact is left out @returns false when the factorization breaks down
  bool factor(const StickingGraph& graph, const std::vector<double>& weights);
  /// x := (G + A W A')^-1 x, in the order of elimination and padded.
  void solve(Vector& x);

 private:
  /// A body in the order of elimination.
  struct Place {
    int first = 0;                         ///< its first coordinate
    int rank = 0;                          ///< its number
    std::size_t below = 0, end_below = 0;  ///< bodies coupled with it and eliminated later, in below_
  };
  struct Below {
    int body = 0;
    int skip = 0;  ///< rows of a column of the first body's that stand between its own and those of this one
  };

  void place_bodies(const StickingGraph& graph, const SparseMatrix& coupled);
  void lay_out(const StickingGraph& graph, Index ngc);
  int skip(int body, int below) const;
  void order_parts(const StickingGraph& graph, const StickingColumns& contact);
  void add_contacts(const StickingGraph& graph, const std::vector<double>& weights, std::size_t first, std::size_t end);
  void scatter(std::ptrdiff_t stride);
  bool factor_one(const StickingGraph& graph, const std::vector<double>& weights);

  std::unique_ptr<SparseFactorization> factors_;
  std::vector<Place> places_;  ///< of each body
  std::vector<Below> below_;
  SparseMatrix matrix_;  ///< lower triangle, in the order of elimination
  const cholesky::Engine& kernels_;
  std::vector<StickingPart> ordered_;  ///< of one contact, in the order of elimination
  std::vector<double> columns_;    ///< of contacts that touch the same bodies, times the roots of their weights
  std::vector<double> product_, work_;
  std::vector<double> one_;   ///< factors of the matrix of one body
  std::ptrdiff_t order_ = 0;  ///< of one_; 0: there are more bodies
};

}  // namespace lcpbench
