#include "study/certificates/certify_store.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmpxx.h>

#include "core/answer/lcp_error.h"
#include "core/entries.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/parallel_work.h"
#include "core/quad.h"
#include "generators/sets.h"
#include "study/certificates/proof_document.h"

namespace lcpbench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Sets = std::map<std::string, std::unique_ptr<const ProblemSet>>;

struct Result {
  std::int64_t problem_id = 0;
  std::optional<CertificateRow> certificate;
  std::vector<ForwardError> forward;
};

/// What one thread works with. It reads the store through a connection of its own.
class Worker {
 public:
  Worker(const CertifyRun& run, const std::filesystem::path& store, const Sets& sets)
      : run_(run), sets_(sets), store_(Store::open_for_reading(store)), table_(store_), certify_(run.open()) {}

  Result work(const CertifyTask& task) {
    const Problem problem = sets_.at(task.set)->generate(task.seed, task.trial);
    if (problem_hash(problem) != task.hash) {
      throw InputError(
          fmt::format("{}: trial {} of seed {} of set '{}' is another problem than the one that was "
                      "solved: the set has changed, and its answers cannot be certified",
                      store_.file().string(), task.trial, task.seed, task.set));
    }
    Result result;
    result.problem_id = task.problem_id;
    std::optional<Vector> v_star;
    if (task.certify) {
      const Certificate certificate = certify_or_open(problem);
      result.certificate = certificate_row(problem, certificate, run_.scope.time_limit_s);
      if (result.certificate->velocity_unique.value_or(false)) v_star = result.certificate->velocity;
    } else {
      v_star = table_.unique_velocity(task.problem_id);
    }
    if (v_star && v_star->size() > 0) result.forward = forward_errors(problem, task.problem_id, *v_star);
    return result;
  }

 private:
  /// An exception leaves the problem open, with its message as the reason.
  Certificate certify_or_open(const Problem& problem) {
    try {
      return certify_(problem);
    } catch (const std::exception& error) {
      Certificate open;
      open.detail = error.what();
      return open;
    }
  }

  std::vector<ForwardError> forward_errors(const Problem& problem, std::int64_t problem_id, const Vector& v_star) {
    std::vector<ForwardError> errors = table_.answers_without_forward_error(problem_id);
    if (errors.empty()) return errors;
    Evaluator evaluator(problem);
    evaluator.set_certified_velocity(v_star);
    known_.clear();
    for (ForwardError& error : errors) {
      const auto part = static_cast<std::uint32_t>(error.part);
      const std::optional<Answer> answer = store_.answer(problem_id, error.solver_id, part);
      if (!answer) continue;
      const auto equal = [&](const auto& k) { return k.first.size() == answer->z.size() && k.first == answer->z; };
      const auto known = std::find_if(known_.begin(), known_.end(), equal);
      error.forward_velocity = known != known_.end() ? known->second : evaluator.forward_velocity(*answer);
      if (known == known_.end()) known_.emplace_back(answer->z, error.forward_velocity);
    }
    return errors;
  }

  const CertifyRun& run_;
  const Sets& sets_;
  Store store_;
  CertificateTable table_;
  CertifyProblem certify_;
  std::vector<std::pair<Vector, double>> known_;  // distinct z of the present problem, with their errors
};

Sets open_sets(const std::vector<CertifyTask>& tasks) {
  Sets sets;
  for (const CertifyTask& task : tasks) {
    std::unique_ptr<const ProblemSet>& set = sets[task.set];
    if (set == nullptr) set = open_set(task.set);
  }
  return sets;
}

}  // namespace

