#include "study/store/answer_scan.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <fmt/format.h>

#include "core/error.h"
#include "study/store/row_checksum.h"
#include "study/store/totals.h"

namespace lcpbench {

using sqlite::read_columns;
using sqlite::Statement;

/// A walk through rows of a table, with their number and the sum of their checksums so far.
struct AnswerScan::Table {
  /// @param of    the table's name; its first column is the id of the problem
  /// @param from  what follows FROM in its query, {} for the table: rows in order of a key, all or those of ?1
  Table(sqlite::Database& store, const char* of, const std::string& from)
      : database(store), name(of), rows(store, sqlite::copying_query(store, of, fmt::format(fmt::runtime(from), of))) {
    sqlite::bind_copy(rows, row);
  }

  /// The next step() reads the first row for ?1 = `parameter`.
  void restart(std::int64_t parameter) {
    rows.reset();
    rows.bind(1, parameter);
  }
  /// Reads the next row. @returns whether there is one. @throws InputError if it is not what was written
  bool step() {
    there = rows.step();
    if (!there) return false;
    if (rows.integer(0) != row.integer(0)) throw std::logic_error("AnswerScan: the query sorts");
    if (!row.is_as_written()) fail("not what was written");
    total.add(row.checksum());
    return true;
  }
  /// Reports the current row as damaged. @pre there is one
  /// @throws InputError always: one line with the file, the table, the row's problem and the cause
  [[noreturn]] void fail(const std::string& cause) const {
    throw InputError(fmt::format("{}: the store is damaged: table {}, row of problem {}: {}", database.file().string(),
                                 name, row.integer(0), cause));
  }
  bool is_of(const StoredAnswer& answer) const {
    return there && row.integer(0) == answer.problem_id && row.integer(1) == answer.solver_id &&
           row.integer(2) == answer.part;
  }

