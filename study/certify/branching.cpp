#include "study/certify/branching.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "study/certify/exact_checks.h"
#include "study/certify/exact_lemke.h"
#include "study/certify/integer_solve.h"
#include "study/certify/reduction.h"
#include "study/certify/relaxation.h"

namespace lcpbench::exact {
namespace {

/// Bytes of all dictionaries on a path, and of a proof, at most.
constexpr double kMostMemory = 512.0 * 1024 * 1024;
/// Complementary to rounding: z_i w_i below this part of the largest z_j times the largest w_j.
constexpr double kComplementary = 1e-13;
/// Multipliers are rounded to this many bits, that is, to integers which doubles hold.
constexpr int kMultiplierBits = 50;
/// Multipliers below this part of the largest one are rounding errors.
constexpr double kNoMultiplier = 1e-9;
/// Largest order whose leaves are contradicted in integers where floats contradict none.
constexpr Index kLargestExactLeaf = 40;

/// y as integers, row by row, in the units of the problem; other rows are zero.
using Multipliers = std::vector<std::pair<Index, Integer>>;

/// Checks leaves of proofs by branching on one system: by multiplication over the integers alone.
class LeafCheck {
 public:
  /// @param system,deadline  outlive this. Every function @throws TimePassed.
  LeafCheck(const ExactSystem& system, const Deadline& deadline)
      : system_(system), deadline_(deadline), row_shift_(system.w_exponent), K_(system.K, deadline) {
    const slong least = row_shift_.empty() ? 0 : *std::min_element(row_shift_.begin(), row_shift_.end());
    for (slong& shift : row_shift_) largest_shift_ = std::max(largest_shift_, shift -= least);
    if (system.size() <= kLargestExactLeaf) small_ = without_potentials(system, deadline);
  }

  /// False where K is singular: then nothing can be checked.
  bool possible() const { return system_.potentials() == 0 || K_.possible(); }

  /// y contradicts w = q + M z >= 0, z >= 0 with w_i = 0 where w_is_zero[i], z_i = 0 where z_is_zero[i]:
  /// q'y < 0, y_i >= 0 for the other w_i, (M'y)_j <= 0 for the other z_j.
  /// With K pi = -R y: y'w = q'y + (S'y - L'pi)'z, of which the left is not negative, and all on the right is.
  bool contradicts(const Multipliers& y, const std::vector<char>& w_is_zero, const std::vector<char>& z_is_zero) const {
    const Index k = system_.potentials();
    Integer gain;
    IntegerMatrix forced(k, 1);  // R y
    IntegerVector columns(index(system_.size()));
    Integer value;
    for (const auto& [row, multiplier] : y) {
      deadline_.check();
      const auto i = index(row);
      if (multiplier.sign() < 0 && !w_is_zero[i]) return false;
      fmpz_mul_2exp(value.get(), multiplier.get(), static_cast<ulong>(row_shift_[i]));
      fmpz_addmul(gain.get(), system_.q[i].get(), value.get());
      for (Index j = 0; j < k; ++j) fmpz_addmul(forced(j, 0), system_.R(j, row), value.get());
      for (const Term& term : system_.S[i]) {
        fmpz_addmul(columns[index(term.column)].get(), term.value.get(), value.get());
      }
    }
    if (gain.sign() >= 0) return false;
    IntegerMatrix potential;  // -pi, times the denominator
    Integer denominator;
    if (!K_.solve(forced, potential, denominator)) return false;
    for (Index j = 0; j < system_.size(); ++j) {
      deadline_.check();
      if (z_is_zero[index(j)]) continue;
      Integer& column = columns[index(j)];
      if (k > 0) fmpz_mul(column.get(), column.get(), denominator.get());
      for (Index i = 0; i < k; ++i) fmpz_addmul(column.get(), system_.L(i, j), potential(i, 0));
      if (column.sign() > 0) return false;
    }
    return true;
  }

