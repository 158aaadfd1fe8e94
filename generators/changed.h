#pragma once

#include <cstdint>
#include <string>

#include "core/problem.h"
#include "core/settings.h"
#include "generators/random.h"

// Problems of other sets, changed in ways whose effect on the physical answer is known. The physical answer of contacts
// is the velocity after the impact, that of a bare LCP is z.

namespace lcpbench {

enum class Change {
  kScaling,        ///< columns of N, D and R by powers of two, one a contact; bare LCP: rows of M and q, columns of M
  kUnits,          ///< scene: masses and lengths 2^10 times as large; else G, v and b; bare LCP: q
  /// Other order of contacts and bounded rows and, without a scene, of directions, some rows with the other sign; bare
  /// LCP: of rows and columns.
  kOrder,
  kDuplicate,      ///< one contact, and one bounded row, twice, with twice its compliance and half its bounds
  kNearDuplicate,  ///< the same, every entry of N, D and R of the second off by 2^-30 (scene: its point)
  kLastDigits,     ///< every number but zeros moved to a neighbouring double (scene: all but directions)
  kHard,  ///< contacts without compliance and tangential offsets: the only change of the physical answer itself
};

/// All changes with their names: scaling, units, order, duplicate, near_duplicate, last_digits, hard.
const Choices<Change>& all_changes();
const char* to_string(Change change);

/// The relative change of the data, entry by entry: 2^-30 for near duplicates, 2^-52 for last digits, else 0.
double data_change(Change change);

/// Whether the change is made at all: duplicates need a contact or a bounded row that bears no friction, kHard a soft
/// contact, and kScaling of a bare LCP entries of M that are zero or between 2^-1000 and 2^1000 in size.
bool applies(Change change, const Problem& problem);

/// One change as it is drawn for one trial of a set.
class DrawnChange {
 public:
  /// @param set   canonical name of the set that is changed
  /// @param draw  which one of the draws for the same problem
  DrawnChange(Change change, const std::string& set, std::uint64_t seed, std::int64_t trial, std::int64_t draw);

  /// A scene stays one, except under kScaling. A problem to which the change does not apply stays as it is; so does an
  /// inertia whose neighbour is not positive definite.
  Problem apply(const Problem& problem, const std::string& name) const;

  /// Makes of the physical answer to the changed problem that to `original`: undoes units, scaling and order; under
  /// the other changes both are the same. @pre the change applies
  Vector take_back(const Problem& original, Vector answer) const;

 private:
  Change change_;
  DrawSequence draws_;
};

struct ChangedSettings {
  std::string of = "planted/definite";
  Change by = Change::kOrder;
  std::int64_t draw = 0;

  void visit(auto&& field) {
    field("of", of, "the set whose problems are changed");
    field("by", by, all_changes(), "the change");
    field("draw", draw, IntegerRange{0, 1'000'000}, "which draw of the change for each problem");
  }
};

}  // namespace lcpbench