double least_violation(const Problem& problem, const Certificate& certificate) {
  const ContactProblem* contact = problem.contact();
  if (certificate.proof != ProofKind::kFarkas || contact == nullptr) return kNone;
  // Of the normals, then of bounded rows; where there are none, of friction.
  const std::vector<std::string>& numerators = certificate.exact_farkas.numerators;
  const Index nc = contact->nc(), weights = nc + contact->rows.size();
  if (std::ssize(numerators) < weights) return kNone;
  mpq_class missing, total;
  const auto add = [&](const Jacobian& J, Index column, double offset, Index weight) {
    const mpq_class u(mpz_class(numerators[static_cast<std::size_t>(weight)]));
    mpq_class q(offset);
    for_each_entry(J, column, [&](Index i, double entry) { q += mpq_class(entry) * mpq_class(contact->v(i)); });
    missing -= u * q;
    total += abs(u);
  };
  for (Index c = 0; c < nc; ++c) add(contact->N, c, contact->offset(c), c);
  for (Index row = 0; nc + row < weights; ++row) add(contact->rows.R, row, contact->rows.offset(row), nc + row);
  if (sgn(total) <= 0) return kNone;
  const double bound = mpq_class(missing / total).get_d();  // rounded towards zero
  return std::min(bound, std::numeric_limits<double>::max());
}

double proof_margin(const Problem& problem, const Certificate& certificate) {
  const bool is_bare = problem.contact() == nullptr && !problem.lcp().is_mixed();
  const std::vector<std::string>& numerators = certificate.exact_farkas.numerators;
  if (certificate.proof != ProofKind::kFarkas || !is_bare || std::ssize(numerators) != problem.size()) return kNone;
  const Lcp& lcp = problem.lcp();
  const std::vector<Quad> floors = lcp_floors(lcp, row_islands(lcp.M), lcp_norms<Quad>(lcp));
  mpq_class missing, total;
  for (Index i = 0; i < problem.size(); ++i) {
    const mpq_class u(mpz_class(numerators[static_cast<std::size_t>(i)]));
    missing -= u * mpq_class(lcp.q(i));
    total += u * mpq_class(std::max(std::abs(lcp.q(i)), to_double(floors[static_cast<std::size_t>(i)])));
  }
  return sgn(total) > 0 ? mpq_class(missing / total).get_d() : kNone;
}

CertificateRow certificate_row(const Problem& problem, const Certificate& certificate, double time_limit_s) {
  CertificateRow row;
  row.seconds = certificate.seconds;
  row.time_limit_s = time_limit_s;
  row.least_violation_m_per_s = row.proof_margin = kNone;
  try {
    if (certificate.kind != CertificateKind::kOpen) row.document = deflate(proof_document(problem, certificate));
  } catch (const InputError& refusal) {
    row.detail = fmt::format("not within what a problem file may hold: {}", refusal.what());
    return row;
  }
  row.kind = certificate.kind;
  row.proof = certificate.proof;
  row.velocity = certificate.velocity;
  row.velocity_unique = certificate.velocity_unique;
  row.least_violation_m_per_s = least_violation(problem, certificate);
  row.proof_margin = proof_margin(problem, certificate);
  row.detail = certificate.detail;
  return row;
}

CertifyOutcome certify_store(Store& store, const CertifyRun& run) {
  const std::vector<CertifyTask> tasks = CertificateTable(store).pending(run.scope);
  const Sets sets = open_sets(tasks);
  CertifyOutcome outcome;
  outcome.total = static_cast<std::int64_t>(tasks.size());

  const int jobs = static_cast<int>(std::min(static_cast<std::size_t>(run.jobs), tasks.size()));
  ParallelWork<Result, Store> work(store);
  std::atomic<std::size_t> next{0};
  for (int i = 0; i < jobs; ++i) {
    work.start([&] {
      Worker worker(run, store.file(), sets);
      while (!work.stopped()) {
        const std::size_t task = next.fetch_add(1);
        if (task >= tasks.size()) break;
        work.push(worker.work(tasks[task]));
      }
    });
  }
  CertificateTable table(store);
  const auto write = [&](const Result& result) {
    if (result.certificate) table.add(result.problem_id, *result.certificate);
    table.add(result.problem_id, result.forward);
    ++outcome.done;
  };
  const auto tell = [&] {
    if (run.on_progress) run.on_progress(outcome.done, outcome.total);
  };
  work.run(run.stop, write, tell);
  if (const std::exception_ptr error = work.error()) std::rethrow_exception(error);
  return outcome;
}

}  // namespace lcpbench
