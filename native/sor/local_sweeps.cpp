#include "native/sor/local_sweeps.h"

#include <algorithm>
#include <numeric>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

// Measured on piles of spheres, see docs/reference/solvers/psor.md.

/// A contact is far off if it is off by more than this part of the largest, and of what is allowed in the end.
constexpr double kFarOfLargest = 0.01;
constexpr double kFarOfAllowed = 0.5;
/// A group is swept until its contacts are off by less than this part of what is far.
constexpr double kReduced = 0.2;
/// No more than one contact of so many may be far off.
constexpr Index kLeastShare = 4;
/// All groups together may take as many updates as so many sweeps over all contacts, but each at least ten sweeps.
constexpr std::int64_t kSweepsOfAll = 2;
constexpr std::int64_t kFewestSweeps = 10;

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

/// Appends a range to those before it, as one where they meet.
void append(Index first, Index size, std::vector<Entries>& ranges) {
  if (!ranges.empty() && ranges.back().first + ranges.back().size == first) {
    ranges.back().size += size;
  } else {
    ranges.push_back({first, size});
  }
}

}  // namespace

void LocalSweeps::load(const ContactBlocks& blocks) {
  const auto contacts = static_cast<std::size_t>(blocks.contacts());
  const std::size_t bodies = blocks.bodies();
  chosen_.reserve(contacts);
  unsorted_.reserve(contacts);
  group_begin_.reserve(contacts + 1);
  next_.reserve(contacts + 1);
  group_of_.resize(bodies);
  parent_.resize(bodies);
  rows_.reserve(contacts);
  coordinates_.reserve(bodies);
}

std::int64_t LocalSweeps::run(ContactBlocks& blocks, ConjugateSteps& steps, const Limits& limits) {
  far_ = std::max(kFarOfAllowed * limits.allowed, kFarOfLargest * blocks.errors.maxCoeff());
  if (!choose(blocks)) return 0;
  find_groups(blocks);
  const std::int64_t all = kSweepsOfAll * blocks.contacts() / static_cast<std::int64_t>(chosen_.size());
  std::int64_t updates = 0;
  for (std::size_t group = 0; group + 1 < group_begin_.size(); ++group) {
    updates += sweep_group(group, std::max(all, kFewestSweeps), blocks, steps, limits);
  }
  return updates;
}

/// What touches a body that a contact far off touches. @returns whether these contacts are few enough, and any
bool LocalSweeps::choose(const ContactBlocks& blocks) {
  const Index contacts = blocks.contacts();
  const auto is_far = [&](Index c) { return blocks.errors(c) > far_; };
  Index far = 0;
  for (Index c = 0; c < contacts; ++c) far += is_far(c) ? 1 : 0;
  if (far == 0 || kLeastShare * far >= contacts) return false;
  std::fill(group_of_.begin(), group_of_.end(), kNone);
  for (Index c = 0; c < contacts; ++c) {
    if (is_far(c)) blocks.for_each_body(c, [&](std::size_t body) { group_of_[body] = 0; });
  }
  unsorted_.clear();
  for (Index c = 0; c < contacts; ++c) {
    bool is_near = false;
    blocks.for_each_body(c, [&](std::size_t body) { is_near = is_near || group_of_[body] != kNone; });
    if (is_near) unsorted_.push_back(c);
  }
  return !unsorted_.empty();  // else nothing moves what is far off
}

std::size_t LocalSweeps::root_of(std::size_t body) {
  while (parent_[body] != body) {
    parent_[body] = parent_[parent_[body]];
    body = parent_[body];
  }
  return body;
}

/// Contacts that share a body are in one group.
void LocalSweeps::find_groups(const ContactBlocks& blocks) {
  std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  const auto root_of_contact = [&](Index c) {
    std::size_t root = kNone;
    blocks.for_each_body(c, [&](std::size_t body) { root = root == kNone ? root_of(body) : root; });
    return root;
  };
  for (const Index c : unsorted_) {
    const std::size_t root = root_of_contact(c);
    blocks.for_each_body(c, [&](std::size_t body) { parent_[root_of(body)] = root; });
  }
  std::fill(group_of_.begin(), group_of_.end(), kNone);
  group_begin_.assign(1, 0);
  for (const Index c : unsorted_) {
    std::size_t& group = group_of_[root_of_contact(c)];
    if (group == kNone) {
      group = group_begin_.size() - 1;
      group_begin_.push_back(0);
    }
    ++group_begin_[group + 1];
  }
  std::partial_sum(group_begin_.begin(), group_begin_.end(), group_begin_.begin());
  next_.assign(group_begin_.begin(), group_begin_.end() - 1);
  chosen_.resize(unsorted_.size());
  for (const Index c : unsorted_) chosen_[next_[group_of_[root_of_contact(c)]]++] = c;
}

/// At most so many sweeps over one group. @returns updates of a contact
std::int64_t LocalSweeps::sweep_group(std::size_t group, std::int64_t sweeps, ContactBlocks& blocks,
                                      ConjugateSteps& steps, const Limits& limits) {
  const std::span<const Index> contacts(chosen_.data() + group_begin_[group], chosen_.data() + group_begin_[group + 1]);
  rows_.clear();
  coordinates_.clear();
  for (const Index c : contacts) {
    append(blocks.first_row(c), blocks.rows(c), rows_);
    blocks.for_each_body(c, [&](std::size_t body) {
      if (parent_[body] == kNone) return;
      parent_[body] = kNone;  // the trees are used up
      append(blocks.first_coordinate(body), blocks.coordinates(body), coordinates_);
    });
  }
  const ConjugateSteps::Part part{.x = rows_, .u = coordinates_};
  steps.begin(part, blocks.impulses, blocks.velocity);
  std::int64_t updates = 0;
  while (wall_clock_s() < limits.deadline_s) {
    const ContactBlocks::Step step = blocks.sweep(contacts, limits.relaxation);
    updates += static_cast<std::int64_t>(contacts.size());
    if (!(step.off > kReduced * far_) || --sweeps <= 0) break;
    steps.after_sweep(part, step.size, blocks.impulses, blocks.velocity);
  }
  return updates;
}

}  // namespace lcpbench
