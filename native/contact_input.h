#pragma once

#include <cstddef>
#include <vector>

#include "core/contact_problem.h"
#include "native/contact_lemke/engine.h"

namespace lcpbench {

/// A contact problem as the engines of contact_lemke take it. Points into the problem where its matrices are dense, and
/// must not be moved once loaded.
struct ContactInput {
  contact_lemke::Input input;
  Vector v, mu;
  Matrix N, D;  ///< only of sparse Jacobians
  std::vector<std::ptrdiff_t> friction_begin, offsets;
  std::vector<const double*> blocks;

  /// @param contact must outlive what is made of `input`
  void load(const ContactProblem& contact);

 private:
  void load_inertia(const Inertia& inertia);
  void add_block(const Matrix& G);
  static const double* dense_data(const Jacobian& jacobian, Matrix& copy);
};

}  // namespace lcpbench
