#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include "study/evaluation/evaluation.h"
#include "study/store/schema.h"

namespace lcpbench::verdict_test {
namespace {

constexpr std::array kClaims{Claim::kSolved,           Claim::kUnsolvable,  Claim::kIterationLimit, Claim::kTimeLimit,
                             Claim::kNumericalFailure, Claim::kUnsupported, Claim::kCrashed};
constexpr std::array kTruths{"unknown", "solvable", "unsolvable", "nearly", "answered"};
constexpr std::array kAnswers{"unusable", "unresolved", "neither", "criterion", "solved"};
constexpr std::size_t kCombinations = kClaims.size() * kTruths.size() * kAnswers.size();

struct Row {
  std::string claim, truth, answer, verdict, false_claim, counts;

  std::string combination() const { return claim + " / " + truth + " / " + answer; }
};

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(trimmed(part));
  return parts;
}

std::vector<Row> documented_rows() {
  std::ifstream file(LCPBENCH_VERDICTS_TABLE);
  std::vector<Row> rows;
  bool in_table = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("| ---", 0) == 0) {
      in_table = true;
    } else if (in_table && line.rfind("|", 0) == 0) {
      const std::vector<std::string> cells = split(line, '|');
      EXPECT_EQ(cells.size(), 7u) << line;
      if (cells.size() == 7) rows.push_back({cells[1], cells[2], cells[3], cells[4], cells[5], cells[6]});
    }
  }
  return rows;
}

Truth truth_of(const std::string& word) {
  if (word == "solvable") return Truth::kSolvable;
  if (word == "unsolvable") return Truth::kUnsolvable;
  if (word == "nearly") return Truth::kNearly;
  if (word == "answered") return Truth::kAnswered;
  EXPECT_EQ(word, "unknown");
  return Truth::kUnknown;
}

Errors errors_of(const std::string& answer) {
  Errors errors;
  errors.usable = answer != "unusable";
  errors.unresolved = answer == "unresolved";
  errors.solved = answer == "solved";
  errors.criterion = answer == "criterion";
  return errors;
}

bool contains(const std::string& counts, const std::string& name) {
  for (const std::string& count : split(counts, ',')) {
    if (count == name) return true;
  }
  return false;
}

TEST(VerdictTest, TheTableNamesEveryCombinationOnce) {
  std::set<std::string> expected;
  for (const Claim claim : kClaims) {
    for (const char* truth : kTruths) {
      for (const char* answer : kAnswers) expected.insert(Row{to_string(claim), truth, answer}.combination());
    }
  }
  std::set<std::string> documented;
  for (const Row& row : documented_rows()) {
    EXPECT_TRUE(documented.insert(row.combination()).second) << "twice: " << row.combination();
  }
  EXPECT_EQ(documented, expected);
  EXPECT_EQ(documented.size(), kCombinations);
}

TEST(VerdictTest, TheCodeFollowsTheTable) {
  for (const Row& row : documented_rows()) {
    const Claim claim = parse_claim(row.claim);
    const Verdict found = verdict(claim, errors_of(row.answer), truth_of(row.truth));
    EXPECT_EQ(to_string(found), row.verdict) << row.combination();
    EXPECT_EQ(found == Verdict::kWrong ? "yes" : "no", row.false_claim) << row.combination();
    const bool nearly = row.truth == "nearly";
    EXPECT_EQ(contains(row.counts, "unsolvable_problems"), row.truth == "unsolvable" || row.verdict == "unsolvable")
        << row.combination();
    EXPECT_EQ(contains(row.counts, "nearly_problems"), nearly) << row.combination();
    for (const char* word : {"solved", "unsolvable"}) {
      EXPECT_EQ(contains(row.counts, std::string("nearly_") + word), nearly && row.verdict == word)
          << row.combination();
    }
    EXPECT_EQ(contains(row.counts, "false_unsolvable"), claim == Claim::kUnsolvable && row.truth == "solvable")
        << row.combination();
    EXPECT_EQ(split(row.counts, ',').front(), row.verdict) << row.combination();
    EXPECT_EQ(contains(row.counts, "claimed"), claim == Claim::kSolved) << row.combination();
    EXPECT_EQ(contains(row.counts, "false_claims"), row.false_claim == "yes") << row.combination();
    EXPECT_EQ(contains(row.counts, "crashed"), claim == Claim::kCrashed) << row.combination();
  }
}

