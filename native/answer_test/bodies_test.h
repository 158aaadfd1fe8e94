#pragma once

#include <vector>

#include "core/answer/contact_scale.h"
#include "core/contact_problem.h"
#include "core/islands.h"
#include "core/quad.h"
#include "native/contacts/contact_arrays.h"
#include "native/kernels/cholesky_engine.h"

namespace lcpbench {

/// The measure of AnswerTest for contacts between separate bodies (BlockInertia), by what the contacts touch: no dense
/// matrix over all bodies. Every block of G is factored anew in each test, in the arithmetic of the test.
class BodiesTest {
 public:
  BodiesTest();

  /// @param contact with BlockInertia; must stay as it is until the next load
  /// @param numbers of its islands; null or empty: they are found
  void load(const ContactProblem& contact, const IslandNumbers* numbers);
  void set_velocity(const Vector& v) {
    v_ = v;
    scales_.clear();
  }

  const IslandNumbers& islands() const { return numbers_; }

  /// Sets the lambdas of z to the least that its impulses allow and evaluates the answer, with a bound on its rounding:
  /// see native/contact_lemke/completion.h, whose bound this is, with sums over a block in place of the island.
  /// O(nonzeros, and the cubes of the blocks' orders). Allocates nothing.
  contact_lemke::Residual complete_in_double(Vector& z) { return complete(z, double_); }
  contact_lemke::Residual complete_in_quad(Vector& z) { return complete(z, quad_); }

  /// Of complete_in_quad(), about, see BudgetedSolver::work(). It depends on the data alone.
  double work_in_quad() const { return work_in_quad_; }

  /// A lower bound on the velocity residual of the answer that was completed last. If that of double is above what is
  /// allowed, 113 bits cannot accept the answer.
  double least() const { return least_; }

 private:
  template <class Scalar>
  struct Island {
    Scalar worst, certain, scale;
    Scalar rounding;              ///< the largest of its rows
    Scalar rounded, lost, moved;  ///< within the block that responds
    bool presses;
    bool is_known;
  };

  /// Where a block begins: its first coordinate, and the first number of its factor.
  struct Place {
    Index first, factor, order;
  };

  struct Sizes {
    Index ngc = 0;
    Index factors = 0;  ///< numbers of all
    Index islands = 0;
    Index largest_block = 0;
    Index most_directions = 0;
  };

  template <class Scalar>
  struct Room {
    /// A row of w, that of column j of J, with what the test needs of it.
    struct Row {
      Index column = 0;     ///< j, in [N D]
      Scalar w = 0;         ///< J_j'v+, with offset and compliance, without lambda
      Scalar rounding = 0;  ///< bound on its error
      Scalar reach = 0;     ///< at least the root of M_jj
      Scalar compliance = 0;  ///< its part of M_jj
    };

    std::vector<Scalar> impulse, terms, u, bound, reach, root;  // per coordinate
    std::vector<Scalar> coordinates;  // three for each coordinate: v+, bound and reach
    std::vector<Scalar> factors;  // of all blocks
    std::vector<Scalar> inverse;  // scratch: four columns of the inverse of the largest block
    std::vector<double> dense, work;      // to factor a large block by the kernels for double
    std::vector<Island<Scalar>> islands;
    std::vector<Row> rows;  // of the friction directions of one contact
    double roundoff = 0;

    /// Takes the memory, which is not touched before resize(): 113 bits are rarely asked for.
    void reserve(const Sizes& sizes);
    void resize(const Sizes& sizes);
    /// visit(vector, size) for every vector with the size that it needs.
    template <class Visit>
    void for_each_vector(const Sizes& sizes, Visit&& visit);
  };

  void measure_scales();
  template <class Scalar>
  bool factor_and_respond(const Matrix& block, const Place& place, Room<Scalar>& room) const;
  bool respond_by_kernels(const Matrix& block, double* L, double* reach, double* x, Room<double>& room) const;
  template <class Scalar>
  void offer(const typename Room<Scalar>::Row& row, Scalar w, double z, Island<Scalar>& island,
             Room<Scalar>& room) const;
  template <class Scalar>
  Scalar diagonal_of(const typename Room<Scalar>::Row& row, Room<Scalar>& room) const;
  template <class Scalar>
  contact_lemke::Residual complete(Vector& z, Room<Scalar>& room);
  template <class Scalar>
  void add_impulses(const Vector& z, Room<Scalar>& room) const;
  template <class Scalar>
  void respond(const Matrix& block, const Place& place, Scalar sums, Room<Scalar>& room) const;
  template <class Scalar>
  void show_velocity(Room<Scalar>& room) const;
  template <class Scalar>
  void measure_friction(Index contact, const typename Room<Scalar>::Row& normal, Vector& z, Room<Scalar>& room) const;

  const cholesky::Engine& kernels_;
  const ContactProblem* contact_ = nullptr;
  ContactLayout layout_;
  IslandNumbers numbers_;
  Vector v_;
  std::vector<ContactScale<double>> scales_;  // of the islands; empty: not yet measured for v_
  Sizes sizes_;
  std::vector<Place> places_;  // of the blocks
  Room<double> double_;
  Room<Quad> quad_;
  double work_in_quad_ = 0;
  double least_ = 0;
};

}  // namespace lcpbench
