#pragma once

#include <cstdint>
#include <vector>

#include "native/sor/conjugate_steps.h"
#include "native/sor/contact_blocks.h"

namespace lcpbench {

/// Sweeps over the contacts that are far off, where these are few. A handful of bodies may need thousands of sweeps, in
/// which nothing else moves.
///
/// The contacts at the bodies of those that are off make groups that share no body. Each group is swept by itself, with
/// conjugate steps of its own, so that no group slows another one down. What stands beside a group is not moved; the
/// next sweep over all contacts finds what the group has put off there. A nonlinear multiplicative Schwarz method with
/// subdomains that follow the error.
class LocalSweeps {
 public:
  /// Takes all memory. @pre blocks.has_bodies()
  void load(const ContactBlocks& blocks);

  struct Limits {
    double relaxation = 1;
    double allowed = 0;  ///< how much contacts may be off in the end
    double deadline_s = 0;
  };

  /// Sweeps all groups if less than a quarter of the contacts is far off in blocks.errors, that of the last sweep. The
  /// caller begins its own steps anew. Allocates nothing.
  /// @returns updates of a contact that it took; 0: too many contacts are off, nothing has changed
  std::int64_t run(ContactBlocks& blocks, ConjugateSteps& steps, const Limits& limits);

 private:
  bool choose(const ContactBlocks& blocks);
  void find_groups(const ContactBlocks& blocks);
  std::int64_t sweep_group(std::size_t group, std::int64_t sweeps, ContactBlocks& blocks, ConjugateSteps& steps,
                           const Limits& limits);
  std::size_t root_of(std::size_t body);

  double far_ = 0;                        // from this on a contact is far off
  std::vector<Index> chosen_;             // contacts that are swept, group by group, each in the order of all
  std::vector<std::size_t> group_begin_;  // offsets into chosen_
  std::vector<std::size_t> group_of_;     // per body
  std::vector<std::size_t> parent_;       // per body: the tree of its group
  std::vector<std::size_t> next_;         // scratch of the groups
  std::vector<Index> unsorted_;
  std::vector<Entries> rows_, coordinates_;  // of a group
};

}  // namespace lcpbench