  /// y that is zero but for `rows`, with (M'y)_j = 0 in `tight` and q'y = -1, up to a positive factor. Of equations
  /// that depend on each other a largest independent part is taken; no value where they contradict q'y = -1.
  /// Unknown are pi and y, in that order: K pi + R y = 0, (S'y - L'pi)_j = 0 in the tight columns, q'y = -1.
  std::optional<Multipliers> exact(const std::vector<Index>& rows, const std::vector<Index>& tight) const {
    const Index k = system_.potentials();
    const auto support = static_cast<Index>(rows.size());
    const auto columns = static_cast<Index>(tight.size());
    Equations e{IntegerMatrix(1 + k + columns, k + support), IntegerMatrix(1 + k + columns, 1)};
    fmpz_set_si(e.b(0, 0), -1);
    std::vector<Index> equation_of(index(system_.size()), -1);
    for (Index t = 0; t < columns; ++t) equation_of[index(tight[index(t)])] = 1 + k + t;
    for (Index i = 0; i < k; ++i) {
      for (Index j = 0; j < k; ++j) fmpz_set(e.A(1 + i, j), system_.K(i, j));
      for (Index t = 0; t < columns; ++t) fmpz_neg(e.A(1 + k + t, i), system_.L(i, tight[index(t)]));
    }
    for (Index s = 0; s < support; ++s) {
      const Index row = rows[index(s)];
      fmpz_set(e.A(0, k + s), system_.q[index(row)].get());
      for (Index i = 0; i < k; ++i) fmpz_set(e.A(1 + i, k + s), system_.R(i, row));
      for (const Term& term : system_.S[index(row)]) {
        const Index equation = equation_of[index(term.column)];
        if (equation >= 0) fmpz_set(e.A(equation, k + s), term.value.get());
      }
    }
    const std::optional<IntegerVector> x = solve_independent_part(e, deadline_);
    if (!x) return std::nullopt;
    Multipliers y;
    for (std::size_t s = 0; s < rows.size(); ++s) add(rows[s], (*x)[index(k) + s], y);
    return y;
  }

  /// Multipliers y that contradict the node, by Lemke's method in integers; no value for systems above
  /// kLargestExactLeaf. Where the inequalities have a solution instead, and it solves the LCP, `solution` is set to it.
  /// w >= 0, and -w_i >= 0 where w_i is zero, in the z that are not zero: A z + b >= 0. Lemke's method on the monotone
  /// LCP of [0 -A'; A 0] ends on a ray with y >= 0, A'y <= 0, b'y < 0 if nothing satisfies them.
  std::optional<Multipliers> by_lemke(const std::vector<char>& w_is_zero, const std::vector<char>& z_is_zero,
                                      std::optional<ExactPoint>& solution) const {
    const Index n = system_.size();
    if (!small_) return std::nullopt;
    std::vector<Index> column_of(index(n), -1);
    Index columns = 0;
    for (Index j = 0; j < n; ++j) {
      if (!z_is_zero[index(j)]) column_of[index(j)] = columns++;
    }
    std::vector<std::pair<Index, bool>> rows;  // of w; whether negated
    for (Index i = 0; i < n; ++i) {
      rows.emplace_back(i, false);
      if (w_is_zero[index(i)]) rows.emplace_back(i, true);
    }
    const Index size = columns + static_cast<Index>(rows.size());
    IntegerLcp lcp{IntegerMatrix(size, size), IntegerVector(index(size))};
    for (Index at = columns; at < size; ++at) {
      const auto [row, negated] = rows[index(at - columns)];
      Integer& q = lcp.q[index(at)];
      q = small_->lcp.q[index(row)];
      if (negated) fmpz_neg(q.get(), q.get());
      for (Index j = 0; j < n; ++j) {
        const Index column = column_of[index(j)];
        if (column < 0) continue;
        fmpz_set(lcp.M(negated ? column : at, negated ? at : column), small_->lcp.M(row, j));
        fmpz_neg(lcp.M(negated ? at : column, negated ? column : at), small_->lcp.M(row, j));
      }
    }
    const LemkeOutcome ray = exact_lemke(lcp, deadline_);
    if (ray.ending == LemkeEnding::kSolution) {
      IntegerVector z(index(n));
      for (std::size_t j = 0; j < z.size(); ++j) {
        if (column_of[j] >= 0) z[j] = ray.z[index(column_of[j])];
      }
      ExactPoint point = expanded(*small_, system_, z, ray.denominator);
      if (is_solution(system_, point, deadline_)) solution = std::move(point);
    }
    if (ray.ending != LemkeEnding::kRay) return std::nullopt;
    Multipliers y;
    for (Index at = columns; at < size; ++at) {
      const auto [row, negated] = rows[index(at - columns)];
      Integer value = ray.z[index(at)];
      if (negated) fmpz_neg(value.get(), value.get());
      add(row, std::move(value), y);
    }
    return y;
  }

