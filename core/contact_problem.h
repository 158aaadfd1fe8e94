#pragma once

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "core/lcp.h"
#include "core/types.h"

namespace lcpbench {

/// Inertia given whole: G (ngc x ngc), symmetric positive definite [kg, kg m^2].
struct DenseInertia {
  Matrix G;
};

/// Inertia of separate bodies: G = diag(blocks), each block symmetric positive definite.
struct BlockInertia {
  std::vector<Matrix> blocks;
};

/// Inertia as a sum of rank-one updates: G = X diag(alpha) X', exactly; X (ngc x k), alpha (k) > 0.
/// Its rank is at most k; G* is the pseudo-inverse when that is below ngc.
struct FactoredInertia {
  Matrix X;
  Vector alpha;
};

/// Only G* (ngc x ngc) is known: the inverse, or a pseudo-inverse, of an inertia that was not kept.
struct InverseInertia {
  Matrix Ginv;
};

using Inertia = std::variant<DenseInertia, BlockInertia, FactoredInertia, InverseInertia>;

/// The columns of a contact Jacobian, dense or sparse.
using Jacobian = std::variant<Matrix, SparseMatrix>;

Index rows(const Jacobian& J);
Index cols(const Jacobian& J);
/// J as a dense matrix; a copy, also of a dense one.
Matrix to_dense(const Jacobian& J);
/// True when no entry is NaN or infinite; of a sparse J the stored entries, whether it is compressed or not.
bool all_finite(const Jacobian& J);
/// J's column times v; 0 without coordinates, where Eigen's products of sparse columns assert.
inline double dot_column(const Jacobian& J, Index column, const Vector& v) {
  return v.size() == 0 ? 0.0 : std::visit([&](const auto& matrix) { return matrix.col(column).dot(v); }, J);
}

/// Rows beside the contacts, whose impulses have bounds lower <= 0 <= upper: equalities of joints (no bounds), their
/// limits (one), dry friction, motors and brakes (two), and friction that grows with the load on another row.
///
///     w = R'v+ + b + compliance f,     lower <= f <= upper,
///     w >= 0 where f = lower,  w <= 0 where f = upper,  w = 0 between
///
/// A row with friction_of = j has the bounds -mu f_j and mu f_j, j another row whose lower bound is 0. Along an axis R'v+
/// is in m/s and f in N s, around one in rad/s and N m s. [Panagiotopoulos 1985; Pfeiffer, Glocker 1996, 4]
struct BoundedRows {
  Jacobian R;                        ///< ngc x m
  LcpBounds bounds{};                ///< m entries each
  Vector b{};                        ///< m entries, or none where all are zero
  Vector compliance{};               ///< >= 0, alike
  std::vector<char> is_angle{};      ///< m entries: R'v+ is in rad/s
  std::vector<std::string> names{};  ///< m entries, or none

  Index size() const { return bounds.lower.size(); }
  double offset(Index row) const { return b.size() > 0 ? b(row) : 0.0; }
  double yields(Index row) const { return compliance.size() > 0 ? compliance(row) : 0.0; }
  /// "row 3 (hinge)"; "row 3" of a row without a name.
  std::string name_of(Index row) const;
};

/// A rigid-body contact problem in the Anitescu-Potra impulse form.
///
/// Find impulses f_N, f_D >= 0 and slip bounds lambda >= 0 that complete LCP(q, M) with J = [N D],
///
///     M = [ N'G*N  N'G*D  0 ]      q = [ N'v + b ]      z = [ f_N    ]  nc          [N s]
///         [ D'G*N  D'G*D  E ]          [ D'v     ]          [ f_D    ]  sum(edges)  [N s]
///         [ diag(mu) -E'  0 ]          [ 0       ]          [ lambda ]  contacts with edges > 0  [m/s]
///
/// w = [normal velocities + b m/s; slip velocities + lambda m/s; friction slack N s]. M is not formed: see form_lcp.
/// The offset b holds what is known of a contact besides velocities: restitution, gap / h, a correction of positions.
/// D is grouped by contact; inside contact i, column t + edges[i]/2 is the negative of column t. A contact with
/// edges[i] == 0 is frictionless and has neither D columns nor a lambda. [Anitescu, Potra 1997]
///
/// A contact may be soft on purpose, as those of most engines are. With C the directions of its edges in the plane of
/// its two tangents (see edge_direction) and the net tangential impulse f_T = C f_D, its rows are then
///
///     w_N = N'v+ + b + r_n f_N,     w_D = D'v+ + C'(offset_t + r_t f_T) + lambda
///
/// r_t acts on the net impulse, so that more edges do not make a contact stiffer.
///
/// Bounded rows may stand beside the contacts. J is then [N D R], z ends with f_R, and the LCP is mixed.
struct ContactProblem {
  Vector v;                ///< ngc: generalized velocity before the impact [m/s, rad/s]
  Jacobian N;              ///< ngc x nc
  Jacobian D;              ///< ngc x sum(edges)
  std::vector<int> edges;  ///< nc entries, each even and >= 0
  Vector mu;               ///< nc friction coefficients >= 0 (0 where edges is 0)
  Inertia inertia;
  Vector b{};  ///< offset of the normal rows, w_N = N'v+ + b [m/s]: nc entries, or none where all are zero
  Vector compliance_n{};  ///< r_n >= 0 [m/s per N s]: nc entries, or none where all are zero
  Vector compliance_t{};  ///< r_t >= 0 alike, 0 where edges is 0
  Vector offset_t{};      ///< of the velocity along both tangents [m/s]: 2 nc entries, or none where all are zero
  BoundedRows rows{};

