#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
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
/// The verdicts are those of the view `judged`, by the same rule. Vectors are not read. What another process adds
/// meanwhile is not seen. Rows are not compared with their checksums, see Store::check().
class AnswerScan {
 public:
  explicit AnswerScan(Store& store);

  /// Visits the problems of a set, or of all sets, in order of their ids. @throws InputError when an answer has no
  /// verdict, or belongs to no cells of its solver.
  void read(const std::optional<std::int64_t>& set_id, const std::function<void(const AnsweredProblem&)>& visit);

  /// The groups of parameterisations that gave one answer, each ascending.
  const std::vector<std::vector<std::uint32_t>>& groups() const { return groups_; }

 private:
  void read_answer(const sqlite::Statement& query, const ProblemRow& of, StoredAnswer& answer, Findings& findings);

  sqlite::Database& database_;
  sqlite::ReadSnapshot snapshot_;
  std::vector<std::vector<std::uint32_t>> groups_;
  std::unordered_map<std::int64_t, std::uint32_t> group_places_;  ///< in groups_, by group_id
  std::vector<StoredAnswer> buffer_;  ///< begins with the answers to the present problem; never shrinks
};

}  // namespace lcpbench
