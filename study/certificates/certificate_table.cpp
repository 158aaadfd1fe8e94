#include "study/certificates/certificate_table.h"

#include <limits>

#include <fmt/format.h>

#include "core/error.h"
#include "study/certificates/proof_document.h"
#include "study/output/json_output.h"
#include "study/store/row_checksum.h"
#include "study/store/vector_codec.h"

namespace lcpbench {
namespace {

using sqlite::Statement;

constexpr int kContradictionsShown = 100;

/// Whether ?1, a JSON array of names, holds set s; an empty array holds every set.
constexpr const char* kInSets = "(json_array_length(?1) = 0 OR s.name IN (SELECT value FROM json_each(?1)))";
/// Whether problem p has contacts with friction rows. False for a bare LCP.
constexpr const char* kFrictional = "(p.kind <> 'lcp' AND p.n > p.nc)";
/// The solver, with its settings, whose answer a row v of `verdicts` is about.
constexpr const char* kAnswerInWords =
    "(SELECT name || CASE settings WHEN '' THEN '' ELSE '{' || settings || '}' END FROM solvers "
    "WHERE id = v.solver_id)";

/// Whether a row v of `verdicts` was measured by the friction pyramid: certificates hold for no other model.
constexpr const char* kOfPyramid =
    "'pyramid' = (SELECT j.model FROM judged j WHERE j.problem_id = v.problem_id AND j.solver_id = v.solver_id "
    "AND j.part = v.part)";

std::string sets_parameter(const CertifyScope& scope) { return nlohmann::json(scope.sets).dump(); }

/// @param column  of the certificate; that of its time limit follows
bool still_to_certify(const Statement& row, int column, const CertifyScope& scope) {
  if (row.is_null(column)) return true;
  return row.text(column) == "open" && row.real(column + 1) < scope.time_limit_s;
}

/// Adds a vector. @returns its id; none for one without entries
std::optional<std::int64_t> keep(Store& store, const Vector& vector) {
  if (vector.size() == 0) return std::nullopt;
  const std::string bytes = encode_vector(vector);
  const std::int64_t id = content_id(bytes);
  Statement(store.database(), "INSERT OR IGNORE INTO vectors (id, data) VALUES (?, ?)").run(id, sqlite::Blob{bytes});
  return id;
}

std::string forward_errors_missing(const char* problem) {
  return fmt::format(
      "EXISTS (SELECT 1 FROM verdicts v WHERE v.problem_id = {} AND v.usable = 1 AND v.forward_velocity IS NULL "
      "AND {})",
      problem, kOfPyramid);
}

}  // namespace

std::vector<CertifyTask> CertificateTable::pending(const CertifyScope& scope) {
  Statement query(store_.database(),
                  fmt::format("SELECT p.id, s.name, p.seed, p.trial, p.hash, c.certificate, t.time_limit_s, "
                              "IFNULL(c.velocity_unique, 0) = 1 AND {} FROM problems p JOIN sets s ON s.id = p.set_id "
                              "LEFT JOIN certificates c ON c.problem_id = p.id "
                              "LEFT JOIN certificate_timings t ON t.problem_id = p.id "
                              "WHERE {} AND (NOT {} OR p.trial % ?2 = 0) ORDER BY p.trial, s.name, p.seed",
                              forward_errors_missing("p.id"), kInSets, kFrictional));
  const std::string sets = sets_parameter(scope);
  query.bind_all(sets, scope.every);
  std::vector<CertifyTask> tasks;
  while (query.step()) {
    const bool certify = still_to_certify(query, 5, scope);
    if (!certify && query.integer(7) == 0) continue;
    tasks.push_back({query.integer(0), std::string(query.text(1)), static_cast<std::uint64_t>(query.integer(2)),
                     query.integer(3), std::string(query.text(4)), certify});
  }
  return tasks;
}

bool CertificateTable::has_proof(std::int64_t problem_id) {
  Statement query(store_.database(), "SELECT 1 FROM certificates WHERE problem_id = ? AND certificate <> 'open'");
  query.bind_all(problem_id);
  return query.step();
}

void CertificateTable::add(std::int64_t problem_id, const CertificateRow& row) {
  sqlite::Database& store = store_.database();
  const auto insert_or_replace = [](const char* table, const char* columns) {
    return sqlite::insert_row("INSERT OR REPLACE", table, columns);
  };
  Statement(store, insert_or_replace("certificates",
                                     "problem_id, certificate, proof, velocity, velocity_unique, "
                                     "least_violation_m_per_s, proof_margin, detail"))
      .run(problem_id, to_string(row.kind), to_string(row.proof), keep(store_, row.velocity), row.velocity_unique,
           row.least_violation_m_per_s, row.proof_margin, row.detail);
  Statement(store, insert_or_replace("certificate_timings", "problem_id, seconds, time_limit_s"))
      .run(problem_id, row.seconds, row.time_limit_s);
  if (row.document.empty()) return;
  Statement(store, insert_or_replace("proofs", "problem_id, document")).run(problem_id, sqlite::Blob{row.document});
}

void CertificateTable::add(std::int64_t problem_id, const std::vector<ForwardError>& errors) {
  if (errors.empty()) return;
  Statement update(store_.database(),
                   fmt::format("UPDATE verdicts SET forward_velocity = ?1, checksum = {} "
                               "WHERE problem_id = ?2 AND solver_id = ?3 AND part = ?4",
                               sqlite::row_checksum_of(store_.database(), "verdicts", "forward_velocity", "?1")));
  for (const ForwardError& error : errors) {
    update.run(error.forward_velocity, problem_id, error.solver_id, error.part);
  }
}

std::optional<Vector> CertificateTable::unique_velocity(std::int64_t problem_id) {
  Statement query(store_.database(),
                  "SELECT v.data FROM certificates c JOIN vectors v ON v.id = c.velocity "
                  "WHERE c.problem_id = ? AND c.velocity_unique = 1");
  query.bind_all(problem_id);
  if (!query.step()) return std::nullopt;
  return decode_vector(query.blob(0));
}

std::vector<ForwardError> CertificateTable::answers_without_forward_error(std::int64_t problem_id) {
  Statement query(store_.database(),
                  fmt::format("SELECT solver_id, part FROM verdicts v WHERE problem_id = ? AND usable = 1 "
                              "AND forward_velocity IS NULL AND {} ORDER BY solver_id, part",
                              kOfPyramid));
  query.bind_all(problem_id);
  std::vector<ForwardError> answers;
  while (query.step())
    answers.push_back({query.integer(0), query.integer(1), std::numeric_limits<double>::quiet_NaN()});
  return answers;
}

void CertificateTable::for_each_proof(const CertifyScope& scope,
                                      const std::function<void(std::string_view document)>& visit) {
  Statement query(store_.database(),
                  fmt::format("SELECT d.document FROM proofs d JOIN problems p ON p.id = d.problem_id "
                              "JOIN sets s ON s.id = p.set_id WHERE {} ORDER BY s.name, p.seed, p.trial",
                              kInSets));
  const std::string sets = sets_parameter(scope);
  query.bind_all(sets);
  while (query.step()) {
    std::string document;
    try {
      document = inflate(query.blob(0));
    } catch (const InputError& error) {
      throw InputError(fmt::format("{}: {}", store_.file().string(), error.what()));
    }
    visit(document);
  }
}

std::vector<CertifiedSet> CertificateTable::counts(const CertifyScope& scope) {
  Statement query(
      store_.database(),
      fmt::format("SELECT s.name, MAX({}), COUNT(*), IFNULL(SUM(c.certificate = 'solution'), 0), "
                  "IFNULL(SUM(c.certificate = 'unsolvable'), 0), IFNULL(SUM(c.certificate = 'open'), 0), "
                  "AVG(t.seconds), MAX(t.seconds), IFNULL(SUM(c.velocity_unique = 0), 0), "
                  "IFNULL(SUM(CASE WHEN c.problem_id IS NOT NULL THEN a.answers END), 0), "
                  "IFNULL(SUM(CASE WHEN c.problem_id IS NOT NULL THEN a.verified END), 0), "
                  "IFNULL(SUM(CASE WHEN c.problem_id IS NOT NULL THEN a.forward END), 0) "
                  "FROM problems p JOIN sets s ON s.id = p.set_id LEFT JOIN certificates c ON c.problem_id = p.id "
                  "LEFT JOIN certificate_timings t ON t.problem_id = p.id "
                  "LEFT JOIN (SELECT problem_id, COUNT(*) AS answers, SUM(solved) AS verified, "
                  "COUNT(forward_velocity) AS forward FROM verdicts GROUP BY problem_id) a ON a.problem_id = p.id "
                  "WHERE {} GROUP BY s.name ORDER BY s.name",
                  kFrictional, kInSets));
  const std::string sets = sets_parameter(scope);
  query.bind_all(sets);
  std::vector<CertifiedSet> counts;
  while (query.step()) {
    CertifiedSet set;
    query.read(0, set.set, set.frictional, set.problems, set.solution, set.unsolvable, set.open, set.seconds_mean,
               set.seconds_max, set.other_velocity, set.answers, set.verified, set.forward);
    counts.push_back(std::move(set));
  }
  return counts;
}

std::vector<std::string> CertificateTable::contradictions(const CertifyScope& scope) {
  // The exact residual is at least the violation of the contacts, and that is at least the certified bound. The stored
  // residual may be off by 2^-30 of itself, which the factor 1.000001 allows for. An answer to an unsolvable problem
  // may pass the evaluation, which has a tolerance: that contradicts no proof.
  Statement query(
      store_.database(),
      fmt::format(
          "SELECT s.name, p.seed, p.trial, {0} || ' has an answer that is better than the proof of unsolvability "
          "allows' FROM certificates c JOIN problems p ON p.id = c.problem_id JOIN sets s ON s.id = p.set_id "
          "JOIN verdicts v ON v.problem_id = c.problem_id WHERE {1} AND c.certificate = 'unsolvable' AND {3} "
          "AND v.velocity_residual_m_per_s * 1.000001 < c.least_violation_m_per_s "
          "UNION ALL SELECT s.name, p.seed, p.trial, {0} || ' has a proof of unsolvability, yet a solution is "
          "certified' FROM certificates c JOIN problems p ON p.id = c.problem_id JOIN sets s ON s.id = p.set_id "
          "JOIN verdicts v ON v.problem_id = c.problem_id WHERE {1} AND c.certificate = 'solution' "
          "AND v.farkas_checked = 1 "
          "UNION ALL SELECT s.name, p.seed, p.trial, 'theory says solvable, the certificate unsolvable' "
          "FROM certificates c JOIN problems p ON p.id = c.problem_id JOIN sets s ON s.id = p.set_id "
          "WHERE {1} AND c.certificate = 'unsolvable' AND p.theory = 'solvable' LIMIT {2}",
          kAnswerInWords, kInSets, kContradictionsShown, kOfPyramid));
  const std::string sets = sets_parameter(scope);
  query.bind_all(sets);
  std::vector<std::string> lines;
  while (query.step()) {
    lines.push_back(fmt::format("{} seed {} trial {}: {}", query.text(0), static_cast<std::uint64_t>(query.integer(1)),
                                query.integer(2), query.text(3)));
  }
  return lines;
}

}  // namespace lcpbench
