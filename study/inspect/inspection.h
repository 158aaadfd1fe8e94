#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.h"
#include "study/inspect/classes.h"
#include "study/inspect/spectra.h"

namespace lcpbench {

/// What is computed with dense matrices (spectra, ranks, pairs of contacts) is left out above this order.
inline constexpr Index kLargestDense = 600;

/// Least and largest of some positive magnitudes; both NaN where there are none.
struct Range {
  double low = Spectrum::kNone;
  double high = Spectrum::kNone;

  void add(double magnitude);
  /// high / low; NaN where there are none.
  double spread() const { return high / low; }
};

/// A rank seen in two ways; -1: not computed.
struct Rank {
  Index exact = -1;  ///< of the doubles as they are
  /// By singular values, columns scaled to length 1. Of M: those above 4 n eps. Of N and [N D]: those above 2^-26, as
  /// smaller ones are lost when M = J'G*J squares them in double.
  Index visible = -1;
};

/// (q, M) as a solver on matrices is given it, for a contact problem formed in double.
struct MatrixFacts {
  bool dense = false;    ///< false: too large, only the sizes below hold
  double asymmetry = 0;  ///< largest |M_ij - M_ji| relative to the largest |M_ij|
  Spectrum symmetric;    ///< of (M + M')/2; of a frictional problem without rows of friction cones
  double condition = 0;  ///< largest / smallest nonzero |eigenvalue| of the same with unit diagonal
  Rank rank;             ///< of M, columns scaled to length 1
  Range entries;         ///< nonzero |M_ij|
  Range diagonal;        ///< nonzero |M_ii|
  Range row_sizes;       ///< largest |M_ij| of each nonzero row
  Range column_sizes;    ///< the same of columns
  Index zero_rows = 0;   ///< rows of M without a nonzero entry
  Index negative_diagonal = 0;
  double least_diagonal = 0;
  bool z_matrix = false;
  Tri p_matrix = Tri::kUnknown;
  Tri copositive = Tri::kUnknown;
  std::optional<std::pair<Index, Index>> not_copositive_at;
  Index impossible_rows = 0;             ///< no positive entry and q_i < 0: a proof that there is no solution
  Index impossible_rows_transposed = 0;  ///< the same for M'
  Index impossible_rows_negated = 0;     ///< the same for -M
  Index cone_rows = 0;             ///< rows like those of a friction cone [mu .. -1 .. 0] whose column is [0 .. 1 .. 0]
  Index cone_rows_transposed = 0;  ///< the same with row and column exchanged
  Index islands = 0;               ///< blocks of M that share no nonzero entry
  Index largest_island = 0;        ///< unknowns of the largest block
};

/// What q says. For a contact problem of its normal rows N'v + b, the speeds at which contacts approach (< 0).
struct VelocityFacts {
  Index negative = 0;
  Index zero = 0;
  Index positive = 0;
  double least = 0;
  double largest_magnitude = 0;
  Index ties = 0;         ///< entries equal to a negative least one; 0 where that is alone or none is negative
  Index not_pressed = 0;  ///< q_i > 0 and no negative entry in row i of M: z_i = 0 in every solution; -1: not computed
};

/// Two contacts whose columns of N are parallel, or almost. Distance of the two unit vectors in coordinates scaled by
/// sqrt(G_ii), which no change of units moves.
struct ContactPair {
  Index first = 0;
  Index second = 0;
  double distance = 0;
  bool opposed = false;  ///< distance to the negative of the other
};

struct ContactFacts {
  std::string inertia;  ///< "dense G", "blocks of G", "factors of G" or "G inverse only"
  Index inertia_rank = -1;
  bool proven_definite = false;         ///< G, or the given G*, proven positive definite in 113 bits
  double inertia_condition = 0;         ///< in the units given; of the nonzero eigenvalues
  double scaled_condition = 0;          ///< with unit diagonal
  Rank normals;                         ///< of N, rows scaled by sqrt(G_ii)
  Rank jacobian;                        ///< of [N D]
  Spectrum truth;                       ///< of [N D]'G*[N D] formed from the factors in 113 bits; opposite columns once
  double condition = Spectrum::kNone;   ///< largest / smallest nonzero eigenvalue of the same with unit diagonal
  Index bodies = 0;                     ///< where G is that of rigid bodies in space, diag(m I, inertia) each; else 0
  Range masses;                         ///< of these bodies
  Range compliance_n, compliance_t;     ///< of soft contacts, those that are not 0
  Index bodies_as_inverse = 0;          ///< bodies for which the inverse of what was given is likelier
  Index bodies_judged = 0;              ///< bodies with contacts that this can be said of
  Index bodies_too_long = 0;            ///< bodies whose lengths look as if they were in smaller units than metres
  bool normals_by_rows = false;         ///< N square, its rows but not its columns are unit normals of rigid bodies
  std::vector<ContactPair> duplicates;  ///< distance 0, or of opposed ones: exactly parallel
  std::vector<ContactPair> near_duplicates;
  std::vector<ContactPair> opposed;
  Index zero_normals = 0;         ///< columns of N that are zero
  Index immovable = 0;            ///< nonzero columns of N that G* makes zero, to rounding
  Index frictional_contacts = 0;  ///< with edges
  Index zero_mu = 0;              ///< of these, with mu = 0
  double largest_mu = 0;
  Index zero_directions = 0;  ///< columns of D that are zero
  Index directions_along_normal = 0;
  bool pairs_compared = false;  ///< false: too many contacts
  Index islands = 0;            ///< contacts that meet in no coordinate, directly or through others
  Index largest_island = 0;     ///< contacts of the largest
};

/// What the number behind a warning is about.
enum class Concern {
  kData,       ///< the data are probably not what was meant
  kDifficulty  ///< the data are as they are, and hard on solvers
};

/// "data" or "difficulty".
const char* to_string(Concern concern);

struct Warning {
  std::string code;  ///< stable, for programs: docs/reference/inspect.md lists them all
  Concern concern = Concern::kDifficulty;
  double value = 0;  ///< the number behind it
  std::string text;  ///< one plain sentence
};

struct Inspection {
  std::string name;
  ProblemKind kind = ProblemKind::kLcp;
  Index n = 0;
  std::optional<ContactFacts> contact;
  Index ngc = 0;
  Index nc = 0;
  std::vector<int> edges;  ///< of each contact
  Index friction_columns = 0;
  MatrixFacts matrix;
  VelocityFacts velocity;
  std::vector<Warning> warnings;  ///< doubts about the data first
};

/// Looks at a problem; solves nothing. A function of the data alone. O(n^3), up to a few seconds at kLargestDense.
/// @pre the problem's data are finite and passed the reader's checks.
Inspection inspect(const Problem& problem);

/// What the facts give reason to warn of.
std::vector<Warning> warnings_of(const Inspection& inspection);

}  // namespace lcpbench
