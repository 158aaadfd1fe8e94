#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "native/contacts/contact_arrays.h"
#include "native/contacts/growing_vector.h"

namespace lcpbench {

/// A contact problem as engines take it. Points into the problem where its matrices are dense, and must not be moved
/// once loaded. Its memory only grows.
///
/// The engines' bounds on rounding are norms over all coordinates. Where the diagonal of G spans more than 2^50, they
/// therefore get coordinates in other units: powers of two S for which S G S has a diagonal within [1, 4). The problem
/// for the velocity S^-1 v has bit for bit the same M and q.
struct ContactInput {
  contact_lemke::Input input;
  GrowingVector v, mu;
  GrowingVector units;    ///< the diagonal of S; empty: the units of the problem
  GrowingVector N, D, G;  ///< copies: N and D if sparse, in other units or with an offset; G in other units
  std::vector<std::ptrdiff_t> friction_begin, offsets;  ///< first column in D of each contact, first row of each block
  std::vector<const double*> blocks;  ///< of G
  IslandNumbers islands;  ///< valid if input.island_of_contact is set; else all is one island
  bool is_one_island = false;  ///< set by the caller who knows that one island has all of the next problem
  double offset_speed = 0;  ///< of the coordinate that carries the offset
  GrowingVector compliance_n, compliance_t, offset_t, tangents;  ///< of soft contacts

  /// The coordinates of the engines: one more than the problem's where that has an offset.
  static Index coordinates(const ContactProblem& contact) { return contact.ngc() + (contact.has_offset() ? 1 : 0); }

  /// Takes the memory that load() needs for problems of up to these dimensions, but that of softness, which
  /// load_layout() takes. Touches none of it. @param ngc  see coordinates() @param directions  columns of D
  void reserve(Index ngc, Index nc, Index directions);
  /// @param contact must outlive what is made of `input`
  void load(const ContactProblem& contact);
  /// The part of load() that reads no matrix: dimensions, mu, friction directions per contact and softness.
  void load_layout(const ContactProblem& contact);
  /// Another velocity, in the units of the problem.
  void set_velocity(const Vector& velocity);

 private:
  void load_softness(const ContactProblem& contact);
  void find_islands(const ContactProblem& contact);
  void choose_units(const Inertia& inertia);
  void load_jacobians(const ContactProblem& contact);
  void load_inertia(const Inertia& inertia);
  void load_blocks(const Inertia& inertia);
};

}  // namespace lcpbench
