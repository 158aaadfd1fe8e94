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
  kEveryBasis,  ///< no basis gives a solution: checked by trying every one again
  kLp,          ///< `exact_farkas` proves, for friction, that a solution exists, without giving one
};

/// "solution", "unsolvable", "open".
const char* to_string(CertificateKind kind);

/// "none", "exact_basis", "farkas", "every_basis", "lp".
const char* to_string(ProofKind proof);

/// Exact rationals over one common positive denominator: decimal integers as GMP writes them ("-17"). Empty: no vector.
struct ExactVector {
  std::string denominator;
  std::vector<std::string> numerators;
};

/// The certified truth of one problem. Exact vectors are in the units of the problem (N s, m/s); that of kFarkas may be
/// scaled by any positive number. docs/explanation/certificates.md says what each of them proves, and what the
/// potential p is.
struct Certificate {
  CertificateKind kind = CertificateKind::kOpen;
  ProofKind proof = ProofKind::kNone;
  Vector z;                             ///< n: exact_z, each entry correctly rounded to double; empty where none
  Vector velocity;                      ///< ngc: exact_velocity, correctly rounded; empty where none
  std::optional<bool> velocity_unique;  ///< true: every solution has this velocity; false: another is certified
  Vector farkas;                        ///< exact_farkas scaled to a largest entry of 1 and rounded, for display
  ExactVector exact_z;                  ///< n
  ExactVector exact_potential;          ///< p; empty for bare LCPs
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
  /// Problems of at most so many unknowns are decided by every basis, unless K, the inertia in the potentials, is
  /// singular.
  static constexpr Index kFewUnknowns = 12;

  explicit Certifier(CertifyOptions options) : options_(options) {}

  /// @throws InputError for NaN or infinite data.
  Certificate certify(const Problem& problem);

 private:
  CertifyOptions options_;
  exact::Candidates candidates_;
};

}  // namespace lcpbench
