#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "study/certify/candidates.h"
#include "study/certify/exact_lemke.h"
#include "study/certify/exact_system.h"

namespace lcpbench::exact {

/// A system of which most rows are decided: w_i = 0 in the rows of `basis`, z_i = 0 in all others but `kept`. What is
/// left is an LCP in the z of `kept`; [p; z of `basis`] = (constant + columns z of `kept`) / denominator.
struct ReducedSystem {
  std::vector<Index> basis;
  std::vector<Index> kept;
  IntegerLcp lcp;          ///< over `kept`; M and q times the denominator
  IntegerMatrix solution;  ///< (k + |basis|) x (1 + |kept|): the constant, then the columns
  Integer denominator{1};
};

/// No value where the equations of `basis` are singular. @throws TimePassed
std::optional<ReducedSystem> reduced(const ExactSystem& system, std::vector<Index> basis, std::vector<Index> kept,
                                     const Deadline& deadline);

/// With nothing decided: the potentials alone are eliminated. No value where K is singular. @throws TimePassed
std::optional<ReducedSystem> without_potentials(const ExactSystem& system, const Deadline& deadline);

/// The point of `system` whose z of `kept` is z / denominator.
ExactPoint expanded(const ReducedSystem& reduced, const ExactSystem& system, const IntegerVector& z,
                    const Integer& denominator);

/// A point that `accepts` takes, with the guess's clear rows decided and the others settled exactly by Lemke's method.
/// @throws TimePassed
std::optional<ExactPoint> settled_near(const ExactSystem& system, const Guess& guess, const Deadline& deadline,
                                       const std::function<bool(const ExactPoint&)>& accepts);

}  // namespace lcpbench::exact
