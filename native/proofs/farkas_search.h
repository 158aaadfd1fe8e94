#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/lcp.h"
#include "core/quad.h"

namespace lcpbench {

/// Looks for vectors of doubles that prove exactly that a bare LCP is infeasible.
///
/// The cone {u >= 0, M'u <= 0} is searched by the simplex method for a ray with q'u < 0, first in double, which mostly
/// shows that there is none, then in 113 bits. What is found is scaled and rounded to doubles in several ways until one
/// of them proves it exactly; where the cone has an interior ray of that kind, one is found that survives rounding.
/// Some infeasible problems have no proof in doubles: of these nothing is found. Memory: (n + 1)(n + 2) doubles, and as
/// many of 113 bits up to kLargestQuad rows, touched only in find(). [Farkas 1902; Dantzig 1963, chapter 5]
class FarkasSearch {
 public:
  /// Above this number of rows the search ends with what double shows.
  static constexpr Index kLargestQuad = 160;

  /// @param lcp must stay as it is until the next load. Allocates.
  void load(const Lcp& lcp);

  /// Looks for such a u among those that are zero but for the rows that `candidates` marks. Allocates nothing.
  /// @param candidates n flags @param deadline_s on wall_clock_s() @returns whether proof() is one
  bool find(const std::vector<char>& candidates, double deadline_s);

  /// As find(), but only by rounding u, which proves it nearly.
  bool round(const Vector& u);

  /// Whether the last find() found a ray that proves it clearly, but for the rounding of its inequalities: any solution
  /// would be many orders of magnitude larger than the data, though none of its roundings may be a proof.
  bool found_near_proof() const { return near_proof_; }

  /// @pre the last find() or round() was true
  const Vector& proof() const { return proof_; }

 private:
  template <class Scalar>
  struct Tableau;
  enum class End { kRay, kNone, kDoubtful };
  enum class Goal { kSteepest, kInterior };

  void drop_rows_without_part();
  bool scale_rows_and_columns();
  template <class Scalar>
  End search(Scalar* storage, Goal goal, double deadline_s);
  template <class Scalar>
  void fill(Tableau<Scalar>& tableau, Goal goal);
  template <class Scalar>
  End pivot_to_end(Tableau<Scalar>& tableau, double deadline_s);
  template <class Scalar>
  void take_ray(const Tableau<Scalar>& tableau, Index entering);
  bool is_near_proof() const;
  bool rounds_to_proof();
  bool rounds_with_unit(Quad unit);
  bool rounds_to_integers();

  const Lcp* lcp_ = nullptr;
  std::vector<char> in_;                             // n: rows that a u may use
  std::vector<Index> rows_;                          // those rows, n reserved
  std::vector<Index> columns_;                       // those of M with a positive entry on rows_, n reserved
  std::vector<int> row_exponent_, column_exponent_;  // n: of the scaling by powers of two
  int cost_exponent_ = 0;                            // of that of q
  bool wide_ = false;                                // scaled entries differ too much in size for double
  std::unique_ptr<double[]> double_;                 // the tableaus, for so many rows
  std::unique_ptr<Quad[]> quad_;
  Index room_ = -1;
  std::vector<Index> at_row_, at_column_;  // which variable is there: a row, then t where it is sought, then columns
  std::vector<Quad> ray_;                  // n
  Quad ray_error_ = 0;                     // relative, of its entries
  std::vector<Index> support_;             // of ray_, n reserved
  bool near_proof_ = false;
  Vector proof_;  // n
};

}  // namespace lcpbench
