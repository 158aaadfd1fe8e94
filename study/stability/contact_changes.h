#pragma once

#include <functional>
#include <vector>

#include "core/contact_problem.h"
#include "generators/random.h"

// Changes of a contact problem in place, each exact but for the rounding of products by what is no power of two.

namespace lcpbench {

/// Changes a Jacobian as a dense matrix; a sparse one stays sparse.
void change(Jacobian& J, const std::function<Matrix(const Matrix&)>& of_dense);

/// A product by a constant, or a division by one.
using EntryChange = std::function<double(double)>;

/// Multiplies G, or alpha of its factors, or divides G*.
void change_inertia(Inertia& inertia, const EntryChange& multiply, const EntryChange& divide);

/// Whether a coordinate of rigid bodies, six each, is an angular velocity.
inline bool is_angular(Index coordinate) { return coordinate % 6 >= 3; }

/// Another unit of length for rigid bodies: linear velocities, offsets and lever arms once, moments of inertia twice.
/// @pre the inertia is that of rigid bodies
void change_length_of_bodies(ContactProblem& contact, const EntryChange& multiply, const EntryChange& divide);

/// Multiplies the columns of N by one factor for each contact, its columns of D and its offset by the same.
void scale_contacts(ContactProblem& contact, const Vector& factors);

/// The contacts in the order given, each with its friction columns; may leave some out or repeat some.
void select_contacts(ContactProblem& contact, const std::vector<Index>& order);

/// The friction columns of contact i moved by[i] places to the front, around. Opposite columns stay in their pairs.
void shift_directions(ContactProblem& contact, const std::vector<int>& by);

/// Gives the last contact another normal column and other friction columns. @param directions  one of each pair
void move_last_contact(ContactProblem& contact, const Vector& normal, const Matrix& directions);

/// Every block of G, or G*, has a Cholesky factorization. Factors count as definite.
bool has_definite_inertia(const Inertia& inertia);

/// Moves numbers to a neighbouring double, up or down as drawn. A second one with the same draws and `forth` false,
/// called in the same order, moves them back. Zeros stay.
class Nudge {
 public:
  Nudge(DrawSequence draws, bool forth) : draws_(draws), forth_(forth) {}

  void operator()(double& x);
  void vector(Vector& x);
  void matrix(Matrix& A);
  void symmetric(Matrix& A);
  /// v, N, D with its columns in opposite pairs, mu, the inertia as it is given, and b.
  void contact(ContactProblem& contact);

  /// The largest relative change so far: 2^-52 at most, but for denormal numbers.
  double largest_change() const { return largest_change_; }

 private:
  void inertia(Inertia& inertia);
  void directions(ContactProblem& contact);

  DrawSequence draws_;
  bool forth_;
  double largest_change_ = 0;
};

}  // namespace lcpbench
