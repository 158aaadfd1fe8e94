#include "native/answer_test/rest.h"

#include <algorithm>
#include <limits>

#include "core/entries.h"
#include "native/proofs/doubtful_inertia.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Of the verdict's 1e-4: less by what the lambdas are rounded.
constexpr Quad kLargestResidual = 0.999e-4;

/// @returns J_i'v
Quad add_row(const Jacobian& J, Index column, const Vector& v, ContactScale<Quad>& scale) {
  Quad velocity = 0, terms = 0;
  double entries = 0;
  for_each_entry(J, column, [&](Index i, double entry) {
    const Quad term = static_cast<Quad>(entry) * static_cast<Quad>(v(i));
    velocity += term;
    terms += magnitude(term);
    ++entries;
  });
  scale.add_row(velocity, terms, entries);
  return velocity;
}

}  // namespace

void RestTest::add(Index contact) {
  const Quad velocity = add_row(problem_.N, contact, v_, scale_);
  scale_.add_approach(velocity + static_cast<Quad>(problem_.offset(contact)));
  const auto index = static_cast<std::size_t>(contact);
  const Index first = layout_.friction_begin[index];
  for (Index t = 0; t < problem_.edges[index] / 2; ++t) add_row(problem_.D, first + t, v_, scale_);
}

bool RestTest::passes() const {
  const Quad scale = scale_.value();
  const bool in_range = scale <= static_cast<Quad>(std::numeric_limits<double>::max());
  return in_range && scale_.without <= kLargestResidual * scale && !may_be_unsolvable(problem_);
}

}  // namespace lcpbench