 private:
  /// Adds a multiplier of the system's own row.
  void add(Index row, Integer value, Multipliers& y) const {
    shift_left(value, largest_shift_ - row_shift_[index(row)]);
    if (value.sign() != 0) y.emplace_back(row, std::move(value));
  }

  const ExactSystem& system_;
  const Deadline& deadline_;
  std::vector<slong> row_shift_;  ///< a row of the problem is that of the system times 2^(a shift), least 0
  slong largest_shift_ = 0;
  Lifting K_;
  std::optional<ReducedSystem> small_;  ///< the potentials eliminated
};

Multipliers rounded_multipliers(const Vector& y) {
  Multipliers multipliers;
  if (!y.allFinite()) return multipliers;
  for (Index i = 0; i < y.size(); ++i) {
    const double value = std::nearbyint(std::ldexp(y(i), kMultiplierBits));
    if (value != 0) multipliers.emplace_back(i, Integer(static_cast<slong>(value)));
  }
  return multipliers;
}

std::vector<Index> rows_of(const Vector& y) {
  std::vector<Index> rows;
  for (Index i = 0; i < y.size(); ++i) {
    if (std::abs(y(i)) > kNoMultiplier) rows.push_back(i);
  }
  return rows;
}

/// Depth first, with a stack of its own. Every split takes a row that was not split above, so that no path is longer
/// than n.
class Search {
 public:
  Search(const Lcp& lcp, const LeafCheck& check, const Deadline& deadline, const AcceptsVertex& accepts)
      : n_(lcp.size()),
        check_(check),
        deadline_(deadline),
        accepts_(accepts),
        most_levels_(static_cast<std::size_t>(kMostMemory / (8.0 * static_cast<double>(n_ * n_)))),
        w_is_zero_(index(n_), 0),
        z_is_zero_(index(n_), 0) {}

  BranchingOutcome run(Relaxation node) {
    while (true) {
      if (deadline_.passed()) return {};
      const Index row = row_to_split(node);
      if (solved_ || solution_) return {{}, solved_, std::move(solution_)};
      if (row >= 0 && levels_.size() < most_levels_) {
        descend(node, row);
        continue;
      }
      if (row >= 0) leave_open();
      if (!to_next_branch(node)) return {all_contradicted_ ? std::move(proof_) : std::vector<ProofNode>{}};
    }
  }

 private:
  /// A node on the path to the present one: its branch with w_row = 0 comes first, then that with z_row = 0.
  struct Level {
    Index row;
    std::optional<Relaxation> second;  ///< of the second branch, until that is entered
  };

  void descend(Relaxation& node, Index row) {
    add_to_proof({row, {}});
    levels_.push_back({row, node});
    levels_.back().second->impose(n_ + row);
    node.impose(row);
    w_is_zero_[index(row)] = 1;
  }

  // False when there is none left.
  bool to_next_branch(Relaxation& node) {
    while (!levels_.empty()) {
      Level& level = levels_.back();
      const auto row = index(level.row);
      if (level.second) {
        node = std::move(*level.second);
        level.second.reset();
        w_is_zero_[row] = 0;
        z_is_zero_[row] = 1;
        return true;
      }
      z_is_zero_[row] = 0;
      levels_.pop_back();
    }
    return false;
  }

