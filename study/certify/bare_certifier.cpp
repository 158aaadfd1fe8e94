#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/certify/basis.h"
#include "study/certify/branching.h"
#include "study/certify/certifiers.h"
#include "study/certify/exact_checks.h"
#include "study/certify/exact_lemke.h"
#include "study/certify/exact_output.h"
#include "study/certify/reduction.h"

namespace lcpbench::exact {
namespace {

constexpr Index kLargestLemke = 60;
constexpr int kExchanges = 8;
constexpr const char* kSolvers[] = {"lemke{test=none}", "lemke{precision=quad}"};

class BareCertifier {
 public:
  BareCertifier(const Problem& problem, const Deadline& deadline, Candidates& candidates)
      : problem_(problem), deadline_(deadline), candidates_(candidates), system_(bare_system(problem.lcp())) {}

  Certificate run() {
    const bool decided = solved_by(kSolvers[0]) || solved_by(kSolvers[1]) || settled_by_exact_lemke() || branched();
    if (!decided) certificate_.detail = deadline_.passed() ? "the time limit passed" : "no proof was found either way";
    return std::move(certificate_);
  }

 private:
  bool solved_by(const char* spec) {
    if (deadline_.passed()) return false;
    const Answer& answer = candidates_.answer(spec, problem_, deadline_.left_s());
    if (answer.claim != Claim::kSolved) return false;
    return solved_near(answer.z, "basis of " + std::string(spec));
  }

  bool solved_near(const Vector& z, const std::string& found_by) {
    std::vector<Index> basis = support(z, system_.size());
    for (int round = 0; round <= kExchanges && !deadline_.passed(); ++round) {
      std::optional<ExactPoint> point = basis_point(system_, basis, deadline_);
      if (!point)
        point = purified_point(system_, basis, round == 0 ? tight_rows(problem_, z) : std::vector<Index>{}, deadline_);
      if (!point) return false;
      if (is_solution(system_, *point, deadline_)) return take_solution(*point, found_by);
      if (round == 0 && settled_near_answer(z, found_by)) return true;
      std::vector<Index> next = exchanged_basis(system_, *point, deadline_);
      if (next == basis) return false;
      basis = std::move(next);
    }
    return false;
  }

  bool settled_near_answer(const Vector& z, const std::string& found_by) {
    const Guess guess = classified(problem_, z, kClear);
    if (guess.unclear.empty() || guess.unclear.size() > kMostUnclear) return false;
    const auto accepts = [&](const ExactPoint& point) { return is_solution(system_, point, deadline_); };
    const std::optional<ExactPoint> point = settled_near(system_, guess, deadline_, accepts);
    return point && take_solution(*point, found_by);
  }

  bool settled_by_exact_lemke() {
    if (system_.size() > kLargestLemke || deadline_.passed()) return false;
    const LemkeOutcome outcome = exact_lemke(lcp(), deadline_);
    if (outcome.ending == LemkeEnding::kSolution) {
      return take_solution({{}, outcome.z, outcome.denominator}, "exact lexicographic Lemke");
    }
    return outcome.ending == LemkeEnding::kRay && take_contradiction(outcome.z, "ray of exact lexicographic Lemke");
  }

  bool branched() {
    if (deadline_.passed()) return false;
    BranchingOutcome outcome = branch(problem_.lcp(), LeafCheck(system_, deadline_), deadline_,
                                      [this](const Vector& z) { return solved_near(z, "branch and bound"); });
    if (outcome.solved) return true;
    if (outcome.solution) return take_solution(*outcome.solution, "branch and bound");
    if (outcome.proof.empty()) return false;
    if (outcome.proof.size() == 1) {
      return take_contradiction(multipliers(outcome.proof.front()), "the linear inequalities contradict each other");
    }
    take_branches(std::move(outcome.proof), certificate_);
    return true;
  }

  IntegerVector multipliers(const ProofNode& leaf) const {
    IntegerVector y(static_cast<std::size_t>(system_.size()));
    const slong least = *std::min_element(system_.w_exponent.begin(), system_.w_exponent.end());
    for (const Multiplier& entry : leaf.multipliers) {
      const auto row = static_cast<std::size_t>(entry.row);
      fmpz_set_str(y[row].get(), entry.value.c_str(), 10);
      fmpz_mul_2exp(y[row].get(), y[row].get(), static_cast<ulong>(system_.w_exponent[row] - least));
    }
    return y;
  }

  bool take_solution(const ExactPoint& point, const std::string& detail) {
    if (!is_solution(system_, point, deadline_)) return false;
    const ScaledVector z = scaled_z(system_, point);
    certificate_.kind = CertificateKind::kSolution;
    certificate_.proof = ProofKind::kExactBasis;
    certificate_.exact_z = to_text(z);
    certificate_.z = to_doubles(z);
    certificate_.detail = detail;
    return true;
  }

  bool take_contradiction(const IntegerVector& y, const std::string& detail) {
    if (!is_bare_contradiction(system_, y, deadline_)) return false;
    std::vector<slong> exponents = system_.w_exponent;  // y_i w_i has the unit of w_i: y_i the inverse of it
    for (slong& exponent : exponents) exponent = -exponent;
    const ScaledVector farkas{y, std::move(exponents), Integer(1)};
    certificate_.kind = CertificateKind::kUnsolvable;
    certificate_.proof = ProofKind::kFarkas;
    certificate_.exact_farkas = to_text(farkas);
    certificate_.farkas = to_unit_doubles(farkas);
    certificate_.detail = detail;
    return true;
  }

  // Formed when a float basis did not do.
  const IntegerLcp& lcp() {
    if (!lcp_) lcp_ = std::move(without_potentials(system_, deadline_)->lcp);
    return *lcp_;
  }

  const Problem& problem_;
  const Deadline& deadline_;
  Candidates& candidates_;
  ExactSystem system_;
  std::optional<IntegerLcp> lcp_;
  Certificate certificate_;
};

}  // namespace

Certificate certify_bare(const Problem& problem, const Deadline& deadline, Candidates& candidates) {
  return BareCertifier(problem, deadline, candidates).run();
}

}  // namespace lcpbench::exact
