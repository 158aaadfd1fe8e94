#pragma once

#include <algorithm>
#include <cmath>

#include "core/compliance.h"

namespace lcpbench {

/// What offset and compliance add to one normal or friction row of w, beside J'(v + G* J f). lambda is not included.
struct Beside {
  double offset = 0;           ///< its part of q_j
  double yields = 0;           ///< what compliance times impulses adds
  double terms = 0;            ///< sum of the magnitudes of the offset's terms, for bounds on rounding
  double terms_of_yields = 0;  ///< the same of `yields`, or more
  double compliance = 0;       ///< its part of M_jj
};

/// Of the normal row of a contact. @param f  its normal impulse, >= 0
inline Beside beside_normal(const ContactProblem& problem, Index contact, double f) {
  Beside beside;
  const double b = problem.offset(contact);
  beside.offset = b;
  beside.terms = std::abs(beside.offset);
  beside.compliance = problem.normal_compliance(contact);
  beside.yields = beside.terms_of_yields = beside.compliance * f;
  return beside;
}

/// Of the friction rows of one contact. @param z  its friction impulses are >= 0
class BesideFriction {
 public:
  BesideFriction(const ContactProblem& problem, const ContactLayout& layout, Index contact, const Vector& z)
      : soft_(problem, layout), contact_(contact), is_soft_(problem.is_soft()) {
    if (!is_soft_) return;
    offset_ = soft_.offset(contact);
    yields_ = soft_.yielding(contact, z);
    const auto c = static_cast<std::size_t>(contact);
    const auto f = z.segment(layout.friction_offset() + layout.friction_begin[c], problem.edges[c]);
    // The factor 4 + edges also covers the rounding of the sums in C f_D.
    terms_of_yields_ = problem.tangential_compliance(contact) * f.sum() * (4 + problem.edges[c]);
  }

  Beside of(Index direction) const {
    if (!is_soft_) return {};
    const double first = soft_.along(contact_, direction, {offset_[0], 0});
    const double second = soft_.along(contact_, direction, {0, offset_[1]});
    return {.offset = first + second,
            .yields = soft_.along(contact_, direction, yields_),
            .terms = std::abs(first) + std::abs(second),
            .terms_of_yields = terms_of_yields_,
            .compliance = soft_.diagonal(contact_, direction)};
  }

 private:
  SoftRows<double> soft_;
  Index contact_;
  bool is_soft_;
  SoftRows<double>::Tangential offset_{}, yields_{};
  double terms_of_yields_ = 0;
};

/// The least lambda of a contact without entries in N and D, whose impulses are zero: the largest magnitude of its
/// offsets along friction directions.
inline double largest_creep(const ContactProblem& problem, const ContactLayout& layout, Index contact,
                            const Vector& z) {
  const BesideFriction beside(problem, layout, contact, z);
  double largest = 0;
  const Index half = problem.edges[static_cast<std::size_t>(contact)] / 2;
  for (Index t = 0; t < half; ++t) largest = std::max(largest, std::abs(beside.of(t).offset));
  return largest;
}

}  // namespace lcpbench
