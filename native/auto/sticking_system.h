#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/contact_problem.h"
#include "native/kernels/cholesky_engine.h"
#include "native/velocity_ipm/sparse_factorization.h"

namespace lcpbench {

/// A contact's columns [N_c, first half of D_c], on the coordinates of the blocks of the inertia that it touches. Of a
/// contact with mu = 0 its normal alone.
struct StickingColumns {
  std::size_t first = 0;  ///< of its impulses among those of all contacts
  int columns = 0;
  int size = 0;             ///< coordinates
  std::size_t rows = 0;     ///< where they are listed; contacts of the same blocks that follow each other share them
  std::size_t places = 0;   ///< where the entries of the matrix are listed that pairs of them add to; likewise
  std::size_t entries = 0;  ///< of its columns, `size` each
};

/// The columns A of all contacts, the inertia G, and the sparse matrix G + A W A', W a weight for each contact, with
/// its Cholesky factors. Where G is one block, such as a robot's, all is dense. Keeps its memory, and the order of
/// elimination where contacts touch the blocks that they touched in the last problem.
class StickingSystem {
 public:
  StickingSystem();

  /// O(nonzeros of N and D), and where contacts touch other blocks than in the last problem, a symbolic factorization.
  /// @param contact with the inertia as blocks or as one matrix G; must outlive the next load
  void load(const ContactProblem& contact);

  const std::vector<StickingColumns>& contacts() const { return contacts_; }
  /// Columns of all contacts.
  std::size_t column_count() const;
  /// Of a coordinate, the diagonal of G.
  double mass(Index coordinate) const { return 1 / inverse_diagonal_(coordinate); }
  /// An estimate of 1 / (a'G*a) for a contact's normal a, by the diagonal of G alone; 0 where nothing moves.
  double strength(std::size_t contact) const { return strength_[contact]; }

  // Of vectors of coordinates, in the order of the problem. Nothing from here on allocates.

  /// products := A'x
  void multiply(const Vector& x, double* products);
  /// to += A factors
  void add_columns(const double* factors, Vector& to);
  /// to += G* impulse; impulse is used up. Factors G, once after each load.
  void add_response(Vector& impulse, Vector& to);
  /// from -= G x
  void subtract_inertia(const Vector& x, Vector& from) const;
  /// x := D^-1 x, D the diagonal of G: about the velocity that an impulse x gives
  void respond_by_diagonal(Vector& x) const { x.array() *= inverse_diagonal_.array(); }

  /// @param weights by contact; of zero: the contact is left out @returns false when the factorization breaks down
  bool factor(const std::vector<double>& weights);
  /// x := (G + A W A')^-1 x
  void solve(Vector& x);

 private:
  void take_blocks();
  bool has_last_sizes() const;
  void find_columns();
  void analyze();
  int place_of(int i, int j) const;
  bool fill_columns();
  bool shares_rows(std::size_t contact) const;
  bool factor_one(const std::vector<double>& weights);
  bool is_one() const { return blocks_.size() == 1; }
  const double* columns(const StickingColumns& contact) const { return entries_.data() + contact.entries; }
  const int* rows(const StickingColumns& contact) const { return rows_.data() + contact.rows; }

  const cholesky::Engine& kernels_;
  const ContactProblem* contact_ = nullptr;
  std::vector<const Matrix*> blocks_;  ///< of G
  std::vector<Index> block_sizes_;     ///< of the last problem whose columns were found
  std::vector<int> block_of_;          ///< of each coordinate
  std::vector<StickingColumns> contacts_;
  std::vector<int> rows_;
  std::vector<double> entries_;
  std::vector<double> strength_;                     ///< by contact
  Vector inverse_diagonal_;                          ///< of G
  std::vector<Matrix> inertia_factors_;              ///< of the blocks: L in the lower triangle, G_b = L L'
  bool has_inertia_factors_ = false;                 ///< they are those of the problem
  std::unique_ptr<SparseFactorization> factors_;
  SparseMatrix matrix_;                       ///< lower triangle, in the order of elimination
  std::vector<int> order_;                    ///< of each coordinate, its place there
  std::vector<int> inertia_places_, places_;  ///< in the values of matrix_: of the blocks' lower triangles, of pairs
  std::vector<int> local_;                    ///< of each coordinate, its number among those of a contact, or -1
  std::vector<double> product_;               ///< A W A' of contacts that share their rows
  Vector part_;                               ///< entries of a vector at a contact's coordinates
  Vector ordered_;
  std::vector<double> dense_, weighted_, work_,
      dense_factors_;  ///< of one block: the matrix, A W^(1/2), scratch, factors
};

}  // namespace lcpbench
