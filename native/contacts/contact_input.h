#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"
#include "core/islands.h"
#include "native/contacts/contact_arrays.h"
#include "native/contacts/growing_vector.h"

namespace lcpbench {

/// A contact problem as engines take it. Points into the problem where its matrices are dense, and
/// must not be moved once loaded. Its memory only grows.
struct ContactInput {
  contact_lemke::Input input;
  GrowingVector v, mu;
  GrowingVector units;    ///< of the coordinates that the engines see, see contact_units.h; empty: those of the problem
  GrowingVector N, D, G;  ///< only of sparse Jacobians, and of all in units
  std::vector<std::ptrdiff_t> friction_begin, offsets;
  std::vector<const double*> blocks;
  IslandNumbers islands;  ///< found only where the inertia does not couple all
  bool is_one_island = false;  ///< known of the next problem: all contacts and all coordinates are in it
  double offset_speed = 0;  ///< of the coordinate that carries the offset
  GrowingVector compliance_n, compliance_t, offset_t, tangents;  ///< of soft contacts

  /// The coordinates of the engines: one more than the problem's where that has an offset.
  static Index coordinates(const ContactProblem& contact) { return contact.ngc() + (contact.has_offset() ? 1 : 0); }

  /// Those of the problem that is loaded.
  Index moving() const { return input.has_offset ? input.ngc - 1 : input.ngc; }

  /// Takes all memory that loading a problem of up to these dimensions needs, and touches none of it.
  void reserve(Index ngc, Index nc, Index directions);
  /// @param contact must outlive what is made of `input`
  void load(const ContactProblem& contact);
  /// The same in coordinates of comparable units.
  void load_in_units(const ContactProblem& contact);
  /// Of load(), only dimensions, mu and friction.
  void load_layout(const ContactProblem& contact);
  /// Another velocity, in the units of the problem.
  void set_velocity(const Vector& velocity);

 private:
  void load_softness(const ContactProblem& contact);
  void find_islands(const ContactProblem& contact);
  void load_jacobians(const ContactProblem& contact);
  void load_inertia(const Inertia& inertia);
  void load_inertia_in_units(const Inertia& inertia);
  void add_block(const double* entries, Index size);
};

}  // namespace lcpbench
