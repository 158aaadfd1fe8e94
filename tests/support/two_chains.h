#pragma once

#include <utility>

#include "core/problem.h"

namespace lcpbench::testing {

/// How the data are kept, which decides what algebra solvers choose.
enum class Storage { kDense, kBlocks, kSparse };

/// Two chains of bodies on a line, each pushed into the next at about the speed of its chain, and nothing between the
/// chains: a short one, on which iterations converge within a few sweeps, and a long one, on which they need hundreds.
inline Problem two_chains(double speed_of_short, double speed_of_long, Storage storage) {
  constexpr Index kShort = 4, kLong = 24;
  constexpr Index kBodies = kShort + kLong;
  ContactProblem contact;
  contact.v.resize(kBodies);
  for (Index i = 0; i < kBodies; ++i) {
    const double speed = i < kShort ? speed_of_short : speed_of_long;
    contact.v(i) = -speed * (static_cast<double>(i < kShort ? i : i - kShort) + 0.3 * static_cast<double>(i % 3));
  }
  Matrix N = Matrix::Zero(kBodies, kBodies - 2);
  for (Index c = 0; c < N.cols(); ++c) {
    const Index body = c < kShort - 1 ? c : c + 1;
    N(body, c) = -0.95;
    N(body + 1, c) = 1.05;
  }
  contact.D = Matrix(kBodies, 0);
  contact.edges.assign(static_cast<std::size_t>(N.cols()), 0);
  contact.mu = Vector::Zero(N.cols());
  Matrix G = Matrix::Identity(kBodies, kBodies);
  for (Index i = 0; i < kBodies; ++i) G(i, i) += 0.1 * static_cast<double>(i % 4);
  if (storage == Storage::kDense) {
    contact.inertia = DenseInertia{G};
  } else {
    BlockInertia bodies;
    for (Index i = 0; i < kBodies; ++i) bodies.blocks.push_back(G.block(i, i, 1, 1));
    contact.inertia = std::move(bodies);
  }
  if (storage == Storage::kSparse) {
    contact.N = SparseMatrix(N.sparseView());
  } else {
    contact.N = std::move(N);
  }
  return {"two chains", std::move(contact)};
}

}  // namespace lcpbench::testing
