#pragma once

#include <memory>

#include "core/friction_model.h"
#include "core/problem.h"
#include "tests/attack/exact.h"

namespace lcpbench::attack {

/// The verdict's measure of an answer in exact arithmetic, written anew from docs/explanation/verdicts.md: rho by
/// island for contact problems, eta by row for bare LCPs, mixed or not.
class Judge {
 public:
  /// By which friction an answer to contacts is measured. Round cones need contacts of 4 edges, or of none.
  using Friction = FrictionModel;

  explicit Judge(const Problem& problem);
  ~Judge();

  /// Whether z solves the problem by the definition of the verdict: rho <= 1e-4, or eta <= 1e-6.
  bool solves(const Vector& z, Friction friction = Friction::kPyramid) const;

  /// Whether a returned velocity u is that of z, v(z) = v + G* J f: in every coordinate
  /// |u - v(z)|_i <= max(1e-4 (|v| + |G*| |J| |f|)_i
  ///     + (k + 1) (2^-53 sqrt(G*_ii) (sqrt(v'G v) + sum_j sqrt(M_jj) |f_j|) + 2^-1074) + solving_i,
  ///     1e-12 sqrt(G*_ii v'G v), 1e-12),
  /// solving_i = min(m 2^-53 (|G*| |G| |c|)_i, 1e-4 max_j(sqrt(G_jj) |c_j|) / sqrt(G_ii)), c = v(z) - v,
  /// over the coordinate's island, m its coordinates, k its impulses f_j that are not zero; without the terms in G if
  /// only G* is given. Contact problems only.
  bool velocity_holds(const Vector& z, const Vector& u) const;

  /// v(z), to about 15 digits. @pre z has n finite entries
  Vector velocity(const Vector& z) const;

  /// More than the bound of velocity_holds, by coordinate. @pre z has n finite entries
  Vector beyond_velocity(const Vector& z) const;

  /// Whether numerators / denominator is a solution without any tolerance. @pre denominator > 0
  bool is_exact_solution(const Integers& numerators, const Integer& denominator) const;

  /// [q M], times the positive denominator of G* for contact problems.
  DyadicMatrix rows() const;

  /// rho or eta of the z that solves() saw last, for messages: about 15 digits.
  double measure() const { return measure_; }

 private:
  struct Data;
  bool contacts_solved(const DyadicVector& z, Friction friction) const;
  bool block_solved(const DyadicVector& z, const std::vector<Index>& block) const;

  std::unique_ptr<Data> data_;
  mutable double measure_ = 0;
};

}  // namespace lcpbench::attack
