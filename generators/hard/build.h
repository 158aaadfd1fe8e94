#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "generators/hard/hard.h"

// The building blocks of the formulas. Sums of products are taken from left to right. If a case says that its answer is
// exact, each of its sums is exact in doubles for all values of its dials.

namespace lcpbench::hard {

// ---- dials ----

/// A text as a template argument.
template <std::size_t kSize>
struct Text {
  char letters[kSize];
  constexpr Text(const char (&text)[kSize]) { std::copy_n(text, kSize, letters); }
};

/// A dial that is a whole number. Formulas take it as that number; negative ones only as `value`.
template <Text kName, std::int64_t kDefault, std::int64_t kMin, std::int64_t kMax, Text kHelp>
struct IntegerDial {
  std::int64_t value = kDefault;
  void visit(auto&& field) { field(kName.letters, value, IntegerRange{kMin, kMax}, kHelp.letters); }
  operator std::size_t() const { return static_cast<std::size_t>(value); }
};

template <std::int64_t kDefault, std::int64_t kMin, std::int64_t kMax>
using OrderDial = IntegerDial<"n", kDefault, kMin, kMax, "order of M">;

/// An odd order; the formula gives a different kind of problem at even orders.
template <std::int64_t kDefault, std::int64_t kMax>
struct OddOrderDial {
  std::int64_t half = kDefault;
  void visit(auto&& field) { field("half", half, IntegerRange{1, kMax}, "the order of M is 2 half + 1"); }
  operator std::size_t() const { return static_cast<std::size_t>(2 * half + 1); }
};

/// For problems of a fixed size: an exact change of unit, which does not affect a relative test.
using ScaleDial = IntegerDial<"scale", 0, -400, 400, "q, and with it every solution, is multiplied by 2^scale">;
/// The same of contacts, whose speeds are about 1 m/s at 0. Far below 2^-16 m/s verdicts know the unit: no residual of
/// less than 1e-12 m/s is wrong.
constexpr std::int64_t kLeastSpeed = -16;
using SpeedDial =
    IntegerDial<"scale", 0, kLeastSpeed, 400, "q, and with it every solution, is multiplied by 2^scale">;

/// A distance or a size 2^-k.
template <std::int64_t kDefault, std::int64_t kMax>
using BitsDial = IntegerDial<"bits", kDefault, 0, kMax, "k of the 2^-k in the formula">;

// ---- vectors and matrices ----

using Numbers = std::vector<double>;
using Table = ColumnMajor<double>;

/// 2^exponent, exact; denormal or zero where it must be.
double power_of_two(std::int64_t exponent);
Table identity(std::size_t n);
/// Rows as they are written: at least one, all of the same length.
Table matrix(const std::vector<Numbers>& rows);
Table tridiagonal(std::size_t n, double below, double diagonal, double above);
/// Of order n: every entry below the diagonal, the diagonal, every entry above it.
Table triangular(std::size_t n, double below, double diagonal, double above);
Table transposed(const Table& A);
Table product(const Table& A, const Table& B);
Numbers times(const Table& M, const Numbers& x);
Numbers constant(std::size_t n, double value);
Numbers unit(std::size_t n, std::size_t i);
/// 1, 0, 1, 0, ...; from place 1 on: 0, 1, 0, 1, ...
Numbers alternating(std::size_t n, std::size_t first = 0);
Numbers scaled(Numbers x, double factor);
/// [0 A'; -A 0]: the optimality conditions of min c'x, A x <= b, x >= 0 are the LCP of this matrix with q = [c; b].
Table skew_blocks(const Table& A);
Numbers joined(const Numbers& first, const Numbers& second);

// ---- truths ----

/// @param velocity  v+ of z; of contacts with an exact z only
HardTruth solution(Numbers z, HardUnique unique, std::string reason, Numbers velocity = {});
/// A z whose entries are rounded.
HardTruth rounded_solution(Numbers z, HardUnique unique, std::string reason);
/// Solvable; no formula for z.
HardTruth solvable(HardUnique unique, std::string reason);
/// @param farkas  u >= 0 with M'u <= 0 and q'u < 0; of contacts one weight for each contact
HardTruth unsolvable(Numbers farkas, std::string reason);
/// The reason why a contact problem is solvable, and why a frictionless one has only one velocity.
inline constexpr const char* kDefiniteInertia = "G is positive definite";

// ---- cases ----

HardCase lcp(Table M, Numbers q, HardTruth truth);
/// q = w - M z, for z >= 0, w >= 0 with z'w = 0: z is a solution.
HardCase planted(Table M, const Numbers& z, const Numbers& w, HardUnique unique, std::string reason);
/// q = -M e: z = e is a solution, w = 0.
HardCase planted_ones(Table M, HardUnique unique, std::string reason);
/// The same bare LCP with q and z multiplied by 2^scale; its reason, with numbers for scale = 0, then names the unit.
HardCase with_scale(HardCase problem, ScaleDial scale);

/// Builds a contact problem contact by contact.
class Contacts {
 public:
  /// @param inertia  G, or its inverse
  Contacts(Table inertia, Numbers v, InertiaForm form = InertiaForm::kDense);
  /// Inertia of reduced rank: G = X X'.
  static Contacts reduced(ColumnMajor<double> X, Numbers v);

  void add(Numbers normal);
  /// @param directions  half of the friction columns; their negatives follow them
  void add(Numbers normal, double mu, const std::vector<Numbers>& directions);
  HardCase with(HardTruth truth) const;

 private:
  PaperSample sample_;
};

// ---- sets ----

template <class Dials>
std::remove_cvref_t<Dials> dials_of(HardCase (*make)(Dials));

/// The set of a formula. @param set  in words, with the name behind "hard/"; each family's stand in its file .inc
template <auto kMake>
HardSet hard_set(HardSet set) {
  using Dials = decltype(dials_of(kMake));
  set.name = "hard/" + set.name;
  set.options = [] { return describe_settings<Dials>(); };
  set.make = [](std::string_view owner, const Options& options) {
    return kMake(parse_settings<Dials>(owner, options));
  };
  set.changed = [](std::string_view owner, const Options& options) {
    return changed_settings(parse_settings<Dials>(owner, options));
  };
  return set;
}

// ---- the families, each file its own ----

std::vector<HardSet> edge_sets();
std::vector<HardSet> class_sets();         ///< ray, class, game
std::vector<HardSet> pivoting_sets();      ///< cycling, degenerate, exponential
std::vector<HardSet> conditioning_sets();  ///< ill-conditioned, scaling
std::vector<HardSet> application_sets();   ///< family, pde
std::vector<HardSet> particle_sets();      ///< contact: particles, one body at few points
std::vector<HardSet> box_sets();           ///< contact: boxes on k x k points
std::vector<HardSet> chain_sets();         ///< contact: stacks, rows, rings

}  // namespace lcpbench::hard
