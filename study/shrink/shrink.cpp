#include "study/shrink/shrink.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>
#include <vector>

#include "core/entries.h"
#include "core/error.h"
#include "core/io/problem_io.h"
#include "core/selection.h"
#include "core/timed_solve.h"
#include "study/shrink/ddmin.h"
#include "study/shrink/numbers.h"
#include "study/shrink/pieces.h"

namespace lcpbench {
namespace {

/// In turn, for numbers of up to 17.
constexpr int kDigits[] = {1, 2, 3, 4, 6, 9, 12};

/// Columns of N, D and R without an entry that is not zero, which `inspect` doubts; 0 for a bare LCP.
Index zero_columns(const Problem& problem) {
  const ContactProblem* const contact = problem.contact();
  if (contact == nullptr) return 0;
  Index count = 0;
  for (const Jacobian* const J : {&contact->N, &contact->D, &contact->rows.R}) {
    for (Index column = 0; column < cols(*J); ++column) {
      bool zero = true;
      for_each_entry(*J, column, [&](Index, double) { zero = false; });
      if (zero) ++count;
    }
  }
  return count;
}

class Shrinker {
 public:
  Shrinker(const Problem& start, const std::function<bool(const Problem&)>& fails, const ShrinkOptions& options)
      : best_(start), fails_(fails), options_(options), end_s_(wall_clock_s() + options.budget_s) {}

  Shrunk run() {
    std::string before;
    do {
      before = problem_hash(best_);
      leave_out_contacts();
      leave_out_rows();
      leave_out_bodies();
      leave_out_factors();
      leave_out_friction();
      round_numbers();
    } while (!over() && problem_hash(best_) != before);
    return {best_, tries_, !over()};
  }

 private:
  bool over() {
    if (!over_) over_ = (options_.stop != nullptr && *options_.stop != 0) || wall_clock_s() > end_s_;
    return over_;
  }

  /// Takes the candidate if it fails.
  template <class Make>
  bool take(Make&& make) {
    if (over()) return false;
    try {
      const Problem candidate = parse_problem_json(problem_json(make()), "candidate");
      if (zero_columns(candidate) > zero_columns(best_)) return false;  // a contact without a normal is none
      if (!known_.insert(problem_hash(candidate)).second) return false;
      if (options_.progress) options_.progress(best_, tries_);
      ++tries_;
      if (!fails_(candidate)) return false;
      best_ = candidate;
      return true;
    } catch (const InputError&) {  // no problem file holds it
      return false;
    }
  }

  /// Finds the fewest of `units` that must stay; `part` makes the problem that keeps them.
  template <class Part>
  void keep_fewest(const std::vector<Index>& units, Part part) {
    const Problem whole = best_;
    minimal_subset(units, [&](const std::vector<Index>& kept) { return take([&] { return part(whole, kept); }); });
  }
  void leave_out_contacts() { keep_fewest(all_indices(contact_count(best_)), with_contacts); }
  void leave_out_rows() {
    if (row_count(best_) > 0) keep_fewest(all_indices(row_count(best_)), with_rows);
  }
  void leave_out_bodies() { keep_fewest(all_indices(body_count(best_)), with_bodies); }

  void leave_out_factors() {
    if (factor_count(best_) > 0) keep_fewest(all_indices(factor_count(best_)), with_factors);
  }

  void leave_out_friction() {
    keep_fewest(frictional_contacts(best_), with_friction);
    for (std::vector<Index> many = contacts_of_many_edges(best_); !many.empty();) {
      const std::size_t before = many.size();
      const Index edges = problem_size(best_).friction_edges;
      keep_fewest(many, with_fewer_edges);
      many = contacts_of_many_edges(best_);
      if (many.size() == before && problem_size(best_).friction_edges == edges) break;
    }
  }

  /// Takes the draft with `change` made in it, which returns whether it changed anything.
  template <class Change>
  bool take_changed(Change change) {
    Draft draft(best_, symmetric_);
    return change(draft) && take([&] { return draft.problem(); });
  }

  /// @returns whether that changes anything
  static bool round_all(const Draft::Group& group, int digits) {
    bool changed = false;
    for (const Number& number : group) {
      if (digits_of(number.value()) <= digits) continue;
      number.set(rounded(number.value(), digits));
      changed = true;
    }
    return changed;
  }

  /// @returns whether that changes anything
  static bool equalize(const Draft::Group& group, double value) {
    bool changed = false;
    for (const Number& number : group) {
      changed = changed || std::abs(number.value()) != value;
      number.set(value == 0 ? 0 : std::copysign(value, number.value()));
    }
    return changed;
  }

  /// All numbers in few digits; then each meaning by itself; then each number.
  void round_numbers() {
    // Once for all of them: a number must keep its place in its group where M becomes symmetric on the way.
    symmetric_ = has_symmetric_matrix(best_);
    for (const int digits : kDigits) {
      const bool taken = take_changed([&](Draft& draft) {
        bool changed = false;
        for (const Draft::Group& group : draft.groups()) changed = round_all(group, digits) || changed;
        return changed;
      });
      if (taken) break;
    }
    const std::size_t groups = Draft(best_, symmetric_).groups().size();
    for (std::size_t g = 0; g < groups; ++g) round_group(g);
    for (std::size_t g = 0; g < groups; ++g) round_each(g);
  }

  void round_group(std::size_t g) {
    take_changed([g](Draft& draft) { return equalize(draft.groups()[g], 0); });
    take_changed([g](Draft& draft) { return equalize(draft.groups()[g], 1); });
    take_changed([g](Draft& draft) {
      const Draft::Group& group = draft.groups()[g];
      return !group.empty() && equalize(group, std::abs(group[0].value()));
    });
    for (const int digits : kDigits) {
      if (take_changed([&](Draft& draft) { return round_all(draft.groups()[g], digits); })) break;
    }
  }

  void round_each(std::size_t g) {
    const Draft start(best_, symmetric_);
    // A number that becomes zero is in the group no more: from the last to the first, no other changes its place.
    for (std::size_t i = start.groups()[g].size(); i-- > 0;) {
      const double value = start.groups()[g][i].value();
      const auto set = [&](double to) {
        return to != value && take_changed([&](Draft& draft) {
                 draft.groups()[g][i].set(to);
                 return true;
               });
      };
      if (set(0) || set(std::copysign(1.0, value))) continue;
      for (const int digits : kDigits) {
        if (digits >= digits_of(value) || set(rounded(value, digits))) break;
      }
    }
  }

  Problem best_;
  const std::function<bool(const Problem&)>& fails_;
  const ShrinkOptions& options_;
  double end_s_;
  bool over_ = false;
  bool symmetric_ = false;  ///< the M of best_, while its numbers are rounded
  std::int64_t tries_ = 0;
  std::unordered_set<std::string> known_;  ///< hashes of what was tried
};

}  // namespace

ProblemSize problem_size(const Problem& problem) {
  ProblemSize size;
  size.contacts = contact_count(problem);
  size.rows = row_count(problem);
  size.bodies = body_count(problem);
  if (problem.contact() != nullptr) size.friction_edges = cols(problem.contact()->D);
  const Draft draft(problem);
  for (const Draft::Group& group : draft.groups()) {
    size.numbers += static_cast<Index>(group.size());
    for (const Number& number : group) size.digits += digits_of(number.value());
  }
  return size;
}

Shrunk shrink(const Problem& start, const std::function<bool(const Problem&)>& fails, const ShrinkOptions& options) {
  return Shrinker(start, fails, options).run();
}

}  // namespace lcpbench
