// Writes the shards of a large study without solving anything: what merge, report and the checks cost at scale.
//
//   large_store FOLDER SHARDS PROBLEMS SOLVERS
//
// FOLDER gets 1.db, 2.db, ...: together they hold SOLVERS answers to each of PROBLEMS problems of two sets. Problems
// are real ones; answers are random vectors of their length, with a verdict and a time.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "core/io/problem_io.h"
#include "generators/sets.h"
#include "study/store/store.h"
#include "study/store/vector_codec.h"

namespace lcpbench {
namespace {

using Random = std::mt19937_64;
using Sets = std::vector<std::unique_ptr<ProblemSet>>;

std::int64_t keep_random_vector(Index size, Random& random, ProblemResult& result) {
  Vector vector(size);
  for (double& entry : vector) entry = static_cast<double>(random() >> 11);
  std::string bytes = encode_vector(vector);
  const std::int64_t id = content_id(bytes);
  result.vectors.emplace_back(id, std::move(bytes));
  return id;
}

AnswerRow random_answer(std::int64_t solver, const Problem& problem, Random& random, ProblemResult& result) {
  AnswerRow answer;
  answer.solver_id = solver;
  answer.claim = Claim::kSolved;
  answer.z = keep_random_vector(problem.size(), random, result);
  answer.velocity = keep_random_vector(problem.contact()->ngc(), random, result);
  const bool solved = random() % 10 != 0;
  answer.errors.usable = true;
  answer.errors.solved = answer.errors.criterion = solved;
  answer.errors.velocity_residual_relative = solved ? 1e-12 : 0.5;
  answer.errors.velocity_residual_m_per_s = answer.errors.violation_m_per_s = solved ? 1e-11 : 1.0;
  answer.times.setup_wall_s = answer.times.setup_cpu_s = 1e-6;
  answer.times.solve_wall_s = answer.times.solve_cpu_s = 1e-5 + 1e-20 * static_cast<double>(random() >> 11);
  answer.times.repeats = 1;
  return answer;
}

ProblemResult random_result(const ProblemSet& set, std::int64_t trial, const std::vector<std::int64_t>& solvers,
                            Random& random) {
  constexpr std::uint64_t kSeed = 1;
  const Problem problem = set.generate(kSeed, trial);
  const ContactProblem& contact = *problem.contact();
  ProblemResult result;
  result.problem = {problem_id(set.name(), kSeed, trial), set_id(set.name()), kSeed, trial, to_string(problem.kind()),
                    problem.size(), contact.ngc(), contact.nc(), false, problem_hash(problem), "solvable"};
  for (const std::int64_t solver : solvers) {
    result.answers.push_back(random_answer(solver, problem, random, result));
  }
  return result;
}

void write_shard(const std::filesystem::path& file, const Sets& sets, std::int64_t shard, std::int64_t shards,
                 std::int64_t problems, int solvers) {
  constexpr int kProblemsInATransaction = 500;
  Random random(static_cast<std::uint64_t>(shard));
  Store store = Store::open_for_writing(file);
  store.begin();
  store.add_run("2026-01-31T12:00:00Z",
                R"({"processor":"none","command":"large_store )" + std::to_string(shard) + "\"}");
  for (const auto& set : sets) store.add_set(set->name());
  std::vector<std::int64_t> ids;
  for (int i = 0; i < solvers; ++i) {
    const std::string cap = "cap=" + std::to_string(i + 3) + "n";
    ids.push_back(store.add_solver({"lemke", cap, "all", "native", "1", "baseline", ""}));
  }
  const auto count = static_cast<std::int64_t>(sets.size());
  int uncommitted = 0;
  for (std::int64_t problem = shard; problem < problems; problem += shards) {
    const ProblemSet& set = *sets[static_cast<std::size_t>(problem % count)];
    store.add(random_result(set, problem / count, ids, random));
    if (++uncommitted % kProblemsInATransaction != 0) continue;
    store.commit();
    store.begin();
  }
  store.commit();
}

}  // namespace
}  // namespace lcpbench

int main(int count, char** arguments) {
  if (count != 5) {
    std::fputs("usage: large_store FOLDER SHARDS PROBLEMS SOLVERS\n", stderr);
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  const std::int64_t shards = std::stoll(arguments[2]);
  std::filesystem::create_directories(folder);
  lcpbench::Sets sets;
  for (const char* name : {"paper/monotone/exp1", "paper/copositive/exp1"}) sets.push_back(lcpbench::open_set(name));
  for (std::int64_t shard = 0; shard < shards; ++shard) {
    lcpbench::write_shard(folder / (std::to_string(shard + 1) + ".db"), sets, shard, shards, std::stoll(arguments[3]),
                          std::stoi(arguments[4]));
  }
}
