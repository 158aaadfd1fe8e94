#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/contact_problem.h"
#include "core/quad.h"
#include "native/answer_test/farkas_support.h"

namespace lcpbench {

/// Whether contacts with possibly singular inertia, or with an offset b, have a solution at all.
///
/// No impulse moves what X' (of G = X diag(alpha) X'; G* where that is given) maps to zero. With K the edges of all
/// friction cones, N_c + mu_c D_ct, or the normals alone where there is no friction:
///
/// - some y with K'(v + X y) >= 0: there is a solution [Cottle, Pang, Stone 1992, 3.8: copositive-plus M]
/// - some u >= 0 with X'N u = 0 and v'N u < 0: there is none. Without friction one of the two holds. [Farkas 1902]
///
/// Both are decided by the linear program min v'K u, X'K u = 0, sum u = 1, u >= 0, by the simplex method in double. It
/// decides where the dual solution y satisfies all inequalities by more than any rounding, or where the u of the exact
/// system of the last basis is positive and falls by more than its computed neighbour may be off. Else 113 bits decide.
/// That there is no solution has to be proven there too, for the data as they are (FarkasSupport). For a solution a
/// value of the size of rounding counts as zero, unless small pivots enlarge the rounding: then nothing is decided. X
/// of full row rank reaches all: there is a solution.
///
/// An offset is the speed 1 of one more coordinate, which nothing reaches, and b its row of N. X is then I where G is
/// given, which is regular. A velocity at which all edges separate is then looked for before the linear program, and for
/// longer before 113 bits. In a pile the linear program is nearly singular, and takes seconds in 113 bits; this search
/// often decides in double.
class ContactSolvability {
 public:
  enum class Finding { kSolvable, kUnsolvable, kUnknown };
  /// What the caller has seen: an answer, or a ray. It decides what is looked for first.
  enum class Expected { kSolvable, kUnsolvable };

  /// Whether the inertia is given in a form that may be singular, or an offset is negative: else there always is a
  /// solution, and nothing else may be called.
  static bool is_asked(const ContactProblem& contact);

  /// Room for this problem and all that are not larger. Allocates.
  void reserve(const ContactProblem& contact);

  /// @param contact must stay as it is until the next load, v apart. Allocates where there is no room, or an offset.
  void load(const ContactProblem& contact);

  /// Allocates nothing. O(factors (factors + edges)) per step of the simplex method, and as many steps.
  /// @param v before the impact (ngc) @param deadline_s on wall_clock_s(): kUnknown after it
  Finding decide(const double* v, double deadline_s, Expected expected = Expected::kSolvable);

  /// After kUnknown with friction: whether a path in 113 bits that ended in a solution and misses it by this much,
  /// relative to the speed, tells that there is one. The speed that no impulse reaches decides that, and may be less.
  bool is_confirmed_by(double missed);

  /// The u (nc) of the last decide() that found kUnsolvable, rounded to doubles.
  void write_proof(Eigen::Ref<Vector> u) const;

 private:
  /// A generator of a friction cone: N_contact + factor D_direction.
  struct Edge {
    Index contact = 0;
    Index direction = -1;  ///< -1: N_contact alone
    double factor = 0;
  };
  template <class Scalar>
  struct Program;
  /// Of the least v'K u. kAlwaysPositive: for every v. kNegative: proven, for the normals alone.
  /// kNegativeInDouble: by more than rounding is likely to do.
  enum class Sign { kAlwaysPositive, kPositive, kZero, kNegative, kNegativeInDouble, kUnknown };

  /// Entry (i, k) of X, or of a basis of its range with ones in some rows.
  double reach(Index i, Index k, double) const { return (*X_)(i, k); }
  Quad reach(Index i, Index k, Quad) const { return range_[static_cast<std::size_t>(i * rank_ + k)]; }
  /// v; in 113 bits v minus the combination of the vectors of that basis that equals v in the rows of the pivots.
  double speed(Index i, double) const { return v_[i]; }
  Quad speed(Index i, Quad) const { return unreached_v_[static_cast<std::size_t>(i)]; }
  Index reach_size(double) const { return X_->cols(); }
  Index reach_size(Quad) const { return rank_; }