  // A row that was not split; or -1 where the node is done with: a solution was found (solved_ or solution_), or the
  // node is contradicted, or it is left open, so that there will be no proof.
  Index row_to_split(Relaxation& node) {
    Index row = -1;
    switch (node.solve(deadline_)) {
      case Relaxation::Ending::kStuck: break;
      case Relaxation::Ending::kInfeasible:
        if (contradicted(node)) return -1;
        // Where equations depend on each other, rounding may have led to a row that contradicts nothing: split on.
        row = largest_undecided(node.contradiction().cwiseAbs(), kNoMultiplier);
        break;
      case Relaxation::Ending::kFeasible:
        row = most_violated(node);
        if (row >= 0) break;
        solved_ = accepts_(node.z());
        if (solved_) return -1;
        row = first_undecided();
        break;
    }
    if (row >= 0 || settled_exactly()) return row;
    row = first_undecided();
    if (row < 0) leave_open();
    return row;
  }

  // By Lemke's method in integers: true where the node is contradicted, or a solution of the problem (solution_) found.
  bool settled_exactly() {
    const std::optional<Multipliers> y = check_.by_lemke(w_is_zero_, z_is_zero_, solution_);
    return solution_ || (y && taken(*y));
  }

  bool contradicted(const Relaxation& node) {
    if (taken(rounded_multipliers(node.contradiction_with_room()))) return true;
    const Vector y = node.contradiction();
    if (!y.allFinite()) return false;
    const std::optional<Multipliers> exact = check_.exact(rows_of(y), node.tight_columns());
    return exact && taken(*exact);
  }

  bool taken(const Multipliers& y) {
    if (!check_.contradicts(y, w_is_zero_, z_is_zero_)) return false;
    ProofNode leaf;
    for (const auto& [row, value] : y) leaf.multipliers.push_back({row, text(value)});
    add_to_proof(std::move(leaf));
    return true;
  }

  // There will be no proof; a solution may still be found.
  void leave_open() {
    if (!all_contradicted_) return;
    all_contradicted_ = false;
    proof_ = {};
  }

  void add_to_proof(ProofNode node) {
    if (!all_contradicted_) return;
    proof_bytes_ += sizeof(ProofNode);
    for (const Multiplier& entry : node.multipliers) {
      proof_bytes_ += static_cast<double>(sizeof(Multiplier) + entry.value.size());
    }
    proof_.push_back(std::move(node));
    if (proof_bytes_ > kMostMemory) leave_open();
  }

  bool decided(Index row) const { return w_is_zero_[index(row)] != 0 || z_is_zero_[index(row)] != 0; }

  // Where the largest of these values above a bound is, among the rows that are not decided; else -1.
  Index largest_undecided(const Vector& values, double bound) const {
    Index row = -1;
    for (Index i = 0; i < n_; ++i) {
      if (decided(i) || !(values(i) > bound)) continue;
      bound = values(i);
      row = i;
    }
    return row;
  }

  // In the rows that are decided, rounding alone may leave both entries above zero.
  Index most_violated(const Relaxation& node) const {
    const Vector z = node.z();
    const Vector w = node.w();
    return largest_undecided(z.cwiseProduct(w), kComplementary * z.cwiseAbs().maxCoeff() * w.cwiseAbs().maxCoeff());
  }

  Index first_undecided() const {
    for (Index i = 0; i < n_; ++i) {
      if (!decided(i)) return i;
    }
    return -1;
  }

  Index n_;
  const LeafCheck& check_;
  const Deadline& deadline_;
  const AcceptsVertex& accepts_;
  std::size_t most_levels_;
  std::vector<char> w_is_zero_;
  std::vector<char> z_is_zero_;
  std::vector<Level> levels_;
  std::vector<ProofNode> proof_;
  double proof_bytes_ = 0;
  bool all_contradicted_ = true;
  bool solved_ = false;
  std::optional<ExactPoint> solution_;
};

}  // namespace

BranchingOutcome branch(const Lcp& lcp, const ExactSystem& system, const Deadline& deadline,
                        const AcceptsVertex& accepts) {
  if (lcp.size() == 0 || !lcp.M.allFinite() || !lcp.q.allFinite()) return {};
  if (8.0 * static_cast<double>(lcp.size() * lcp.size()) > kMostMemory) return {};
  const LeafCheck check(system, deadline);
  return check.possible() ? Search(lcp, check, deadline, accepts).run(Relaxation(lcp)) : BranchingOutcome{};
}

}  // namespace lcpbench::exact
