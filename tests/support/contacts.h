#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <utility>

#include "core/compliance.h"
#include "core/contact_problem.h"

// Builders of small contact problems, and draws that are the same everywhere.

namespace lcpbench::testing {

inline Vector vec(std::initializer_list<double> values) {
  Vector x(static_cast<Index>(values.size()));
  std::copy(values.begin(), values.end(), x.begin());
  return x;
}

inline ContactProblem frictionless(Vector v, Matrix N, Inertia inertia) {
  ContactProblem problem;
  problem.v = std::move(v);
  problem.edges.assign(static_cast<std::size_t>(N.cols()), 0);
  problem.mu = Vector::Zero(N.cols());
  problem.D = Matrix(N.rows(), 0);
  problem.N = std::move(N);
  problem.inertia = std::move(inertia);
  return problem;
}

/// A point of mass 2 that meets the floor z = 0; the friction directions are those of a regular polygon.
inline ContactProblem point_on_floor(double mu, int edges, const Vector& v) {
  ContactProblem contact;
  contact.v = v;
  contact.N = Matrix{{0.0}, {0.0}, {1.0}};
  Matrix D = Matrix::Zero(3, edges);
  for (Index k = 0; k < edges; ++k) {
    const auto along = edge_direction(k, edges);
    D.col(k) << along[0], along[1], 0;
  }
  contact.D = D;
  contact.edges = {edges};
  contact.mu = Vector::Constant(1, mu);
  contact.inertia = DenseInertia{2 * Matrix::Identity(3, 3)};
  return contact;
}

/// The same contacts and inertia, all of them in dense matrices.
inline ContactProblem in_dense_matrices(ContactProblem contact) {
  contact.N = to_dense(contact.N);
  contact.D = to_dense(contact.D);
  contact.inertia = DenseInertia{dense_inertia(contact.inertia)};
  return contact;
}

/// splitmix64, so that the tests draw the same numbers everywhere.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t x = state_;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
  }
  double uniform() { return static_cast<double>(bits() >> 52) * 0x1p-11 - 1.0; }  // multiples of 2^-11 in [-1, 1)
  Matrix matrix(Index rows, Index cols) {
    Matrix A(rows, cols);
    for (Index j = 0; j < cols; ++j) {
      for (Index i = 0; i < rows; ++i) A(i, j) = uniform();
    }
    return A;
  }
  Vector vector(Index size) { return matrix(size, 1); }

 private:
  std::uint64_t state_;
};

}  // namespace lcpbench::testing
