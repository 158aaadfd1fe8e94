// What a user relies on: a certificate reaches the verdicts, the merged store and the checker as it was proven, and
// what was certified stays certified, whatever ends the program.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <new>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "core/error.h"
#include "core/io/problem_io.h"
#include "study/certificates/certify_store.h"
#include "study/certificates/proof_document.h"
#include "study/store/merge.h"
#include "study/run/runner.h"
#include "tests/support/study_support.h"

namespace lcpbench::certificates_test {
namespace {

using nlohmann::ordered_json;

constexpr const char* kMonotone = "paper/monotone/exp1";
constexpr const char* kFrictional = "paper/copositive/exp1{nc_max=3}";

// ------------------------------------------------------------------------------------ stores and made certificates

Study study_of(const std::vector<std::pair<std::string, std::int64_t>>& sets,
               const std::vector<std::string>& solvers = {"lemke"}) {
  Plan plan;
  plan.name = "small";
  plan.repeat_until_s = 0;
  for (const auto& [set, trials] : sets) plan.sets.push_back({.pattern = set, .trials = trials});
  for (const std::string& solver : solvers) plan.solvers.push_back({.spec = parse_spec(solver)});
  return resolve(plan);
}

void solve_all(const Study& study, const std::filesystem::path& file, const RunOptions& options = {}) {
  Store store = Store::open_for_writing(file);
  store.add_run("2026-01-01T00:00:00Z", "{}");
  run_study(study, store, options);
}

/// A certificate that anybody could make: the tests here are about what becomes of it.
Certificate made(CertificateKind kind, const Problem& problem) {
  Certificate certificate;
  certificate.kind = kind;
  if (kind == CertificateKind::kOpen) {
    certificate.detail = "nothing was tried";
    return certificate;
  }
  certificate.proof = kind == CertificateKind::kSolution ? ProofKind::kExactBasis : ProofKind::kFarkas;
  if (kind == CertificateKind::kSolution) {
    certificate.velocity = problem.contact()->v;
    certificate.velocity_unique = !problem.contact()->frictional();
  }
  return certificate;
}

/// Certifies alike all that is asked of it, and counts.
struct Maker {
  CertificateKind kind = CertificateKind::kSolution;
  std::atomic<int> calls{0};

