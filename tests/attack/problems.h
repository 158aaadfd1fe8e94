#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/problem.h"
#include "generators/random.h"

/// Nasty small problems: a function of (family, seed, index) alone, bit for bit the same on every machine. Sums are
/// taken in a fixed order by scalar code, and of the mathematical functions only sqrt, ldexp and nextafter are used.
namespace lcpbench::attack {

enum class Family {
  kLcp,
  kMixed,     ///< LCPs with bounds of every kind, and rows of friction
  kContact,
  kSoft,      ///< the problems of the other two kinds of contacts, with compliance and tangential offsets
  kDoubtful,  ///< contact problems whose rank, scale or solvability is in doubt when it is computed in double
  kRank,      ///< contact problems of reduced rank, many of which 113 bits do not resolve
  kRows,      ///< contacts with bounded rows of every kind
  kLimits,    ///< contacts with open rows, large offsets, tiny speeds, or light bodies beside heavy ones
};

inline constexpr Family kFamilies[] = {Family::kLcp,      Family::kMixed, Family::kContact, Family::kSoft,
                                       Family::kDoubtful, Family::kRank,  Family::kRows,    Family::kLimits};

/// "lcp", "mixed", "contact", "soft", "doubtful", "rank", "rows", "limits".
const char* to_string(Family family);

/// The names of the kinds of a family, in the order in which they take turns: problem i is of kind i mod their number.
const std::vector<std::string>& kinds(Family family);

/// Problem `index` of the family. LCPs have n <= 8, mixed ones n <= 4; contacts ngc <= 8, nc <= 8 and 0, 2 or 4 edges each;
/// those with bounded rows ngc <= 6, nc <= 3 and at most 4 rows.
Problem generate(Family family, std::uint64_t seed, std::uint64_t index);

/// The draws of one problem.
class Draw {
 public:
  Draw(const TrialKey& key, std::uint64_t attempt) : sequence_(key, Purpose::kPlantedValues, attempt) {}

  std::int64_t integer(std::int64_t low, std::int64_t high) { return sequence_.integer(low, high); }
  Index index(Index low, Index high) { return integer(low, high); }
  /// True in `parts` of `of` cases.
  bool chance(int parts, int of) { return integer(1, of) <= parts; }
  double small(int size) { return static_cast<double>(integer(-size, size)); }
  /// U(-1, 1) on the grid of 2^-20.
  double signed_unit() { return static_cast<double>(sequence_.signed_grid()) * kGridStep; }
  double sign() { return chance(1, 2) ? 1 : -1; }
  double power_of_two(int low, int high);
  /// 53 random bits in [1, 2), with a sign.
  double mantissa();
  /// The double next to x, above or below; 0 stays 0.
  double neighbour(double x);
  /// x (1 + k size), k in -9..9.
  double nearly(double x, double size) { return x * (1 + small(9) * size); }

 private:
  DrawSequence sequence_;
};

double dot(const Vector& a, const Vector& b);
Matrix product(const Matrix& A, const Matrix& B);

/// Of each kind of a family, by number. What a maker returns may be refused, and is then drawn again.
Lcp make_lcp_of_kind(std::size_t kind, Draw& draw);
Lcp make_mixed_of_kind(std::size_t kind, Draw& draw);
ContactProblem make_contact_of_kind(std::size_t kind, Draw& draw);
ContactProblem make_doubtful_of_kind(std::size_t kind, Draw& draw);
ContactProblem make_rank_of_kind(std::size_t kind, Draw& draw);
ContactProblem make_rows_of_kind(std::size_t kind, Draw& draw);
ContactProblem make_limit_of_kind(std::size_t kind, Draw& draw);
const std::vector<std::string>& lcp_kinds();
const std::vector<std::string>& contact_kinds();
const std::vector<std::string>& doubtful_kinds();
const std::vector<std::string>& rank_kinds();
const std::vector<std::string>& row_kinds();
const std::vector<std::string>& limit_kinds();

/// Gives some contacts compliance of 1e-12 to 1e12, or zero, and tangential offsets.
void soften(ContactProblem& contact, Draw& draw);

/// The Jacobian and velocity of contacts for a given number of coordinates; the inertia is left for the caller.
ContactProblem make_contacts(Index ngc, Index nc, int largest_edges, Draw& draw);

/// Scales time, mass and length by powers of two up to 2^bits: the answer's digits do not change.
void change_units(ContactProblem& contact, int bits, Draw& draw);

}  // namespace lcpbench::attack