  Index ngc() const { return v.size(); }
  Index nc() const { return static_cast<Index>(edges.size()); }
  bool frictional() const { return cols(D) > 0; }
  bool has_rows() const { return rows.size() > 0; }
  bool has_offset() const { return b.size() > 0; }
  double offset(Index contact) const { return has_offset() ? b(contact) : 0.0; }
  bool is_soft() const { return compliance_n.size() > 0 || compliance_t.size() > 0 || offset_t.size() > 0; }
  double normal_compliance(Index contact) const { return compliance_n.size() > 0 ? compliance_n(contact) : 0.0; }
  double tangential_compliance(Index contact) const { return compliance_t.size() > 0 ? compliance_t(contact) : 0.0; }
  /// Along the first tangent (0) or the second (1).
  double tangential_offset(Index contact, int tangent) const {
    return offset_t.size() > 0 ? offset_t(2 * contact + tangent) : 0.0;
  }
};

/// Where each unknown of a contact problem stands in z.
struct ContactLayout {
  Index nc = 0;
  Index friction = 0;                 ///< number of friction columns, sum(edges)
  Index cones = 0;                    ///< number of lambdas
  Index rows = 0;                     ///< number of bounded rows
  std::vector<Index> friction_begin;  ///< nc + 1 offsets of each contact's columns in D
  std::vector<Index> lambda;          ///< nc: index of the contact's lambda among the lambdas, -1 without friction
  std::vector<Index> cone_contact;    ///< cones: the contact of each lambda

  Index size() const { return row_offset() + rows; }
  Index friction_offset() const { return nc; }
  Index lambda_offset() const { return nc + friction; }
  Index row_offset() const { return nc + friction + cones; }
};

/// @param memory  a layout that is no longer needed: its vectors are used again
ContactLayout contact_layout(const ContactProblem& problem, ContactLayout memory = {});

/// Order of M, without forming it.
Index lcp_size(const ContactProblem& problem);

/// Coordinates times coordinates and contacts: what dense matrices of the inertia and the normals hold.
inline Index dense_entries(const ContactProblem& problem) { return problem.ngc() * (problem.ngc() + problem.nc()); }

/// Whether products with this impulse may lose digits to underflow that count in the velocity of a light body.
inline bool is_near_underflow(double impulse) { return impulse != 0 && std::abs(impulse) < 0x1p-600; }

/// Calls visit(matrix, its first coordinate) for each matrix that shows which coordinates the inertia couples: G, whole
/// or by blocks, the factors X, or the given G*.
template <class Visit>
void for_each_matrix(const Inertia& inertia, Visit&& visit) {
  if (const auto* bodies = std::get_if<BlockInertia>(&inertia)) {
    Index first = 0;
    for (const Matrix& block : bodies->blocks) {
      visit(block, first);
      first += block.rows();
    }
  } else if (const auto* dense = std::get_if<DenseInertia>(&inertia)) {
    visit(dense->G, Index{0});
  } else if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    visit(factors->X, Index{0});
  } else {
    visit(std::get<InverseInertia>(inertia).Ginv, Index{0});
  }
}

/// Dimension of the inertia.
Index dimension(const Inertia& inertia);

/// G as a dense matrix, that of FactoredInertia rounded; empty for InverseInertia.
Matrix dense_inertia(const Inertia& inertia);

/// What the inverse that factors in double give must prove before it is used.
enum class InverseProof {
  kRegular,  ///< that G is regular: its digits are those of an elimination in double
  kDigits,   ///< that the inverse is right to 2^-20 or so, too
};

/// G*, dense, in double: the inverse of a regular G, the pseudo-inverse of a singular one.
///
/// Factors in double where they give the proof, or prove that the factors of G are independent; else that of
/// QuadInertia, rounded. Where neither decides, eigenvalues below ngc eps of the largest count as zero.
/// O(ngc^3).
Matrix inverse_inertia(const Inertia& inertia, InverseProof proof = InverseProof::kRegular);

/// Whether G is so far from singular that the inverse of its factors in double proves it: the trace of the inverse of G
/// scaled to unit diagonal is no less than the inverse of its least eigenvalue.
bool is_far_from_singular(const Matrix& G, const Matrix& inverse, InverseProof proof);

/// Whether the rank of X diag(alpha) X' is proven in double, with room: its columns, or where there are more than rows
/// its rows, are far from dependent. O(rows cols min(rows, cols)). @param work  scratch
bool is_far_from_dependent(const FactoredInertia& inertia, std::vector<double>& work);

/// How M is formed in double for the solvers that take (q, M). Answers are judged by the contact problem all the same.
struct MatrixFormation {
  bool plain_inverse = false;  ///< G* by elimination of the rounded G, whatever its rank
  double cone_diagonal = 0;    ///< stands on the diagonal of the cone rows, where M has zeros

  bool operator==(const MatrixFormation&) const = default;
};

/// Forms LCP(q, M) in double from G* and J, all dense; with bounded rows a mixed one. O(ngc (ngc + n)^2), (ngc + n)^2 memory.
Lcp form_lcp(const ContactProblem& problem, const MatrixFormation& formation = {});

/// v+ = v + G* J f, in double; in 113 bits if v+ is not finite in double although v and z are, with NaN if
/// they do not determine G*. Takes the inverse of G, or of each block. @param z  lcp_size(problem) entries
Vector post_impact_velocity(const ContactProblem& problem, const Vector& z);

/// The z of impulses that came without lambda, f_N, f_D and f_R: the least lambda that makes the friction rows feasible
/// completes them.
Vector complete_impulses(const ContactProblem& problem, const Vector& impulses);

}  // namespace lcpbench
