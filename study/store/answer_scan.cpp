#include "study/store/answer_scan.h"

#include <fmt/format.h>

#include "core/error.h"
#include "study/store/schema.h"

namespace lcpbench {
namespace {

using sqlite::Statement;

/// Rows come in the order of the keys of problems and answers, without sorting: the condition on the set uses no index.
std::string scan_query() {
  return "SELECT p.id, p.set_id, p.seed, p.trial, p.kind, p.n, p.ngc, p.nc, p.free_bodies, p.hash, p.theory, "
         "k.certificate, k.least, k.margin, "
         "a.solver_id, a.part, a.group_id, a.claim, a.iterations, a.pivots, a.factorizations, a.detail, c.friction, "
         "v.farkas_checked, v.worst_row, v.usable, v.solved, v.criterion, " + metric_columns() + ", "
         "t.repeats, t.setup_wall_s, t.setup_cpu_s, t.solve_wall_s, t.solve_cpu_s, t.transport_s, t.verify_s "
         "FROM problems p LEFT JOIN (SELECT problem_id, certificate, least_violation_m_per_s AS least, "
         "proof_margin AS margin "
         "FROM certificates) k ON k.problem_id = p.id "
         "LEFT JOIN answers a ON a.problem_id = p.id "
         "LEFT JOIN parameterisations c ON c.solver_id = a.solver_id AND c.cell = a.part "
         "LEFT JOIN verdicts v ON (v.problem_id, v.solver_id, v.part) = (a.problem_id, a.solver_id, a.part) "
         "LEFT JOIN timings t ON (t.problem_id, t.solver_id, t.part) = (a.problem_id, a.solver_id, a.part) "
         "WHERE ?1 IS NULL OR p.set_id = ?1 ORDER BY p.id, a.solver_id, a.part";
}

// Places of columns in the query.
constexpr int kCertificate = 11;
constexpr int kAnswer = 14;
constexpr int kVerdict = 23;

}  // namespace

AnswerScan::AnswerScan(Store& store) : database_(store.database()), snapshot_(database_) {
  Statement groups(database_, "SELECT group_id, cell FROM cell_groups ORDER BY group_id, cell");
  while (groups.step()) {
    const auto [place, is_new] =
        group_places_.try_emplace(groups.integer(0), static_cast<std::uint32_t>(groups_.size()));
    if (is_new) groups_.emplace_back();
    groups_.back().push_back(static_cast<std::uint32_t>(groups.integer(1)));
  }
}

void AnswerScan::read(const std::optional<std::int64_t>& set_id,
                      const std::function<void(const AnsweredProblem&)>& visit) {
  Statement query(database_, scan_query());
  query.bind(1, set_id);
  ProblemRow row;
  for (bool more = query.step(); more;) {
    query.read(0, row.id, row.set_id, row.seed, row.trial, row.kind, row.n, row.ngc, row.nc, row.free_bodies, row.hash,
               row.theory);
    Findings findings;
    if (row.theory == to_string(Truth::kSolvable)) findings.add(Evidence::kTheory);
    if (query.text(kCertificate) == "solution") findings.add(Evidence::kCertifiedSolution);
    if (query.text(kCertificate) == "unsolvable") {
      findings.add_proof(Evidence::kCertifiedUnsolvable, query.real(kCertificate + 2));
    }
    const double least_violation = query.real(kCertificate + 1);
    std::size_t count = 0;
    for (; more && query.integer(0) == row.id; more = query.step()) {
      if (query.is_null(kAnswer)) continue;  // nobody answered
      if (count == buffer_.size()) buffer_.emplace_back();
      read_answer(query, row, buffer_[count++], findings);
    }
    const std::span answers(buffer_.data(), count);
    const Truth truth = findings.truth();
    for (StoredAnswer& answer : answers) {
      if (answer.truth != Truth::kUnknown) answer.truth = truth;
      answer.verdict = verdict(answer.claim, answer.errors, answer.truth);
    }
    visit({row, truth, least_violation, answers});
  }
}

/// Reads all but the verdict and the truth. The latter becomes kUnknown where the problem's truth does not bind the
/// answer, and else any other value, which read() replaces.
void AnswerScan::read_answer(const Statement& query, const ProblemRow& of, StoredAnswer& answer, Findings& findings) {
  answer.problem_id = of.id;
  answer.set_id = of.set_id;
  answer.seed = of.seed;
  answer.trial = of.trial;
  answer.hash = of.hash;
  std::int64_t group = 0;
  std::string claim, friction;
  query.read(kAnswer, answer.solver_id, answer.part, group, claim, answer.counters.iterations, answer.counters.pivots,
             answer.counters.factorizations, answer.detail, friction);
  const auto place = group_places_.find(group);
  if (place == group_places_.end() || friction.empty() || query.is_null(kVerdict)) {
    throw InputError(fmt::format("{}: the store is damaged: table answers, row of problem {}: it belongs to no cells of "
                                 "its solver, or has no verdict",
                                 database_.file().string(), of.id));
  }
  answer.claim = stored_claim(database_, claim);
  answer.group = place->second;
  answer.cells = groups_[place->second];

  Errors& errors = answer.errors;
  bool proof_holds = false;
  const int worst_row = query.read(kVerdict, proof_holds);
  int column = query.read(worst_row, errors.worst.row, errors.usable, errors.solved, errors.criterion);
  errors.worst = {.row = query.is_null(worst_row) ? -1 : errors.worst.row};
  errors.unresolved = !query.is_null(worst_row) && errors.worst.row < 0;
  for (const Metric& metric : kMetrics) {
    if (metric.stored) errors.*metric.value = query.real(column++);
  }
  // An answer to the cone or the convex model proves nothing about the pyramid's problem, and nothing proves it wrong.
  const bool other_model = of.nc > 0 && of.n > of.nc && friction != to_string(FrictionModel::kPyramid);
  if (proof_holds) findings.add_proof(Evidence::kValidProof, errors.proof_margin);
  if (!other_model) findings.add({.errors = errors});
  answer.truth = other_model ? Truth::kUnknown : Truth::kSolvable;

  SolveTimes& times = answer.times;
  query.read(column, times.repeats, times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s, times.solve_cpu_s,
             times.transport_s, answer.verify_s);
}

}  // namespace lcpbench
