#include <exception>
#include <new>
#include <string>
#include <utility>

#include <flint/flint.h>

#include "core/error.h"
#include "study/certify/candidates.h"
#include "study/certify/certificate.h"
#include "study/certify/deadline.h"
#include "study/certify/truth_search.h"

namespace lcpbench {
namespace {

bool finite(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return dense->G.allFinite();
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    return factors->X.allFinite() && factors->alpha.allFinite();
  }
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) return inverse->Ginv.allFinite();
  for (const Matrix& block : std::get<BlockInertia>(inertia).blocks) {
    if (!block.allFinite()) return false;
  }
  return true;
}

bool finite(const Problem& problem) {
  if (const ContactProblem* contact = problem.contact()) {
    return contact->v.allFinite() && all_finite(contact->N) && all_finite(contact->D) && contact->mu.allFinite() &&
           contact->b.allFinite() && finite(contact->inertia);
  }
  return problem.lcp().M.allFinite() && problem.lcp().q.allFinite();
}

/// FLINT keeps memory for each thread; this gives it back when the thread ends.
struct FlintMemory {
  ~FlintMemory() { flint_cleanup(); }
};

}  // namespace

class Certifier::Engine {
 public:
  explicit Engine(CertifyOptions options) : options_(options) {}

  Certificate certify(const Problem& problem) {
    if (!finite(problem)) throw InputError(problem.name() + ": the data hold a NaN or an infinity; nothing is exact");
    [[maybe_unused]] static thread_local FlintMemory memory;
    const exact::Deadline deadline = options_.most_work > 0 ? exact::Deadline::after_work(options_.most_work)
                                                            : exact::Deadline(options_.time_limit_s);
    Certificate certificate = certify_contained(problem, deadline);
    certificate.seconds = deadline.elapsed_s();
    return certificate;
  }

 private:
  /// Whatever one problem makes fail leaves this problem open, and the next ones as they are.
  Certificate certify_contained(const Problem& problem, const exact::Deadline& deadline) {
    Certificate open;
    try {
      return exact::search_truth(problem, options_, deadline, candidates_);
    } catch (const exact::TimePassed& passed) {
      open.detail = passed.what();
      return open;
    } catch (const std::bad_alloc&) {
      open.detail = "the memory did not suffice";
    } catch (const std::exception& error) {
      open.detail = std::string("the search failed: ") + error.what();
    }
    candidates_ = {};  // a solver that was interrupted is not asked again
    return open;
  }

  CertifyOptions options_;
  exact::Candidates candidates_;
};

Certifier::Certifier(CertifyOptions options) : engine_(std::make_unique<Engine>(options)) {}

Certifier::~Certifier() = default;

Certificate Certifier::certify(const Problem& problem) { return engine_->certify(problem); }

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
    case ProofKind::kBranching: return "branching";
  }
  return "";
}

}  // namespace lcpbench
