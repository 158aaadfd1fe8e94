#include "native/answer_test/rest.h"

#include <algorithm>
#include <limits>

#include "core/compliance.h"
#include "core/entries.h"
#include "native/proofs/doubtful_inertia.h"
#include "native/proofs/scaled_numbers.h"

namespace lcpbench {
namespace {

/// Of the verdict's 1e-4: less by what the lambdas are rounded.
constexpr Quad kLargestResidual = 0.999e-4;

/// q of a row, offset included, and the scale that it gives: |q|, or 1e4 times the error of forming it in double where
/// that is more.
struct Row {
  Quad q = 0;
  Quad scale = 0;
};

Row row_at(const Jacobian& J, Index column, const Vector& v, Quad offset) {
  Row row;
  row.q = offset;
  Quad terms = magnitude(row.q);
  Index entries = offset == 0 ? 0 : 1;
  for_each_entry(J, column, [&](Index i, double entry) {
    const Quad term = static_cast<Quad>(entry) * static_cast<Quad>(v(i));
    row.q += term;
    terms += magnitude(term);
    ++entries;
  });
  const Quad error = static_cast<Quad>(static_cast<double>(entries + 1)) * Quad{0x1p-53} * terms;
  row.scale = std::max(magnitude(row.q), Quad{1e4} * error);
  return row;
}

}  // namespace

void RestTest::add(Index contact) {
  const Row normal = row_at(problem_.N, contact, v_, static_cast<Quad>(problem_.offset(contact)));
  approach_ = std::max(approach_, -normal.q);
  scale_ = std::max(scale_, normal.scale);
  const auto index = static_cast<std::size_t>(contact);
  const SoftRows<Quad> soft(problem_, layout_);
  for (Index t = 0; t < problem_.edges[index] / 2; ++t) {
    const Quad creep = soft.along(contact, t, soft.offset(contact));
    scale_ = std::max(scale_, row_at(problem_.D, layout_.friction_begin[index] + t, v_, creep).scale);
  }
}

bool RestTest::passes() const {
  const bool in_range = scale_ <= static_cast<Quad>(std::numeric_limits<double>::max());
  return in_range && approach_ <= kLargestResidual * scale_ && !may_be_unsolvable(problem_);
}

}  // namespace lcpbench