  CertifyRun run(int jobs = 1, const CertifyScope& scope = {}) {
    CertifyRun result;
    result.scope = scope;
    result.jobs = jobs;
    result.open = [this] {
      return [this](const Problem& problem) {
        ++calls;
        return made(kind, problem);
      };
    };
    return result;
  }
};

CertifyOutcome certify(const std::filesystem::path& file, const CertifyRun& run) {
  Store store = Store::open_for_writing(file);
  return certify_store(store, run);
}

CertifyOutcome certify_as(CertificateKind kind, const std::filesystem::path& file, const CertifyScope& scope = {}) {
  Maker maker;
  maker.kind = kind;
  return certify(file, maker.run(1, scope));
}

std::int64_t count(const std::filesystem::path& file, const std::string& from) {
  return sqlite::Database(file, sqlite::Mode::kReadOnly).integer("SELECT COUNT(*) FROM " + from);
}

void change(const std::filesystem::path& file, const std::string& sql) { change_rows(file, sql); }

/// All that a store says but for times.
std::string facts(const std::filesystem::path& file) {
  Store store = Store::open_for_reading(file);
  return dump(file) + dump_table(store, "proofs");
}

std::string input_error(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

class CertifyStoreTest : public ::testing::Test {
 protected:
  ScratchFolder folder_;
  std::filesystem::path file_ = folder_ / "s.db";
};

TEST_F(CertifyStoreTest, EveryProblemIsCertifiedOnceAndNoThreadChangesARow) {
  solve_all(study_of({{kMonotone, 12}, {kFrictional, 4}}), file_);
  std::filesystem::copy_file(file_, folder_ / "three.db");
  Maker maker;
  EXPECT_EQ(certify(file_, maker.run()).done, 16);
  EXPECT_EQ(maker.calls, 16);
  EXPECT_EQ(certify(file_, maker.run()).total, 0);
  EXPECT_EQ(maker.calls, 16);
  certify(folder_ / "three.db", maker.run(3));
  EXPECT_EQ(facts(folder_ / "three.db"), facts(file_));
  EXPECT_EQ(count(file_, "proofs"), 16);
}

TEST_F(CertifyStoreTest, StoppedAndResumedEqualsUnbroken) {
  solve_all(study_of({{kMonotone, 12}}), file_);
  std::filesystem::copy_file(file_, folder_ / "whole.db");
  Maker maker;
  certify(folder_ / "whole.db", maker.run());
  volatile std::sig_atomic_t stop = 0;
  CertifyRun run = maker.run();
  run.open = [&] {
    return [&, calls = 0](const Problem& problem) mutable {
      if (++calls > 6) {
        while (stop == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the writer looks at `stop` every 100 ms
      }
      return made(CertificateKind::kSolution, problem);
    };
  };
  run.stop = &stop;
  run.on_progress = [&](std::int64_t done, std::int64_t) { stop = done >= 5 ? 1 : 0; };
  certify(file_, run);
  const std::int64_t kept = count(file_, "certificates");
  EXPECT_GE(kept, 5);
  EXPECT_LT(kept, 12);
  run.stop = nullptr;
  EXPECT_EQ(certify(file_, run).done, 12 - kept);
  EXPECT_EQ(facts(file_), facts(folder_ / "whole.db"));
}

TEST_F(CertifyStoreTest, KilledItLosesOnlyWhatIsInFlight) {
  solve_all(study_of({{kMonotone, 6}}), file_);
  const pid_t child = fork();
  if (child == 0) {
    Maker maker;
    CertifyRun run = maker.run();
    run.open = [&] {
      return [&](const Problem& problem) {
        while (++maker.calls > 4) std::this_thread::sleep_for(std::chrono::hours(1));
        return made(CertificateKind::kSolution, problem);
      };
    };
    certify(file_, run);
    _exit(0);
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (count(file_, "certificates") < 4 && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_EQ(count(file_, "certificates"), 4);
  Maker maker;
  EXPECT_EQ(certify(file_, maker.run()).done, 2);
  EXPECT_EQ(maker.calls, 2);
  EXPECT_EQ(count(file_, "certificates"), 6);
}

TEST_F(CertifyStoreTest, AProblemThatCannotBeCertifiedStaysOpenAndTheOthersGoOn) {
  solve_all(study_of({{kMonotone, 6}}), file_);
  Maker maker;
  CertifyRun run = maker.run();
  run.open = [] {
    return [number = 0](const Problem& problem) mutable {
      if (++number == 2) throw InputError("no numbers");
      if (number == 3) throw std::bad_alloc();
      return made(CertificateKind::kSolution, problem);
    };
  };
  const CertifyOutcome outcome = certify(file_, run);
  EXPECT_EQ(outcome.done, outcome.total);
  EXPECT_EQ(count(file_, "certificates WHERE certificate = 'open'"), 2);
  EXPECT_EQ(count(file_, "certificates WHERE detail = 'no numbers'"), 1);
}

TEST_F(CertifyStoreTest, OfFrictionalProblemsAStatedSampleIsCertified) {
  solve_all(study_of({{kMonotone, 5}, {kFrictional, 7}}), file_);
  Maker maker;
  EXPECT_EQ(certify(file_, maker.run(1, {.every = 3})).done, 5 + 3);
  EXPECT_EQ(count(file_, "certificates JOIN problems p ON p.id = problem_id WHERE p.n > p.nc AND p.trial % 3 = 0"), 3);
  EXPECT_EQ(certify(file_, maker.run(1, {.sets = {kFrictional}})).done, 4);
}

TEST_F(CertifyStoreTest, WhatAShortTimeLimitLeftOpenIsTriedAgainWithALongerOne) {
  solve_all(study_of({{kMonotone, 3}}), file_);
  certify_as(CertificateKind::kOpen, file_, {.time_limit_s = 1});
  EXPECT_EQ(count(file_, "proofs"), 0);
  EXPECT_EQ(certify_as(CertificateKind::kSolution, file_, {.time_limit_s = 1}).total, 0);
  EXPECT_EQ(certify_as(CertificateKind::kSolution, file_, {.time_limit_s = 2}).total, 3);
  EXPECT_EQ(count(file_, "certificates WHERE certificate = 'solution'"), 3);
  EXPECT_EQ(certify_as(CertificateKind::kSolution, file_, {.time_limit_s = 9}).total, 0);
}

TEST_F(CertifyStoreTest, ProofOfUnsolvabilityChangesTheTruthAndAnOpenCertificateNothing) {
  solve_all(study_of({{kMonotone, 4}}), file_);
  const std::string verdicts = "judged WHERE verdict = ";
  ASSERT_EQ(count(file_, verdicts + "'solved'"), 4);
  certify_as(CertificateKind::kOpen, file_);
  EXPECT_EQ(count(file_, verdicts + "'solved'"), 4);
  change(file_, "DELETE FROM certificates; DELETE FROM certificate_timings; DELETE FROM proofs");
  certify_as(CertificateKind::kUnsolvable, file_);
  EXPECT_EQ(count(file_, verdicts + "'solved' AND truth = 'nearly'"), 4);
}

// Earlier versions proved by branching: what they certified stays certified.
TEST_F(CertifyStoreTest, AStoreWithProofsByBranchingOpensAndKeepsThem) {
  solve_all(study_of({{kMonotone, 3}}), file_);
  certify_as(CertificateKind::kUnsolvable, file_);
  change(file_, "UPDATE certificates SET proof = 'branching'");
  EXPECT_EQ(certify_as(CertificateKind::kSolution, file_).total, 0);
  Store store = Store::open_for_reading(file_);
  EXPECT_EQ(CertificateTable(store).counts({}).at(0).unsolvable, 3);
  EXPECT_EQ(count(file_, "certificates WHERE proof = 'branching'"), 3);
}

TEST_F(CertifyStoreTest, CertifiedSolutionMakesAnHonestFailureAMiss) {
  solve_all(study_of({{kMonotone, 1}}), file_);
  change(file_,
         "UPDATE verdicts SET solved = 0, criterion = 0; UPDATE answers SET claim = 'iteration_limit'; "
         "UPDATE problems SET theory = ''");
  EXPECT_EQ(count(file_, "judged WHERE verdict = 'open'"), 1);
  certify_as(CertificateKind::kSolution, file_);
  EXPECT_EQ(count(file_, "judged WHERE verdict = 'missed'"), 1);
}

TEST_F(CertifyStoreTest, ForwardErrorsOfStoredAnswersFollowTheCertifiedVelocity) {
  solve_all(study_of({{kMonotone, 3}, {kFrictional, 2}}), file_);
  certify_as(CertificateKind::kSolution, file_);
  // The made v* is the velocity before the impact: nothing has moved, so that its error is what the answer moved.
  const std::string answers = "verdicts v JOIN problems p ON p.id = v.problem_id WHERE ";
  EXPECT_EQ(count(file_, answers + "p.n = p.nc AND forward_velocity >= 0"), 3);
  EXPECT_EQ(count(file_, answers + "p.n > p.nc AND forward_velocity IS NOT NULL"), 0);
  const Problem problem = open_set(kMonotone)->generate(1, 2);
  Store store = Store::open_for_reading(file_);
  const std::int64_t id = problem_id(kMonotone, 1, 2);
  const std::int64_t solver = store.solvers().at(0).id;
  Evaluator evaluator(problem);
  evaluator.set_certified_velocity(problem.contact()->v);
  sqlite::Statement stored(store.database(), "SELECT forward_velocity FROM verdicts WHERE problem_id = ?");
  stored.bind_all(id);
  ASSERT_TRUE(stored.step());
  EXPECT_EQ(stored.real(0), evaluator.errors(store.answer(id, solver).value()).forward_velocity);
}

/// Certificates are about the pyramid: an answer to the round cone has no forward error, and contradicts no proof.
TEST_F(CertifyStoreTest, AnswersToTheConeAreNotComparedWithCertificates) {
  solve_all(study_of({{kMonotone, 1}, {kFrictional, 1}}), file_);
  change(file_, "UPDATE parameterisations SET friction = 'cone'");
  CertifyRun run;
  run.scope.every = 1;
  run.open = [] {
    return [](const Problem& problem) {
      Certificate certificate = made(CertificateKind::kSolution, problem);
      certificate.velocity_unique = true;
      return certificate;
    };
  };
  certify(file_, run);
  const std::string answers =
      "verdicts v JOIN problems p ON p.id = v.problem_id WHERE forward_velocity IS NOT NULL AND ";
  EXPECT_EQ(count(file_, answers + "p.n > p.nc"), 0);
  EXPECT_EQ(count(file_, answers + "p.n = p.nc"), 1) << "without friction the two models are one";
  EXPECT_EQ(certify(file_, run).total, 0);

  change(file_,
         "DELETE FROM certificates; DELETE FROM certificate_timings; DELETE FROM proofs; "
         "UPDATE verdicts SET solved = 1, velocity_residual_m_per_s = 0; UPDATE problems SET theory = ''");
  certify_as(CertificateKind::kUnsolvable, file_, {.every = 1});
  change(file_, "UPDATE certificates SET least_violation_m_per_s = 1");
  Store store = Store::open_for_writing(file_);
  EXPECT_TRUE(CertificateTable(store).contradictions({.sets = {kFrictional}}).empty());
  EXPECT_FALSE(CertificateTable(store).contradictions({.sets = {kMonotone}}).empty());
  const std::string judged = "judged j JOIN problems p ON p.id = j.problem_id WHERE ";
  EXPECT_EQ(count(file_, judged + "p.n > p.nc AND model = 'cone' AND truth = 'unknown' AND verdict = 'solved'"), 1);
  EXPECT_EQ(count(file_, judged + "p.n = p.nc AND model = 'pyramid' AND truth = 'nearly'"), 1);
}

TEST_F(CertifyStoreTest, AnswersThatCameLaterGetTheirForwardErrorsWithoutAnotherProof) {
  solve_all(study_of({{kMonotone, 3}}), file_);
  certify_as(CertificateKind::kSolution, file_);
  solve_all(study_of({{kMonotone, 3}}, {"lemke", "primal_dual"}), file_);
  EXPECT_EQ(count(file_, "verdicts WHERE forward_velocity IS NOT NULL"), 3);
  Maker maker;
  certify(file_, maker.run());
  EXPECT_EQ(maker.calls, 0);
  EXPECT_EQ(count(file_, "verdicts WHERE forward_velocity IS NOT NULL"), 6);
}

TEST_F(CertifyStoreTest, ProblemThatIsNoLongerTheOneThatWasSolvedIsRefused) {
  solve_all(study_of({{kMonotone, 3}}), file_);
  change(file_, "UPDATE problems SET hash = '00' WHERE trial = 1");
  Maker maker;
  const std::string cause = input_error([&] { certify(file_, maker.run()); });
  EXPECT_NE(cause.find("s.db: trial 1 of seed 1 of set 'paper/monotone/exp1' is another problem"), std::string::npos)
      << cause;
  EXPECT_EQ(count(file_, "certificates WHERE problem_id IN (SELECT id FROM problems WHERE trial = 0)"), 1);
}

TEST_F(CertifyStoreTest, AnswerBetterThanTheProofAllowsIsAContradiction) {
  solve_all(study_of({{kMonotone, 3}}), file_);
  CertifyRun run;
  run.open = [] {
    return [](const Problem& problem) {
      Certificate certificate = made(CertificateKind::kUnsolvable, problem);
      certificate.farkas = Vector::Zero(problem.contact()->nc());
      const Vector approach = to_dense(problem.contact()->N).transpose() * problem.contact()->v;
      Index worst = 0;
      approach.minCoeff(&worst);
      certificate.farkas(worst) = approach(worst) < 0 ? 1 : 0;
      certificate.exact_farkas.denominator = "1";
      for (const double value : certificate.farkas) {
        certificate.exact_farkas.numerators.emplace_back(value > 0 ? "1" : "0");
      }
      return certificate;
    };
  };
  certify(file_, run);
  Store store = Store::open_for_writing(file_);
  const std::vector<std::string> lines = CertificateTable(store).contradictions({});
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
    return line.rfind("paper/monotone/exp1 seed 1 trial ", 0) == 0 && line.find("lemke") != std::string::npos;
  }));
  EXPECT_TRUE(std::any_of(lines.begin(), lines.end(), [](const std::string& line) {
    return line.find("theory says solvable") != std::string::npos;
  }));
  EXPECT_TRUE(CertificateTable(store).contradictions({.sets = {kFrictional}}).empty());
}

// ------------------------------------------------------------------------------------------------------- merging

class MergedCertificatesTest : public CertifyStoreTest {
 protected:
  const Study study_ = study_of({{kMonotone, 6}});
  std::filesystem::path a_ = folder_ / "a.db";
  std::filesystem::path b_ = folder_ / "b.db";
};

TEST_F(MergedCertificatesTest, CertifiedShardsEqualTheCertifiedWhole) {
  solve_all(study_, a_, {.shard = 0, .shards = 2});
  solve_all(study_, b_, {.shard = 1, .shards = 2});
  solve_all(study_, file_);
  for (const auto& file : {a_, b_, file_}) certify_as(CertificateKind::kSolution, file);
  ASSERT_TRUE(merge_stores(folder_ / "out.db", {a_, b_}).conflicts.empty());
  EXPECT_EQ(facts(folder_ / "out.db"), facts(file_));
  EXPECT_EQ(count(folder_ / "out.db", "certificate_timings"), 6);
}

TEST_F(MergedCertificatesTest, AProofTakesThePlaceOfWhatWasLeftOpenInEitherOrder) {
  solve_all(study_, a_);
  std::filesystem::copy_file(a_, b_);
  certify_as(CertificateKind::kOpen, a_, {.time_limit_s = 1});
  certify_as(CertificateKind::kSolution, b_, {.time_limit_s = 2});
  std::vector<std::filesystem::path> many(251, a_);  // more than are read at once
  many.push_back(b_);
  for (const auto& inputs : {std::vector{a_, b_}, std::vector{b_, a_}, many}) {
    const std::filesystem::path out = folder_ / "out.db";
    ASSERT_TRUE(merge_stores(out, inputs).conflicts.empty());
    EXPECT_EQ(facts(out), facts(b_)) << inputs.front();
    EXPECT_EQ(count(out, "certificate_timings WHERE time_limit_s = 2"), 6) << inputs.front();
    std::filesystem::remove(out);
  }
}

TEST_F(MergedCertificatesTest, ForwardErrorsComeFromTheStoreThatHasThem) {
  solve_all(study_, a_);
  std::filesystem::copy_file(a_, b_);
  certify_as(CertificateKind::kSolution, b_);
  ASSERT_TRUE(merge_stores(folder_ / "out.db", {a_, b_}).conflicts.empty());
  EXPECT_EQ(facts(folder_ / "out.db"), facts(b_));
}

TEST_F(MergedCertificatesTest, TwoTruthsAreAConflictThatNamesTheProblem) {
  solve_all(study_, a_);
  std::filesystem::copy_file(a_, b_);
  certify_as(CertificateKind::kSolution, a_);
  certify_as(CertificateKind::kUnsolvable, b_);
  const std::vector<std::string> conflicts = merge_stores(folder_ / "out.db", {a_, b_}).conflicts;
  ASSERT_EQ(conflicts.size(), 6U);
  EXPECT_NE(conflicts.front().find("certificates: paper/monotone/exp1 seed 1 trial"), std::string::npos)
      << conflicts.front();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.db"));
}

TEST_F(MergedCertificatesTest, ASecondVelocityContradictsThatThereIsOnlyOne) {
  solve_all(study_, a_);
  certify_as(CertificateKind::kSolution, a_);
  std::filesystem::copy_file(a_, b_);
  change(b_, "UPDATE certificates SET velocity_unique = NULL");
  EXPECT_TRUE(merge_stores(folder_ / "out.db", {a_, b_}).conflicts.empty()) << "what one store does not know";
  std::filesystem::remove(folder_ / "out.db");
  change(b_, "UPDATE certificates SET velocity_unique = 0");
  EXPECT_EQ(merge_stores(folder_ / "out.db", {a_, b_}).conflicts.size(), 6U);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.db"));
}

// --------------------------------------------------------------------------------------------------- the document

TEST(ProofDocumentTest, HoldsTheProblemBitForBitOnOneLine) {
  for (const char* name : {kMonotone, "paper/monotone/exp3", "paper/copositive/exp3{nc_max=3}", "planted/definite",
                           "planted/definite{form=lcp}"}) {
    const Problem problem = open_set(name)->generate(1, 3);
    Certificate certificate;
    certificate.kind = CertificateKind::kUnsolvable;
    certificate.proof = ProofKind::kFarkas;
    certificate.exact_farkas = {"12345678901234567890123", {"1", "-2"}};
    const std::string text = proof_document(problem, certificate);
    EXPECT_EQ(text.find('\n'), std::string::npos);
    const auto document = ordered_json::parse(text);
    EXPECT_EQ(problem_hash(parse_problem_json(document["problem"].dump(), name)), problem_hash(problem)) << name;
    EXPECT_EQ(document["exact_farkas"]["denominator"], "12345678901234567890123");
    EXPECT_TRUE(document["exact_z"].is_null());
  }
}

TEST(ProofDocumentTest, InflatesToWhatWasDeflatedAndRefusesDamage) {
  std::string text;
  for (int i = 0; i < 50'000; ++i) text += std::to_string(i * 7919) + "\n";
  const std::string bytes = deflate(text);
  EXPECT_LT(bytes.size(), text.size());
  EXPECT_EQ(inflate(bytes), text);
  EXPECT_THROW(inflate(bytes.substr(0, bytes.size() / 2)), InputError);
  EXPECT_THROW(inflate(""), InputError);
  EXPECT_THROW(inflate(bytes + "x"), InputError);
}

TEST(ProofDocumentTest, FractionsAreInLowestTerms) {
  EXPECT_EQ(fractions({"6", {"-34", "12", "0", "1000000000000000000000000"}}),
            (std::vector<std::string>{"-17/3", "2", "0", "500000000000000000000000/3"}));
}

}  // namespace
}  // namespace lcpbench::certificates_test