  sqlite::Database& database;
  const char* name;
  Statement rows;
  sqlite::RowCopy row;  ///< the current one
  bool there = false;   ///< whether there is a current row
  Total total;          ///< of the rows read
};

AnswerScan::AnswerScan(Store& store)
    : database_(store.database()), snapshot_(database_) {
  for (const auto& [id, name] : store.sets()) sets_[id] = name;
  for (const StoredSolver& solver : store.solvers()) {
    for (const SolverRow& cell : solver.cells) friction_[solver.id].push_back(cell.friction);
  }
  Statement certificates(database_,
                         "SELECT problem_id, certificate = 'solution', least_violation_m_per_s FROM certificates "
                         "WHERE certificate <> 'open'");
  while (certificates.step()) {
    const bool is_solution = certificates.integer(1) != 0;
    certificates_[certificates.integer(0)] = {
        is_solution ? Evidence::kCertifiedSolution : Evidence::kCertifiedUnsolvable, certificates.real(2)};
  }
  Statement groups(database_, "SELECT group_id, cell FROM cell_groups ORDER BY group_id, cell");
  while (groups.step()) {
    const auto [place, is_new] =
        group_places_.try_emplace(groups.integer(0), static_cast<std::uint32_t>(groups_.size()));
    if (is_new) groups_.emplace_back();
    groups_.back().push_back(static_cast<std::uint32_t>(groups.integer(1)));
  }
}

AnswerScan::~AnswerScan() = default;

void AnswerScan::read(const std::optional<std::int64_t>& set_id,
                      const std::function<void(const AnsweredProblem&)>& visit) {
  const auto open = [&](const char* name, const char* of_set, const char* all) {
    return std::make_unique<Table>(database_, name, set_id ? of_set : all);
  };
  constexpr const char* kOfProblem = "{} WHERE problem_id = ?1 ORDER BY solver_id, part";
  // Materialized: a query that sorts may call copy_row() on all rows before its first step returns.
  constexpr const char* kOfSet =
      "(WITH own AS MATERIALIZED (SELECT * FROM {} WHERE set_id = ?1 ORDER BY id LIMIT -1) SELECT * FROM own)";
  constexpr const char* kAll = "{} ORDER BY problem_id, solver_id, part";
  const auto problems = open("problems", kOfSet, "{} ORDER BY id");
  answers_ = open("answers", kOfProblem, kAll);
  verdicts_ = open("verdicts", kOfProblem, kAll);
  timings_ = open("timings", kOfProblem, kAll);
  const std::array rest{answers_.get(), verdicts_.get(), timings_.get()};
  if (set_id) problems->restart(*set_id);
  if (!set_id) std::for_each(rest.begin(), rest.end(), [](Table* table) { table->step(); });
  ProblemRow row;
  while (problems->step()) {
    read_columns(problems->row, 0, row.id, row.set_id, row.seed, row.trial, row.kind, row.n, row.ngc, row.nc,
                 row.free_bodies, row.hash, row.theory);
    const auto set = sets_.find(row.set_id);
    if (set == sets_.end() || problem_id(set->second, row.seed, row.trial) != row.id) {
      problems->fail("its id is not that of its set, seed and trial");
    }
    for (Table* table : rest) {
      if (!set_id) break;
      table->restart(row.id);
      table->step();
    }
    visit(read_problem(row));
    for (const Table* table : rest) {
      if (table->there && table->row.integer(0) <= row.id) table->fail("it belongs to no answer to a problem");
    }
  }
  if (set_id) return;
  check_total(database_, problems->name, problems->total);
  for (const Table* table : rest) check_total(database_, table->name, table->total);
}

AnsweredProblem AnswerScan::read_problem(const ProblemRow& of) {
  Findings findings;
  if (of.theory == to_string(Truth::kSolvable)) findings.add(Evidence::kTheory);
  double least_violation = Errors::kNone;
  if (const auto found = certificates_.find(of.id); found != certificates_.end()) {
    findings.add(found->second.evidence);
    least_violation = found->second.least_violation_m_per_s;
  }
  std::size_t count = 0;
  for (; answers_->there && answers_->row.integer(0) == of.id; answers_->step()) {
    if (count == buffer_.size()) buffer_.emplace_back();
    read_answer(of, buffer_[count++], findings);
  }
  const std::span answers(buffer_.data(), count);
  const Truth truth = findings.truth();
  for (StoredAnswer& answer : answers) {
    if (answer.truth != Truth::kUnknown) answer.truth = truth;
    answer.verdict = verdict(answer.claim, answer.errors, answer.truth);
  }
  return {of, truth, least_violation, answers};
}

/// Reads all but the verdict and the truth. The latter becomes kUnknown where the problem's truth does not bind the
/// answer, and else any other value, which read_problem() replaces.
void AnswerScan::read_answer(const ProblemRow& of, StoredAnswer& answer, Findings& findings) {
  std::int64_t group = 0;
  read_columns(answers_->row, 0, answer.problem_id, answer.solver_id, answer.part, group);
  read_columns(answers_->row, 8, answer.counters.iterations, answer.counters.pivots, answer.counters.factorizations,
               answer.detail);
  answer.claim = stored_claim(database_, answers_->row.text(4));
  answer.set_id = of.set_id;
  answer.seed = of.seed;
  answer.trial = of.trial;
  answer.hash = of.hash;
  const auto friction = friction_.find(answer.solver_id);
  const auto place = group_places_.find(group);
  answer.group = place == group_places_.end() ? 0 : place->second;
  answer.cells = place == group_places_.end() ? std::span<const std::uint32_t>() : groups_[place->second];
  if (friction == friction_.end() || answer.cells.empty() || answer.cells.back() >= friction->second.size() ||
      answer.cells.front() != answer.part) {
    answers_->fail("it belongs to no cells of its solver");
  }

  const sqlite::RowCopy& judged = verdicts_->row;
  if (!verdicts_->is_of(answer)) answers_->fail("no row of table verdicts is its own");
  Errors& errors = answer.errors;
  bool proof_holds = false;
  read_columns(judged, 3, errors.usable, errors.solved, errors.criterion, proof_holds);
  errors.worst = {.row = judged.is_null(7) ? -1 : judged.integer(7)};
  errors.unresolved = !judged.is_null(7) && errors.worst.row < 0;
  int column = 8;
  for (const Metric& metric : kMetrics) {
    if (metric.stored) errors.*metric.value = judged.real(column++);
  }
  // An answer to the cone or the convex model proves nothing about the pyramid's problem, and nothing proves it wrong.
  const bool other_model = of.nc > 0 && of.n > of.nc &&
                           friction->second[static_cast<std::size_t>(answer.part)] != FrictionModel::kPyramid;
  if (proof_holds) findings.add(Evidence::kValidProof);
  if (!other_model) findings.add({.errors = errors});
  answer.truth = other_model ? Truth::kUnknown : Truth::kSolvable;
  verdicts_->step();

  SolveTimes& times = answer.times = {Errors::kNone, Errors::kNone, Errors::kNone, Errors::kNone, Errors::kNone, 0};
  answer.verify_s = Errors::kNone;
  if (!timings_->is_of(answer)) return;
  read_columns(timings_->row, 4, times.setup_wall_s, times.setup_cpu_s, times.solve_wall_s, times.solve_cpu_s,
               times.transport_s, answer.verify_s, times.repeats);
  timings_->step();
}

}  // namespace lcpbench
