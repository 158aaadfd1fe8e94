#pragma once

#include <vector>

#include "core/answer/contact_scale.h"
#include "core/contact_problem.h"
#include "core/islands.h"
#include "native/answer_test/beside_rows.h"
#include "native/contacts/contact_arrays.h"
#include "native/kernels/cholesky_engine.h"

namespace lcpbench {

/// The measure of AnswerTest for contacts in double, with a bound on its rounding. Of G by blocks no dense matrix over
/// all of them is made.
class ContactTest {
 public:
  ContactTest();

  /// @param contact whose inertia is not given by factors; must stay as it is until the next load
  /// @param numbers of its islands; null or empty: they are found
  void load(const ContactProblem& contact, const IslandNumbers* numbers);
  void set_velocity(const Vector& v) {
    v_ = v;
    scales_.clear();
  }

  const IslandNumbers& islands() const { return numbers_; }

  /// Sets the lambdas of z to the least that its impulses allow and evaluates the answer, with a bound on its rounding:
  /// see native/contact_lemke/completion.h, whose bound this is, with sums over a block in place of the island.
  /// O(nonzeros, and the squares of the blocks' orders); the first time after load() their cubes. Allocates nothing.
  contact_lemke::Residual complete(Vector& z);

  /// A lower bound on the velocity residual of the answer that was completed last. If that is above what is allowed, 113
  /// bits cannot accept the answer.
  double least() const { return least_; }

 private:
  struct Island {
    double worst = 0, certain = 0, scale = 0;
    double rounding = 0;                       ///< the largest of its rows
    double rounded = 0, lost = 0, moved = 0;  ///< within the block that responds
    bool presses = false;
    bool is_known = true;
  };

  /// A block of G and its Cholesky factor L, or the given G*.
  struct Block {
    const Matrix* given;
    bool is_inverse;        ///< the given G*
    Index first;            ///< coordinate
    Index factor;           ///< first number of L
    bool is_known = false;  ///< rounding takes a small part of what L solves, or of what G* is multiplied by

    Index order() const { return given->rows(); }
  };

  /// What is known of one generalized coordinate.
  struct Coordinate {
    double velocity = 0;  ///< v+
    double bound = 0;     ///< on the error of v+
    double reach = 0;     ///< the root of its diagonal entry of G*
    double root = 0;      ///< and of G, where that is given
  };

  /// A row of w, that of column j of J, with what the test needs of it.
  struct Row {
    Index column = 0;       ///< j, in [N D]
    double w = 0;           ///< J_j'v+, with offset and compliance, without lambda
    double rounding = 0;    ///< bound on its error
    double reach = 0;       ///< at least the root of M_jj
    double compliance = 0;  ///< its part of M_jj
  };

  contact_lemke::Residual measure(Vector& z);
  void measure_scales();
  void factor(Block& block);
  void measure_inverse(Block& block);
  bool factor_by_kernels(const Matrix& given, double* L, double* reach);
  void solve_lower(const Block& block, double* x) const;
  void solve_transposed(const Block& block, double* x) const;
  void add_impulses(const Vector& z);
  void sum_exactly(const Vector& z);
  void respond(const Block& block, double terms_of_sum);
  void solve(const Block& block, double sums);
  void multiply(const Block& block, double sums);
  void bound_by_residual(const Block& block, double terms);
  void measure_friction(Index contact, const Row& normal, Vector& z);
  Row row_of(Index column, const Beside& beside) const;
  void offer(const Row& row, double w, double z, Island& island);
  double diagonal_of(const Row& row);

  const cholesky::Engine& kernels_;
  const ContactProblem* contact_ = nullptr;
  ContactLayout layout_;
  IslandNumbers numbers_;
  Vector v_;
  std::vector<ContactScale<double>> scales_;  // of the islands; empty: not yet measured for v_
  std::vector<Block> blocks_;
  bool is_factored_ = false;  // the blocks, since load()
  std::vector<double> factors_;         // of all blocks
  std::vector<double> dense_, work_;    // to factor a large block by the kernels
  std::vector<double> part_;            // scratch: the coordinates of a block
  std::vector<double> impulse_, terms_;  // on each coordinate, and the sum of the magnitudes of its terms
  std::vector<long double> exact_;       // impulse_, where the first bound is too large; else empty
  std::vector<Coordinate> coordinates_;
  std::vector<Island> islands_;
  std::vector<Row> rows_;  // of the friction directions of one contact
  double least_ = 0;
};

}  // namespace lcpbench