  void add_coordinate(const ContactProblem& contact);
  void find_range();
  void find_unreached_velocity();
  bool is_reached(const Edge& edge) const;
  bool drop_satisfied_edges();
  void find_edges();
  void find_normals();
  void find_column_exponents();
  template <class Scalar>
  void find_exponents();
  static bool is_solvable(Sign sign);
  Finding finding_of_normals(double deadline_s);
  Sign sign_of_cones(double deadline_s);
  Sign sign_in_quad(double deadline_s);
  Sign sign_beyond_double(double deadline_s);
  Sign sign_of_normals(double deadline_s);
  void keep_basic_edges();
  template <class Scalar>
  Sign sign_of_least(Scalar* storage, double deadline_s);
  template <class Scalar>
  void fill(Program<Scalar>& program);
  template <class Scalar>
  void write_costs(Program<Scalar>& program);
  template <class Scalar>
  bool pivot_to_end(Program<Scalar>& program, double deadline_s);
  template <class Scalar>
  void note_pivot(const Program<Scalar>& program, Index row, Index column);
  template <class Scalar>
  void drop_artificial(Program<Scalar>& program);
  bool finds_separation(double deadline_s, Index sweeps);
  void project_on_edge(Index j, double beyond);
  bool separates_all() const;
  bool lifts_all(const Program<double>& program, bool from_v);
  bool lifts_all(const Program<Quad>& program, Quad rounding) const;
  void load_basis(const Program<double>& program);
  bool proves_unsolvable(const Program<double>& program);
  bool proves_unsolvable(const Program<Quad>& program, Quad noise);
  template <class Scalar>
  Scalar noise_of_cost(const Program<Scalar>& program, Index j) const;
  bool holds_to_rounding(const Program<Quad>& program, Quad rounding);
  Quad value_in_data(const Program<Quad>& program, Quad noise) const;
  template <class Scalar>
  Scalar terms_of_least(const Program<Scalar>& program) const;
  template <class Scalar>
  void take_proof(const Program<Scalar>& program);

  const ContactProblem* contact_ = nullptr;
  const double* v_ = nullptr;
  const Matrix* X_ = nullptr;     // or G*
  ContactProblem with_offset_;    // what contact_, v_ and X_ are where there is an offset
  Vector v_with_offset_;
  Matrix X_with_offset_;
  bool reaches_all_velocities_ = false;  // there is an offset, and G is given by its entries
  bool is_reach_formed_ = true;          // X_with_offset_ holds what it says
  bool always_solvable_ = false;  // whatever v
  bool has_friction_ = false;
  bool of_normals_ = false;           // edges_ are normals
  std::vector<Edge> edges_;           // of the cones, or the normals alone
  std::vector<int> row_exponent_;     // by column of X: powers of two that bring entries to about one
  std::vector<int> column_exponent_;  // by edge
  int cost_exponent_ = 0;
  std::vector<Quad> costs_, cost_terms_;  // by edge, in 113 bits: v'K, scaled, and the magnitudes it adds up
  std::vector<double> row_scale_;         // 2^row_exponent_
  std::vector<Index> basis_;              // by row: an edge, or their number + the row of an artificial variable
  Vector proof_;                          // nc
  std::vector<Index> support_;            // the normals that have part in it
  FarkasSupport farkas_support_;
  Vector lift_, lift_terms_;            // ngc: X y and a bound on its terms
  Vector edge_norms_, edge_shares_;     // edges, with an offset: see finds_separation()
  Vector coordinate_size_;              // ngc: the largest scaled entry of X in the row
  Matrix basis_columns_, basis_terms_;  // of the last basis in double, by column, and the magnitudes they add up
  Vector basis_costs_, basis_cost_terms_;
  std::unique_ptr<double[]> double_;
  std::unique_ptr<Quad[]> quad_;
  // The range of X, once it was asked for.
  bool has_range_ = false;
  Index rank_ = 0;
  Quad least_pivot_ = 1;           // of its elimination and of the last program, relative to the largest entries
  Quad least_range_pivot_ = 1;     // of its elimination
  std::vector<Quad> range_;        // ngc x rank_ by rows
  std::vector<Index> pivot_rows_;  // rank_: coordinates in which exactly one of its vectors is not zero
  std::vector<Quad> unreached_v_;  // ngc
  std::vector<int> unit_;          // ngc: powers of two that bring the rows of X to about one
  std::size_t room_ = 0;
};

}  // namespace lcpbench
