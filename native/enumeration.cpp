#include <algorithm>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test.h"
#include "native/enumeration/exact_system.h"

namespace lcpbench {
namespace {

using IndexSet = std::uint32_t;  // bit i: index i is in the set

constexpr Index kMaxSize = 12;

/// Longer than any detail.
constexpr std::size_t kLongestDetail = 160;

struct EnumerationSettings {
  void visit(auto&&) {}
};

bool contains(IndexSet set, Index i) { return (set >> i & 1U) != 0; }

void list_members(IndexSet set, std::vector<Index>& members) {
  members.clear();
  for (Index i = 0; i < kMaxSize; ++i) {
    if (contains(set, i)) members.push_back(i);
  }
}

/// Appends "{0,2}".
void append(const std::vector<Index>& set, std::string& text) {
  text += '{';
  for (const Index i : set) {
    char digits[2];
    if (i != set.front()) text += ',';
    text.append(digits, std::to_chars(digits, digits + sizeof digits, i).ptr);
  }
  text += '}';
}

/// Decides LCP(q, M), n <= 12, in exact integer arithmetic by going through all 2^n supports of z.
///
/// For a support S the points z_S >= 0, w_S = 0, w >= 0 form a polyhedron without lines, so when it is not empty it has
/// a vertex: a point at which z vanishes outside some S' in S and the rows of S' together with further rows w_j = 0
/// determine z_S'. These points are all tried, so singular principal submatrices are decided like the others.
/// Supports come in the order of the number whose bit i says that i is in S; the first solution found is returned, each
/// entry rounded once. 2^n systems of order <= n when no principal submatrix is singular, at most 3^n otherwise.
/// [Cottle, Pang, Stone 1992, section 1.3: complementary cones]
class Enumeration final : public Solver {
 public:
  explicit Enumeration(const EnumerationSettings&) {}
  const Capabilities& capabilities() const override;

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  bool find_with_support(IndexSet support);
  bool complete(Index first_row);
  bool is_solution();
  void describe(Answer& answer, std::string_view remark) const;
  void report_solution(Answer& answer);
  void report_none(Answer& answer) const;

  Index n_ = 0;
  enumeration::Rows rows_;
  enumeration::System system_;
  std::vector<Index> support_;
  std::vector<Index> others_;
  AnswerTest test_;
  std::string detail_;  // memory for the first answer that comes with less
  double deadline_s_ = 0;
  bool out_of_time_ = false;
  Counters counters_;
};

void Enumeration::on_load(const Problem& problem) {
  const Lcp lcp = make_lcp(problem);
  n_ = lcp.size();
  rows_.load(lcp);
  system_.load(rows_);
  support_.reserve(kMaxSize);
  others_.reserve(kMaxSize);
  test_.load(problem);
  detail_.reserve(kLongestDetail);
}

bool Enumeration::is_solution() {
  ++counters_.factorizations;
  system_.solve();
  for (std::size_t j = 0; j < support_.size(); ++j) {
    if (enumeration::is_negative(system_.numerator(j))) return false;
  }
  return std::none_of(others_.begin(), others_.end(), [this](Index row) { return system_.is_violated(row); });
}

/// Tries every point that the system and rows w_j = 0, j >= first_row outside the support, determine. Leaves the system
/// as it was, or, where it finds one, at the solution.
bool Enumeration::complete(Index first_row) {
  out_of_time_ = out_of_time_ || !(wall_clock_s() < deadline_s_);
  if (out_of_time_) return false;
  if (system_.full_rank()) return is_solution();
  for (const Index row : others_) {
    if (row < first_row || out_of_time_) continue;
    if (system_.add(row) != enumeration::System::Row::kIndependent) continue;
    if (complete(row + 1)) return true;
    system_.remove_last();
  }
  return false;
}

bool Enumeration::find_with_support(IndexSet support) {
  list_members(support, support_);
  list_members(~support & ((IndexSet{1} << n_) - 1), others_);
  system_.start(support_);
  for (const Index row : support_) {
    if (system_.add(row) == enumeration::System::Row::kInconsistent) return false;
  }
  return complete(0);
}

void Enumeration::describe(Answer& answer, std::string_view remark) const {
  answer.detail = "exact solution with z = 0 outside ";
  append(support_, answer.detail);
  answer.detail += remark;
}

/// M of a contact problem is rounded when it is formed: its exact solution need not be one of the contacts.
void Enumeration::report_solution(Answer& answer) {
  for (std::size_t j = 0; j < support_.size(); ++j) answer.z(support_[j]) = system_.nearest(j);
  answer.claim = answer.z.allFinite() ? Claim::kSolved : Claim::kNumericalFailure;
  describe(answer, answer.claim == Claim::kSolved ? "" : " overflows double");
  if (answer.claim != Claim::kSolved) return;
  if (test_.settle(answer, deadline_s_)) return;
  if (answer.claim == Claim::kTimeLimit) return;
  if (problem().contact() != nullptr) {
    answer.detail = "the exact solution for M as rounded to double does not solve the contact problem";
  } else {
    describe(answer, ": rounded to double it solves the problem no more");
  }
}

/// M of a contact problem is rounded when it is formed: that it has no solution proves nothing about the contacts.
void Enumeration::report_none(Answer& answer) const {
  const bool data_are_exact = problem().contact() == nullptr;
  answer.claim = data_are_exact ? Claim::kUnsolvable : Claim::kNumericalFailure;
  answer.detail = data_are_exact ? "every support of z ruled out in exact arithmetic"
                                 : "no solution for M as rounded to double; the contact problem may have one";
}

void Enumeration::on_solve(const SolveRequest& request, Answer& answer) {
  if (answer.detail.capacity() < kLongestDetail) answer.detail.swap(detail_);
  answer.detail.clear();
  deadline_s_ = wall_clock_s() + request.time_limit_s;
  out_of_time_ = false;
  counters_ = {.iterations = 0, .pivots = -1, .factorizations = 0};
  bool found = false;
  for (IndexSet support = 0; support < IndexSet{1} << n_ && !found && !out_of_time_; ++support) {
    ++counters_.iterations;
    found = find_with_support(support);
  }
  if (found) {
    report_solution(answer);
  } else if (out_of_time_) {
    answer.claim = Claim::kTimeLimit;
  } else {
    report_none(answer);
  }
  answer.counters = counters_;
}

constexpr Capabilities kCapabilities{.max_size = kMaxSize,
                                     .guarantees = "every (q, M) as rounded to double",
                                     .obeys_time_limit = true,
                                     .allocation_free = true};

const Capabilities& Enumeration::capabilities() const { return kCapabilities; }

}  // namespace

SolverDefinition lcpbench_solver_enumeration() {
  return define_solver<Enumeration, EnumerationSettings>(
      {.name = "enumeration",
       .summary = "all 2^n complementary supports in exact integer arithmetic: an oracle for n <= 12",
       .source = "Cottle, Pang, Stone: The Linear Complementarity Problem, 1992, section 1.3; Bareiss 1968",
       .capabilities = kCapabilities});
}

}  // namespace lcpbench
