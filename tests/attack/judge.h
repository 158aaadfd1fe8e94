#pragma once

#include <memory>

#include "core/problem.h"
#include "tests/attack/exact.h"

namespace lcpbench::attack {

/// The verdict's measure of an answer in exact arithmetic, written anew from docs/explanation/verdicts.md: rho by
/// island for contact problems, eta by block for bare LCPs.
class Judge {
 public:
  explicit Judge(const Problem& problem);
  ~Judge();

  /// Whether z solves the problem by the definition of the verdict: rho <= 1e-4, or eta <= 1e-9.
  bool solves(const Vector& z) const;

  /// Whether numerators / denominator is a solution without any tolerance. @pre denominator > 0
  bool is_exact_solution(const Integers& numerators, const Integer& denominator) const;

  /// [q M], times the positive denominator of G* for contact problems.
  DyadicMatrix rows() const;

  /// rho or eta of the z that solves() saw last, for messages: about 15 digits.
  double measure() const { return measure_; }

 private:
  struct Data;
  bool contacts_solved(const DyadicVector& z) const;
  bool block_solved(const DyadicVector& z, const std::vector<Index>& block) const;

  std::unique_ptr<Data> data_;
  mutable double measure_ = 0;
};

}  // namespace lcpbench::attack