TEST(VerdictTest, EveryMeasureIsDocumented) {
  std::ifstream file(LCPBENCH_VERDICTS_PAGE);
  std::ostringstream page;
  page << file.rdbuf();
  for (const Metric& metric : kMetrics) {
    EXPECT_NE(page.str().find("| `" + std::string(metric.name) + "` | "), std::string::npos) << metric.name;
  }
}

TEST(VerdictTest, PassingThePapersCriterionChangesNoVerdict) {
  for (const Claim claim : kClaims) {
    for (const char* word : kTruths) {
      const Truth truth = truth_of(word);
      for (const char* answer : {"unusable", "neither", "solved"}) {
        Errors errors = errors_of(answer);
        const Verdict without = verdict(claim, errors, truth);
        errors.criterion = true;
        EXPECT_EQ(verdict(claim, errors, truth), without);
      }
    }
  }
}

class Database {
 public:
  Database() {
    EXPECT_EQ(sqlite3_open(":memory:", &handle_), SQLITE_OK);
    run(store_schema());
  }
  ~Database() { sqlite3_close(handle_); }
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void run(const std::string& sql) {
    char* message = nullptr;
    EXPECT_EQ(sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK)
        << (message != nullptr ? message : "") << "\n"
        << sql;
    sqlite3_free(message);
  }

  std::vector<std::string> texts(const std::string& sql) {
    std::vector<std::string> result;
    const auto append = [](void* out, int, char** values, char**) {
      static_cast<std::vector<std::string>*>(out)->emplace_back(values[0] != nullptr ? values[0] : "NULL");
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(handle_, sql.c_str(), append, &result, nullptr), SQLITE_OK) << sql;
    return result;
  }

 private:
  sqlite3* handle_ = nullptr;
};

// Solver 1 gave the answer in question; solver 2, where there is one, settles the truth.
struct StoredCase {
  std::string theory;       // problems.theory
  std::string certificate;  // certificates.certificate, "" for none
  bool solved_by_other = false;
  bool refuted_by_other = false;
};

void insert_answer(Database& store, std::size_t problem, int solver, const std::string& claim, const Errors& errors,
                   bool farkas) {
  const std::string key = std::to_string(problem) + "," + std::to_string(solver) + ",0";
  store.run("INSERT INTO answers VALUES (" + key + ",1,'" + claim + "',NULL,NULL,NULL,-1,-1,-1,'',0)");
  store.run(
      "INSERT INTO verdicts (problem_id, solver_id, part, usable, solved, criterion, farkas_checked, worst_row, "
      "checksum) VALUES "
      "(" +
      key + "," + std::to_string(errors.usable) + "," + std::to_string(errors.solved) + "," +
      std::to_string(errors.criterion) + "," + std::to_string(farkas) + "," + (errors.unresolved ? "-1" : "NULL") +
      ",0)");
}

std::string stored_verdict(Database& store, std::size_t problem, const Row& row, const StoredCase& stored) {
  const std::string id = std::to_string(problem);
  store.run("INSERT INTO problems VALUES (" + id + ",1,1," + id + ",'contact',4,2,1,0,'','" + stored.theory + "','[]',0)");
  insert_answer(store, problem, 1, row.claim, errors_of(row.answer), false);
  if (stored.solved_by_other) insert_answer(store, problem, 2, "solved", errors_of("solved"), false);
  if (stored.refuted_by_other) insert_answer(store, problem, 3, "unsolvable", errors_of("unusable"), true);
  if (!stored.certificate.empty()) {
    store.run("INSERT INTO certificates (problem_id, certificate, proof, detail, checksum) VALUES (" + id + ",'" +
              stored.certificate + "','farkas','',0)");
  }
  const auto found = store.texts("SELECT verdict FROM judged WHERE solver_id = 1 AND problem_id = " + id);
  return found.size() == 1 ? found.front() : "no single row";
}

