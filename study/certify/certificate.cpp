#include "study/certify/certificate.h"

namespace lcpbench {

const char* to_string(CertificateKind kind) {
  switch (kind) {
    case CertificateKind::kSolution: return "solution";
    case CertificateKind::kUnsolvable: return "unsolvable";
    case CertificateKind::kOpen: return "open";
  }
  return "";
}

const char* to_string(ProofKind proof) {
  switch (proof) {
    case ProofKind::kNone: return "none";
    case ProofKind::kExactBasis: return "exact_basis";
    case ProofKind::kFarkas: return "farkas";
    case ProofKind::kLp: return "lp";
    case ProofKind::kEnumeration: return "enumeration";
    case ProofKind::kBranching: return "branching";
  }
  return "";
}

}  // namespace lcpbench
