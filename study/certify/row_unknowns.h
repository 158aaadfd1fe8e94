#pragma once

#include <optional>
#include <vector>

#include "core/contact_problem.h"

namespace lcpbench::exact {

/// The bounded rows of a contact problem by unknowns >= 0, exactly: impulses f_R = origin + sum of sign x over parts,
/// and one slack for each row with two bounds or with friction.
///
///     lower bound alone:      f = lower + x,  w >= 0
///     upper bound alone:      f = upper - x,  -w >= 0
///     none, an equality:      f = x+ - x-,    w >= 0 and -w >= 0
///     two bounds:             f = lower + x,  w + s >= 0 with x,  upper - lower - x >= 0 with s
///     friction of row j:      f = x+ - x-,    w + s >= 0 and -w + s >= 0,  mu f_j - x+ - x- >= 0 with s
///
/// All unknowns stand in the order x = [f_N; f_D; parts; lambda; slacks]. Without bounded rows that is z.
struct RowUnknowns {
  struct Part {
    Index row;
    int sign;
  };
  struct Slack {
    Index row;
    Index first;            ///< its first part, of friction the first of two
    Index load = -1;        ///< of friction the part of row j
    bool is_friction() const { return load >= 0; }
  };

  explicit RowUnknowns(const ContactProblem& contact);

  Index size() const { return slack_offset() + static_cast<Index>(slacks.size()); }
  Index part_offset() const { return layout.lambda_offset(); }
  Index cone_offset() const { return part_offset() + static_cast<Index>(parts.size()); }
  Index slack_offset() const { return cone_offset() + layout.cones; }
  /// The unknown whose w is that of the row times this sign; nullopt where the row has none.
  std::optional<Index> with_sign(Index row, int sign) const;

  /// x from z. @param w  M z + q
  Vector unknowns(const Vector& z, const Vector& w) const;
  /// The LCP of x, in double. @param mixed  that of z
  Lcp lcp(const Lcp& mixed) const;
  /// The matrix E of z = E x + origin of z.
  Matrix to_impulses() const;

  ContactLayout layout;
  LcpBounds bounds;
  Vector origin;  ///< of f_R
  std::vector<Part> parts;
  std::vector<Slack> slacks;
};

}  // namespace lcpbench::exact