TEST(VerdictTest, TheStoresViewFollowsTheTableHoweverTheTruthCameToLight) {
  const std::vector<StoredCase> unknown{{"", ""}, {"", "open"}};
  const std::vector<StoredCase> solvable{{"solvable", ""}, {"", "solution"}};
  const std::vector<StoredCase> answered{{"", "", true}, {"", "open", true}};
  const std::vector<StoredCase> unsolvable{{"", "unsolvable"}, {"", "", false, true}};
  const std::vector<StoredCase> nearly{{"", "", true, true}, {"", "unsolvable", true, false}};
  Database store;
  std::size_t problem = 0;
  for (const Row& row : documented_rows()) {
    const Truth truth = truth_of(row.truth);
    const auto& ways = truth == Truth::kUnknown    ? unknown
                       : truth == Truth::kSolvable ? solvable
                       : truth == Truth::kNearly   ? nearly
                       : truth == Truth::kAnswered ? answered
                                                   : unsolvable;
    // An answer that passes is itself the evidence that makes a problem nearly solvable.
    if (truth == Truth::kUnsolvable && row.answer == "solved") continue;
    for (const StoredCase& stored : ways) {
      EXPECT_EQ(stored_verdict(store, ++problem, row, stored), row.verdict) << row.combination();
    }
  }
  EXPECT_EQ(problem, kClaims.size() * (kAnswers.size() * (2 + 2 + 2 + 2 + 2) - 2));
}

/// A proof that a bare LCP has no solution, with an answer that passes or not: its margin alone decides.
TEST(VerdictTest, TheMarginOfAProofDecidesWhetherABareLcpIsNearlySolvable) {
  constexpr double kNone = Errors::kNone;
  Database store;
  std::size_t problem = 0;
  const auto expect = [&](const char* truth, double by_answer, double by_certificate, bool solved) {
    const std::string id = std::to_string(++problem), margin = std::to_string(by_certificate);
    store.run("INSERT INTO problems VALUES (" + id + ",1,1," + id + ",'lcp',4,0,0,0,'','','[]',0)");
    Findings findings;
    if (!std::isnan(by_answer)) {
      insert_answer(store, problem, 1, "unsolvable", errors_of("unusable"), true);
      store.run("UPDATE verdicts SET proof_margin = " + std::to_string(by_answer) + " WHERE problem_id = " + id);
      Judgement judgement{.proof_holds = true};
      judgement.errors.proof_margin = by_answer;
      findings.add(judgement);
    }
    if (solved) {
      insert_answer(store, problem, 2, "solved", errors_of("solved"), false);
      findings.add(Evidence::kSolvedAnswer);
    }
    if (!std::isnan(by_certificate)) {
      store.run("INSERT INTO certificates (problem_id, certificate, proof, proof_margin, detail, checksum) VALUES (" +
                id + ",'unsolvable','farkas'," + margin + ",'',0)");
      findings.add_proof(Evidence::kCertifiedUnsolvable, by_certificate);
    }
    EXPECT_EQ(to_string(findings.truth()), std::string(truth)) << problem;
    EXPECT_EQ(store.texts("SELECT truth FROM truths WHERE problem_id = " + id), std::vector<std::string>{truth})
        << problem;
  };
  for (const bool solved : {false, true}) {
    expect("nearly", 1e-6, kNone, solved);
    expect("unsolvable", 1.1e-5, kNone, solved);
    expect("nearly", kNone, 1e-6, solved);
    expect("unsolvable", kNone, 1.1e-5, solved);
    expect("unsolvable", 1e-6, 0.5, solved);
    expect("unsolvable", 0.5, 1e-6, solved);
  }
}

}  // namespace
}  // namespace lcpbench::verdict_test
