#include "core/solver.h"

#include <array>
#include <bit>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <variant>

#include "core/answer_storage.h"
#include "core/error.h"

namespace lcpbench {
namespace {

constexpr std::array<std::pair<Claim, const char*>, 7> kClaims{{{Claim::kSolved, "solved"},
                                                                {Claim::kUnsolvable, "unsolvable"},
                                                                {Claim::kIterationLimit, "iteration_limit"},
                                                                {Claim::kTimeLimit, "time_limit"},
                                                                {Claim::kNumericalFailure, "numerical_failure"},
                                                                {Claim::kUnsupported, "unsupported"},
                                                                {Claim::kCrashed, "crashed"}}};

/// Eigen's allFinite() looks at one entry after the other, which for small problems takes as long as solving them. x -
/// x has bits only where x is NaN or infinite, and these are gathered in registers.
template <class Dense>
bool finite(const Dense& data) {
  constexpr Index kTogether = 8;
  const double* const entries = data.data();
  const auto bits = [](double x) { return std::bit_cast<std::uint64_t>(x - x); };
  std::uint64_t all = 0;
  Index i = 0;
  for (; i + kTogether <= data.size(); i += kTogether) {
    std::uint64_t some = 0;
    for (Index k = 0; k < kTogether; ++k) some |= bits(entries[i + k]);
    all |= some;
  }
  for (; i < data.size(); ++i) all |= bits(entries[i]);
  return all == 0;
}

bool finite(const Jacobian& J) {
  const auto* dense = std::get_if<Matrix>(&J);
  return dense != nullptr ? finite(*dense) : all_finite(J);
}

struct InertiaIsFinite {
  bool operator()(const DenseInertia& i) const { return finite(i.G); }
  bool operator()(const BlockInertia& i) const {
    for (const Matrix& block : i.blocks) {
      if (!finite(block)) return false;
    }
    return true;
  }
  bool operator()(const FactoredInertia& i) const { return finite(i.X) && finite(i.alpha); }
  bool operator()(const InverseInertia& i) const { return finite(i.Ginv); }
};

bool data_are_finite(const Problem& problem) {
  if (const ContactProblem* contact = problem.contact()) {
    return finite(contact->v) && finite(contact->mu) && finite(contact->N) && finite(contact->D) &&
           finite(contact->b) && std::visit(InertiaIsFinite{}, contact->inertia);
  }
  return finite(problem.lcp().M) && finite(problem.lcp().q);
}

/// Empties a vector; `memory` gets its storage.
void clear_into(Vector& vector, Vector& memory) {
  if (vector.size() == 0) return;
  memory.swap(vector);
  vector.resize(0);
}

}  // namespace

const char* to_string(Claim claim) {
  for (const auto& [value, name] : kClaims) {
    if (value == claim) return name;
  }
  return "unknown";
}

Claim parse_claim(std::string_view text) {
  for (const auto& [value, name] : kClaims) {
    if (text == name) return value;
  }
  throw InputError("unknown claim '" + std::string(text) + "'");
}

const char* to_string(Needs needs) {
  switch (needs) {
    case Needs::kDense: return "dense";
    case Needs::kFactored: return "factored";
    case Needs::kScene: return "scene";
  }
  return "unknown";
}

std::string why_not(const Capabilities& capabilities, const Problem& problem) {
  if (capabilities.needs == Needs::kScene && problem.scene() == nullptr) return "needs a rigid-body scene";
  if (capabilities.needs == Needs::kFactored && problem.contact() == nullptr) {
    return "needs the contact problem (v, N, D, mu, G), not only (q, M)";
  }
  if (problem.size() > capabilities.max_size) {
    return "n = " + std::to_string(problem.size()) + " is over its limit of " + std::to_string(capabilities.max_size);
  }
  if (!data_are_finite(problem)) return "the data hold NaN or infinity";
  if (capabilities.frictionless_only) {
    if (const ContactProblem* contact = problem.contact()) {
      if (contact->frictional()) return "needs a symmetric M: frictionless contacts only";
    } else if (problem.lcp().M != problem.lcp().M.transpose()) {
      return "needs a symmetric M";
    }
  }
  return {};
}

Lcp make_lcp(const Problem& problem) {
  return problem.contact() != nullptr ? form_lcp(*problem.contact()) : problem.lcp();
}

ClearedVectors& cleared_vectors() {
  thread_local ClearedVectors vectors;
  return vectors;
}

void Solver::load(const Problem& problem) {
  cleared_vectors();  // a thread's first use of them allocates
  problem_ = problem;
  refusal_ = why_not(capabilities(), problem);
  if (refusal_.empty()) on_load(problem);
}

void Solver::update(const Vector& v) {
  const ContactProblem* contact = refusal_.empty() ? problem_.contact() : nullptr;
  if (contact == nullptr || v.size() != contact->ngc()) {
    throw std::invalid_argument("update(v): needs a loaded contact problem and v of its ngc entries");
  }
  on_update(v);
}

void Solver::on_update(const Vector& v) {
  ContactProblem contact = *problem_.contact();
  contact.v = v;
  load(Problem(problem_.name(), std::move(contact)));
}

void Solver::solve(const SolveRequest& request, Answer& answer) {
  answer.claim = Claim::kNumericalFailure;
  answer.counters = Counters{};
  clear_into(answer.velocity, cleared_vectors().velocity);
  clear_into(answer.farkas, cleared_vectors().farkas);
  answer.detail.clear();
  if (!refusal_.empty()) {
    answer.claim = Claim::kUnsupported;
    answer.z.resize(0);
    answer.detail = refusal_;
    return;
  }
  if (answer.z.size() == 0) answer.z.swap(cleared_vectors().z);
  answer.z.setZero(problem_.size());
  on_solve(request, answer);
  // A solver that refuses only here may leave the zeros it was handed, and zeros solve some problems.
  if (answer.claim == Claim::kUnsupported) {
    clear_into(answer.z, cleared_vectors().z);
    clear_into(answer.velocity, cleared_vectors().velocity);
    clear_into(answer.farkas, cleared_vectors().farkas);
  }
}

}  // namespace lcpbench
