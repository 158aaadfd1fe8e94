// Whether independent ways to the truth of frictionless problems agree: one CSV row for each set. Not a test;
// results/certify/README.md has its command.
//
//   certify_agreement TRIALS SEED SET...
//
// Each problem is decided three times over the rationals, each way alone: by the certificate (a float solver's basis or
// the support of a least-squares solution, checked), by exact lexicographic Lemke from its covering vector, and by the
// exact linear program that asks for a change of velocity after which no contact approaches: a frictionless problem has
// a solution exactly when there is one. Then every native solver that takes the problem answers it.
//
// Columns: what the three said; `disagreements`, problems on which two of them differ; `undecided`, problems on which
// one of them hit a minute; `answers` and `verified` answers of the solvers; `above_limit`, verified answers (rho <=
// 1e-4) to problems that are proven unsolvable; `contradictions`, those of them with rho <= 1e-9, and answers whose
// own exact proof of unsolvability a solution contradicts.

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/registry.h"
#include "generators/sets.h"
#include "study/certify/certificate.h"
#include "study/certify/contact_truth.h"
#include "study/certify/enumerate.h"
#include "study/certify/exact_checks.h"
#include "study/certify/reduction.h"
#include "study/evaluation/evaluation.h"

namespace lcpbench {
namespace {

constexpr double kLimit = 60;
constexpr double kAsGoodAsExact = 1e-9;
constexpr const char* kSolvers[] = {"active_set",  "auto",        "contact_lemke",      "lemke",
                                    "murty",       "primal_dual", "principal_pivoting", "psor",
                                    "regularized", "velocity_ipm"};

enum class Word { kSolvable, kUnsolvable, kUndecided };

struct Row {
  int solvable[3] = {};
  int unsolvable[3] = {};
  int disagreements = 0;
  int undecided = 0;
  int answers = 0;
  int verified = 0;
  int above_limit = 0;
  int contradictions = 0;
};

Word by_certificate(const Certificate& certificate) {
  if (certificate.kind == CertificateKind::kSolution) return Word::kSolvable;
  return certificate.kind == CertificateKind::kUnsolvable ? Word::kUnsolvable : Word::kUndecided;
}

/// Exact Lemke's own word, believed only as far as multiplication confirms it.
Word by_lemke(const exact::ContactTruth& truth, const exact::ReducedSystem& eliminated) {
  const exact::LemkeOutcome outcome = exact_lemke(eliminated.lcp, exact::Deadline(kLimit));
  if (outcome.ending == exact::LemkeEnding::kSolution) {
    exact::ExactPoint point = expanded(eliminated, truth.system(), outcome.z, outcome.denominator);
    return is_solution(truth.stated(), truth.stated(std::move(point)), exact::Deadline(kLimit)) ? Word::kSolvable
                                                                                                : Word::kUndecided;
  }
  const bool proven = outcome.ending == exact::LemkeEnding::kRay &&
                      is_contradiction(truth.stated(), outcome.z, exact::Deadline(kLimit));
  return proven ? Word::kUnsolvable : Word::kUndecided;
}

/// q + R'p >= 0 for some p of either sign: p = p_1 - p_2.
Word by_linear_program(const exact::ExactSystem& system) {
  const Index potentials = system.potentials();
  exact::IntegerMatrix A(system.size(), 2 * potentials);
  for (Index i = 0; i < system.size(); ++i) {
    for (Index j = 0; j < potentials; ++j) {
      fmpz_set(A(i, j), system.R(j, i));
      fmpz_neg(A(i, potentials + j), system.R(j, i));
    }
  }
  switch (feasible_point(A, system.q, exact::Deadline(kLimit)).feasibility) {
    case exact::Feasibility::kFeasible: return Word::kSolvable;
    case exact::Feasibility::kInfeasible: return Word::kUnsolvable;
    case exact::Feasibility::kUnknown: break;
  }
  return Word::kUndecided;
}

void hear(const Problem& problem, bool solvable, Solver& solver, Evaluator& evaluator, Row& row) {
  Answer answer;
  solver.load(problem);
  solver.solve({}, answer);
  ++row.answers;
  const Errors errors = evaluator.errors(answer);
  row.verified += errors.solved;
  row.above_limit += !solvable && errors.solved;
  const bool disproof = answer.farkas.size() > 0 && evaluator.check_farkas(answer.farkas);
  row.contradictions += solvable ? disproof : errors.velocity_residual_relative <= kAsGoodAsExact;
}

void decide(const Problem& problem, Certifier& certifier, std::vector<std::unique_ptr<Solver>>& solvers, Row& row) {
  const exact::Deadline deadline(kLimit);
  const exact::ContactTruth truth(*problem.contact(), deadline);
  const auto eliminated = without_potentials(truth.system(), deadline);
  const Word words[3] = {by_certificate(certifier.certify(problem)),
                         eliminated ? by_lemke(truth, *eliminated) : Word::kUndecided,
                         by_linear_program(truth.system())};
  bool all = true;
  for (int way = 0; way < 3; ++way) {
    row.solvable[way] += words[way] == Word::kSolvable;
    row.unsolvable[way] += words[way] == Word::kUnsolvable;
    all = all && words[way] != Word::kUndecided;
  }
  row.undecided += !all;
  row.disagreements += all && (words[1] != words[0] || words[2] != words[0]);
  if (words[0] == Word::kUndecided) return;
  Evaluator evaluator(problem);
  for (const auto& solver : solvers) hear(problem, words[0] == Word::kSolvable, *solver, evaluator, row);
}

void compare(const std::string& name, int trials, std::uint64_t seed) {
  const std::unique_ptr<ProblemSet> set = open_set(name);
  Certifier certifier({.time_limit_s = kLimit});
  std::vector<std::unique_ptr<Solver>> solvers;
  for (const char* solver : kSolvers) solvers.push_back(make_solver({solver, {}}));
  Row row;
  for (int trial = 0; trial < trials; ++trial) decide(set->generate(seed, trial), certifier, solvers, row);
  std::printf("\"%s\",%d,%d,%d,%d,%d,%d,%d,%d,%d,%d,%d,%d,%d\n", set->name().c_str(), trials, row.solvable[0],
              row.unsolvable[0], row.solvable[1], row.unsolvable[1], row.solvable[2], row.unsolvable[2],
              row.disagreements, row.undecided, row.answers, row.verified, row.above_limit, row.contradictions);
  std::fflush(stdout);
}

}  // namespace
}  // namespace lcpbench

int main(int argc, char** argv) {
  if (argc < 4 || std::atoi(argv[1]) < 1) {
    std::fprintf(stderr, "usage: certify_agreement TRIALS SEED SET...\n");
    return 2;
  }
  std::puts(
      "set,trials,certificate_solvable,certificate_unsolvable,lemke_solvable,lemke_unsolvable,lp_solvable,lp_"
      "unsolvable,"
      "disagreements,undecided,answers,verified,above_limit,contradictions");
  for (int i = 3; i < argc; ++i) {
    lcpbench::compare(argv[i], std::atoi(argv[1]), std::strtoull(argv[2], nullptr, 10));
  }
  return 0;
}
