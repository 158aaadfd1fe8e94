#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "core/problem.h"
#include "core/solver.h"
#include "native/contact_lemke/contact_lemke.h"
#include "native/sor/contact_blocks.h"

namespace lcpbench {

/// Contacts about which the sweeps wander, solved together by contact_lemke in place of their updates. With much
/// friction the splitting of a sweep may be unstable at a handful of sliding contacts of a pile: their exact solution
/// would be lost again in the next sweeps. A block Gauss-Seidel method whose blocks
/// appear where the sweeps fail. That it converges is not proven.
///
/// The coordinates of a part are those of ContactBlocks, in which the inertia is the identity.
class ExactParts {
 public:
  /// Forgets all parts. @pre blocks.has_bodies()
  void load(const ContactBlocks& blocks);
  void clear();
  bool empty() const { return parts_.empty(); }

  /// Chooses parts about the contacts and the parts that are off most; parts that stand there grow. Allocates.
  void extend(ContactBlocks& blocks);

  /// Solves each part for the velocity that the others leave it, goes half of the way to its answer, and sweeps the
  /// other contacts a few times. From the second time on contact_lemke goes on from its last basis. Parts that it does
  /// not solve in two paths in double, or in some pivots for each contact, are given back to the sweeps.
  /// @returns what the last of the sweeps changed, with the steps of the parts
  ContactBlocks::Step sweep(ContactBlocks& blocks, double relaxation, double deadline_s);

  /// How many sweeps over all contacts have as many multiplications as the last sweep.
  double sweeps_made() const { return multiplications_ / (2 * static_cast<double>(entries_)); }
  /// Of the last call of sweep(), see BudgetedSolver::work().
  double work() const { return work_; }

 private:
  struct Part {
    explicit Part(std::shared_ptr<LaterEngines> later) : solver({}, std::move(later)) {
      solver.limit_stages(2);
      solver.resume_bases();
    }

    std::vector<Index> contacts;     // in the order of all
    std::vector<Index> coordinates;  // of the bodies that they touch
    Problem problem;
    ContactLemke solver;
    Answer answer;
    Vector v;
    bool is_loaded = false;
    double off = 0;  // in the last sweep
  };

  void grow(const ContactBlocks& blocks, std::size_t contacts);
  void add_part(std::size_t number);
  std::size_t part_beside(const ContactBlocks& blocks, Index contact) const;
  void list_others(ContactBlocks& blocks);
  bool is_in_part(Index contact) const { return part_of_[static_cast<std::size_t>(contact)] != kNone; }
  void find_velocity(const ContactBlocks& blocks, Part& part);
  void load(const ContactBlocks& blocks, Part& part);
  void solve(const ContactBlocks& blocks, double deadline_s, Part& part);
  void give_back(std::size_t number);
  void take_answer(ContactBlocks& blocks, Part& part);
  template <class Visit>
  void for_each_neighbour(const ContactBlocks& blocks, Index contact, Visit&& visit) const;

  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

  std::shared_ptr<LaterEngines> later_;
  std::vector<std::unique_ptr<Part>> parts_;
  std::vector<std::size_t> part_of_;  // per contact
  std::vector<Index> others_;         // contacts in no part
  std::vector<std::size_t> begin_;    // offsets into at_body_
  std::vector<Index> at_body_;        // contacts, body by body
  std::vector<Index> chosen_;         // contacts of a part to be
  std::vector<char> is_chosen_;       // per contact
  std::vector<Index> place_;          // per coordinate: in the part at hand
  std::size_t entries_ = 0;           // ContactBlocks::entries
  std::size_t most_contacts_ = 0;     // of a part that contact_lemke does not refuse
  // Of the sweep at hand:
  double multiplications_ = 0;
  double work_ = 0;                   // see work()
};

}  // namespace lcpbench
