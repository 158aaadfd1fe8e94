#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.h"
#include "core/types.h"
#include "study/certify/candidates.h"

namespace lcpbench {

/// What is certain about a problem.
enum class CertificateKind {
  kSolution,    ///< it has a solution; one stands in the certificate, unless the proof is kLp
  kUnsolvable,  ///< it has none
  kOpen,        ///< neither was proven
};

/// How a certificate is proven. Every proof is over the rationals on the data as given: no tolerance anywhere.
enum class ProofKind {
  kNone,
  kExactBasis,  ///< `exact_z` is a solution: checked by multiplication
  kFarkas,      ///< `exact_farkas` contradicts solvability: checked by multiplication
  kLp,          ///< `exact_farkas` proves, for friction, that a solution exists, without giving one
};

/// "solution", "unsolvable", "open".
const char* to_string(CertificateKind kind);

/// "none", "exact_basis", "farkas", "lp".
const char* to_string(ProofKind proof);

/// Exact rationals over one common positive denominator: decimal integers as GMP writes them ("-17"). Empty: no vector.
struct ExactVector {
  std::string denominator;
  std::vector<std::string> numerators;
};

/// The certified truth of one problem. Exact vectors are in the units of the problem (N s, m/s); that of kFarkas may be
/// scaled by any positive number.
///
/// What is proven, with C = [N D], f = [f_N; f_D] the impulses in z, q = C'v + [b; 0], and p, the "potential", the
/// change of velocity in some coordinates:
///  - p solves K p = B f, and w_N = N'v+ + b, w_D = D'v+ + lambda, where
///      G given:        K = G,               B = C,    v+ = v + p      (p has ngc entries)
///      factors given:  K = (X'X) A (X'X),   B = X'C,  v+ = v + X p    (G = X A X', A = diag(alpha), factors of alpha
///                      0 left out; p has an entry for each of the others)
///      Ginv given:     no system: p = Ginv C f,  B = C,  v+ = v + p
///  - exact basis:  f, lambda >= 0; w >= 0; z_j w_j = 0 for every j. The w of the cone row of contact i is mu_i f_N,i
///    less the sum of its f_D.
///  - Farkas, contact problem: u = exact_farkas has the length of f; u >= 0, B u = 0 (Ginv given: Ginv C u = 0), every
///    contact's friction parts are 0, and q'u < 0.
///  - Farkas, bare LCP: y = exact_farkas has n entries: y >= 0, M'y <= 0, q'y < 0.
///  - lp: d = exact_farkas has the length of p, and w = q + C'R d, R = X where factors are given, else I, satisfies
///    for every contact i w_N,i >= mu_i * max(0, max over its friction rows of -w_D): no f in the friction cones with
///    B f = 0 has q'f < 0. G is positive semidefinite (Ginv definite) and mu >= 0, so that a solution exists.
///  - Soft contacts: compliance_n f_N is added to w_N, tangential offsets and compliance to w_D, and so to q and M.
///    Farkas: u_i = 0 where compliance_n > 0. lp: nothing is asked of contacts with compliance_n > 0, and only w_N >= 0
///    of others with compliance_t > 0.
struct Certificate {
  CertificateKind kind = CertificateKind::kOpen;
  ProofKind proof = ProofKind::kNone;
  Vector z;                             ///< n: exact_z, each entry correctly rounded to double; empty where none
  Vector velocity;                      ///< ngc: exact_velocity, correctly rounded; empty where none
  std::optional<bool> velocity_unique;  ///< true: every solution has this velocity; false: another is certified
  Vector farkas;                        ///< exact_farkas scaled to a largest entry of 1 and rounded, for display
  ExactVector exact_z;                  ///< n
  ExactVector exact_potential;          ///< p above; empty for bare LCPs
  ExactVector exact_velocity;           ///< ngc: v+; empty for bare LCPs
  ExactVector exact_farkas;             ///< the proof of kFarkas or kLp
  ExactVector exact_other_z;            ///< where velocity_unique is false: a second solution
  ExactVector exact_other_potential;    ///< its p
  double seconds = 0;                   ///< wall clock of certify()
  std::string detail;                   ///< one line: what found the proof, or what was tried in vain
};

struct CertifyOptions {
  /// Wall clock; kOpen without a proof by then. No step is begun that is expected to take longer than what is left.
  double time_limit_s = 10;
  bool seek_other_velocity = false;  ///< frictional problems: look for a second solution with another velocity
  /// Above 0: the number of steps, of some microseconds each, that the search may take in place of the time limit, so
  /// that every machine finds the same. The floating-point solvers of the candidates then have no limit.
  std::int64_t most_work = 0;
};

/// Finds the exact truth of problems: candidate bases from float solvers, then FLINT's integers on the factored data.
///
/// Monotone problems (no friction, G semidefinite) with n and ngc up to 128 are decided, given time, unless integers
/// grow too long; any other may stay kOpen. The same problem gives the same certificate on any machine unless the time
/// limit strikes.
/// One object per thread; it keeps its solvers and workspaces between calls.
class Certifier {
 public:
  explicit Certifier(CertifyOptions options) : options_(options) {}

  /// @throws InputError for NaN or infinite data.
  Certificate certify(const Problem& problem);

 private:
  CertifyOptions options_;
  exact::Candidates candidates_;
};

}  // namespace lcpbench
