#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "study/store/store.h"

namespace lcpbench {

/// A problem with every distinct answer to it, in order of solver and part. Times that the store lacks are NaN. Valid
/// until the next; what `StoredAnswer::cells` point to lives as long as the scan.
struct AnsweredProblem {
  const ProblemRow& row;
  Truth truth;
  double least_violation_m_per_s;  ///< by its certificate: every answer violates a contact by this; NaN: none is known
  std::span<const StoredAnswer> answers;
};

/// Reads the answers to the problems of one set or of all, in one walk through problems, answers, verdicts and timings.
/// Each row that it reads is checked: it is what was written, and the tables belong together. The verdicts are those of
/// the view `judged`, by the same rule. Vectors are not read. What another process adds meanwhile is not seen.
class AnswerScan {
 public:
  explicit AnswerScan(Store& store);
  ~AnswerScan();

  /// Visits the problems of a set, or of all sets, in order of their ids. Only a read of all sets finds out that a
  /// whole problem or answer is missing. @throws InputError when a row is missing, or is not what was written.
  void read(const std::optional<std::int64_t>& set_id, const std::function<void(const AnsweredProblem&)>& visit);

  /// The groups of parameterisations that gave one answer, each ascending.
  const std::vector<std::vector<std::uint32_t>>& groups() const { return groups_; }

 private:
  struct Table;
  struct Certificate {
    Evidence evidence;
    double least_violation_m_per_s;
  };
  AnsweredProblem read_problem(const ProblemRow& of);
  void read_answer(const ProblemRow& of, StoredAnswer& answer, Findings& findings);

  sqlite::Database& database_;
  sqlite::ReadSnapshot snapshot_;
  std::unordered_map<std::int64_t, std::string> sets_;
  std::unordered_map<std::int64_t, Certificate> certificates_;  ///< those that decide, by problem
  std::unordered_map<std::int64_t, std::vector<FrictionModel>> friction_;  ///< of each cell, by solver
  std::vector<std::vector<std::uint32_t>> groups_;
  std::unordered_map<std::int64_t, std::uint32_t> group_places_;  ///< in groups_, by group_id
  std::vector<StoredAnswer> buffer_;  ///< begins with the answers to the present problem; never shrinks
  std::unique_ptr<Table> answers_, verdicts_, timings_;  ///< each at the row that comes next
};

}  // namespace lcpbench
