#include <charconv>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/registry.h"
#include "core/timed_solve.h"
#include "native/answer_test/answer_test.h"
#include "native/enumeration/exact_search.h"

namespace lcpbench {
namespace {

using enumeration::ExactSearch;

struct EnumerationSettings {
  void visit(auto&&) {}
};

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

/// Decides LCP(q, M), n <= 12, by ExactSearch; the first solution found is returned, each entry rounded once.
class Enumeration final : public Solver {
 public:
  explicit Enumeration(const EnumerationSettings&) {}
  const Capabilities& capabilities() const override;

 protected:
  void on_load(const Problem& problem) override;
  void on_solve(const SolveRequest& request, Answer& answer) override;

 private:
  void describe(Answer& answer, std::string_view remark) const;
  void report_solution(Answer& answer);
  void report_none(Answer& answer) const;

  ExactSearch search_;
  AnswerTest test_;
  bool overflows_ = false;  // M of finite contacts, in double
  double deadline_s_ = 0;
};

void Enumeration::on_load(const Problem& problem) {
  const Lcp lcp = make_lcp(problem);
  overflows_ = !lcp.M.allFinite() || !lcp.q.allFinite();
  if (overflows_) return;
  search_.load(lcp);
  test_.load(problem);
}

void Enumeration::describe(Answer& answer, std::string_view remark) const {
  answer.detail = "exact solution with z = 0 outside ";
  append(search_.support(), answer.detail);
  answer.detail += remark;
}

/// M of a contact problem is rounded when it is formed: its exact solution need not be one of the contacts.
void Enumeration::report_solution(Answer& answer) {
  const std::vector<Index>& support = search_.support();
  for (std::size_t j = 0; j < support.size(); ++j) answer.z(support[j]) = search_.nearest(j);
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
  if (overflows_) {
    answer.detail = "M overflows double";
    return;
  }
  deadline_s_ = wall_clock_s() + request.time_limit_s;
  const ExactSearch::End end = search_.run(deadline_s_, std::numeric_limits<std::int64_t>::max());
  switch (end) {
    case ExactSearch::End::kFound: report_solution(answer); break;
    case ExactSearch::End::kNone: report_none(answer); break;
    case ExactSearch::End::kTimeLimit:
    case ExactSearch::End::kSystemLimit: answer.claim = Claim::kTimeLimit; break;
  }
  answer.counters = {.iterations = search_.supports_tried(), .pivots = -1, .factorizations = search_.systems_solved()};
}

constexpr Capabilities kCapabilities{.max_size = ExactSearch::kMaxSize,
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
