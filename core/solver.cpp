#include "core/solver.h"

#include <array>
#include <stdexcept>
#include <utility>
#include <variant>

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

struct InertiaIsFinite {
  bool operator()(const DenseInertia& i) const { return i.G.allFinite(); }
  bool operator()(const BlockInertia& i) const {
    for (const Matrix& block : i.blocks) {
      if (!block.allFinite()) return false;
    }
    return true;
  }
  bool operator()(const FactoredInertia& i) const { return i.X.allFinite() && i.alpha.allFinite(); }
  bool operator()(const InverseInertia& i) const { return i.Ginv.allFinite(); }
};

bool data_are_finite(const Problem& problem) {
  if (const ContactProblem* contact = problem.contact()) {
    return contact->v.allFinite() && contact->mu.allFinite() && all_finite(contact->N) && all_finite(contact->D) &&
           std::visit(InertiaIsFinite{}, contact->inertia);
  }
  return problem.lcp().M.allFinite() && problem.lcp().q.allFinite();
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

void Solver::load(const Problem& problem) {
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
  answer.velocity.resize(0);
  answer.farkas.resize(0);
  answer.detail.clear();
  if (!refusal_.empty()) {
    answer.claim = Claim::kUnsupported;
    answer.z.resize(0);
    answer.detail = refusal_;
    return;
  }
  answer.z.setZero(problem_.size());
  on_solve(request, answer);
}

}  // namespace lcpbench
