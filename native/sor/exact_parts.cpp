#include "native/sor/exact_parts.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "core/timed_solve.h"

namespace lcpbench {
namespace {

// Measured on piles of spheres, see docs/reference/solvers/psor.md.

/// A contact or a part is off most if it is off by more than this part of the largest.
constexpr double kFarOfLargest = 0.5;
/// Contacts of a new part; parts that are still off grow by half, up to the largest.
constexpr std::size_t kContacts = 40;
constexpr std::size_t kMostContacts = 300;
/// Of the way to a part's answer. With whole steps neighbouring parts may undo each other's answers in a cycle.
constexpr double kShareOfStep = 0.5;
/// Over the other contacts, for each solution of the parts.
constexpr int kSweepsOfOthers = 5;
/// Units of psor's work in one of contact_lemke's; sums of such multiples have no rounding.
constexpr double kWorkOfPart = 0.375;
/// Of contact_lemke in one sweep of a part: more than most take, and a small part of what all its paths might.
constexpr std::int64_t kFewestPivots = 300;
constexpr std::int64_t kPivotsPerContact = 8;

}  // namespace

void ExactParts::load(const ContactBlocks& blocks) {
  if (later_ == nullptr) later_ = std::make_shared<LaterEngines>();
  const auto contacts = static_cast<std::size_t>(blocks.contacts());
  part_of_.assign(contacts, kNone);
  clear();
  is_chosen_.assign(contacts, 0);
  place_.assign(static_cast<std::size_t>(blocks.velocity.size()), -1);
  entries_ = blocks.entries();
  Index impulses = 1;  // of a contact, as contact_lemke counts: normal, edges, and one for the friction cone
  for (Index c = 0; c < blocks.contacts(); ++c) impulses = std::max(impulses, 2 * blocks.rows(c));
  most_contacts_ = static_cast<std::size_t>(ContactLemke::kCapabilities.max_size / impulses);
  begin_.assign(blocks.bodies() + 1, 0);
  for (Index c = 0; c < blocks.contacts(); ++c) {
    blocks.for_each_body(c, [&](std::size_t body) { ++begin_[body + 1]; });
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  at_body_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (Index c = 0; c < blocks.contacts(); ++c) {
    blocks.for_each_body(c, [&](std::size_t body) { at_body_[next[body]++] = c; });
  }
}

void ExactParts::clear() {
  parts_.clear();
  std::fill(part_of_.begin(), part_of_.end(), kNone);
}

/// visit(other) for each contact at a body of this one, itself included.
template <class Visit>
void ExactParts::for_each_neighbour(const ContactBlocks& blocks, Index contact, Visit&& visit) const {
  blocks.for_each_body(contact, [&](std::size_t body) {
    for (std::size_t k = begin_[body]; k < begin_[body + 1]; ++k) visit(at_body_[k]);
  });
}

/// Adds to chosen_ the nearest contacts that are in no part, until it has this many.
void ExactParts::grow(const ContactBlocks& blocks, std::size_t contacts) {
  contacts = std::min(contacts, most_contacts_);
  for (const Index c : chosen_) is_chosen_[static_cast<std::size_t>(c)] = 1;
  for (std::size_t k = 0; k < chosen_.size() && chosen_.size() < contacts; ++k) {
    for_each_neighbour(blocks, chosen_[k], [&](Index c) {
      char& is_chosen = is_chosen_[static_cast<std::size_t>(c)];
      if (is_chosen != 0 || is_in_part(c) || chosen_.size() >= contacts) return;
      is_chosen = 1;
      chosen_.push_back(c);
    });
  }
  for (const Index c : chosen_) is_chosen_[static_cast<std::size_t>(c)] = 0;
}

/// Of the chosen contacts, in place of the part that had this number.
void ExactParts::add_part(std::size_t number) {
  auto part = std::make_unique<Part>(later_);
  part->contacts = chosen_;
  std::sort(part->contacts.begin(), part->contacts.end());
  for (const Index c : chosen_) part_of_[static_cast<std::size_t>(c)] = number;
  if (number == parts_.size()) parts_.emplace_back();
  parts_[number] = std::move(part);
}

/// A part with a contact at a body of this one.
std::size_t ExactParts::part_beside(const ContactBlocks& blocks, Index contact) const {
  std::size_t found = kNone;
  for_each_neighbour(blocks, contact, [&](Index c) {
    if (is_in_part(c)) found = part_of_[static_cast<std::size_t>(c)];
  });
  return found;
}

void ExactParts::extend(ContactBlocks& blocks) {
  if (most_contacts_ == 0) return list_others(blocks);
  double far = blocks.errors.maxCoeff();
  for (const auto& part : parts_) far = std::max(far, part->off);
  far *= kFarOfLargest;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const Part& part = *parts_[k];
    if (!(part.off > far) || part.contacts.size() > kMostContacts || part.contacts.size() >= most_contacts_) continue;
    chosen_ = part.contacts;
    grow(blocks, chosen_.size() + chosen_.size() / 2);
    add_part(k);
  }
  for (Index c = 0; c < blocks.contacts(); ++c) {
    if (!(blocks.errors(c) > far) || is_in_part(c)) continue;
    const std::size_t beside = part_beside(blocks, c);
    const bool joins = beside != kNone && parts_[beside]->contacts.size() < kMostContacts &&
                       parts_[beside]->contacts.size() + kContacts <= most_contacts_;
    chosen_.assign(1, c);
    grow(blocks, kContacts);
    if (joins) chosen_.insert(chosen_.end(), parts_[beside]->contacts.begin(), parts_[beside]->contacts.end());
    add_part(joins ? beside : parts_.size());
  }
  list_others(blocks);
}

void ExactParts::list_others(ContactBlocks& blocks) {
  others_.clear();
  for (Index c = 0; c < blocks.contacts(); ++c) {
    if (is_in_part(c)) {
      blocks.errors(c) = 0;
    } else {
      others_.push_back(c);
    }
  }
}

/// Of the bodies of the part, without the impulses of its contacts.
void ExactParts::find_velocity(const ContactBlocks& blocks, Part& part) {
  const auto size = static_cast<Index>(part.coordinates.size());
  part.v.resize(size);
  for (Index i = 0; i < size; ++i) {
    const Index coordinate = part.coordinates[static_cast<std::size_t>(i)];
    part.v(i) = blocks.velocity(coordinate);
    place_[static_cast<std::size_t>(coordinate)] = i;
  }
  for (const Index c : part.contacts) {
    const double* const impulses = blocks.impulses.data() + blocks.first_row(c);
    blocks.for_each_entry(c, [&](Index row, Index coordinate, double entry) {
      part.v(place_[static_cast<std::size_t>(coordinate)]) -= entry * impulses[row];
    });
  }
}

void ExactParts::load(const ContactBlocks& blocks, Part& part) {
  std::vector<std::size_t> bodies;
  Index directions = 0;
  for (const Index c : part.contacts) {
    blocks.for_each_body(c, [&](std::size_t body) { bodies.push_back(body); });
    directions += blocks.rows(c) - 1;
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  BlockInertia inertia;
  for (const std::size_t body : bodies) {
    const Index size = blocks.coordinates(body);
    inertia.blocks.emplace_back(Matrix::Identity(size, size));
    for (Index i = 0; i < size; ++i) part.coordinates.push_back(blocks.first_coordinate(body) + i);
  }
  find_velocity(blocks, part);
  const auto nc = static_cast<Index>(part.contacts.size());
  ContactProblem contact{.v = part.v, .N = {}, .D = {}, .edges = {}, .mu = Vector(nc), .inertia = std::move(inertia)};
  Matrix N = Matrix::Zero(part.v.size(), nc);
  Matrix D = Matrix::Zero(part.v.size(), 2 * directions);
  if (blocks.has_offset()) contact.b.resize(nc);
  if (blocks.is_soft()) {
    for (Vector* each : {&contact.compliance_n, &contact.compliance_t}) each->resize(nc);
    contact.offset_t.resize(2 * nc);
  }
  Index column = 0;
  for (Index k = 0; k < nc; ++k) {
    const Index c = part.contacts[static_cast<std::size_t>(k)];
    const Index own = blocks.rows(c) - 1;
    blocks.for_each_entry(c, [&](Index row, Index coordinate, double entry) {
      const Index place = place_[static_cast<std::size_t>(coordinate)];
      if (row == 0) {
        N(place, k) = entry;
      } else {
        D(place, column + row - 1) = entry;
        D(place, column + own + row - 1) = -entry;
      }
    });
    contact.edges.push_back(static_cast<int>(2 * own));
    contact.mu(k) = own > 0 ? blocks.mu(c) : 0.0;
    if (blocks.has_offset()) contact.b(k) = blocks.offset(c);
    if (blocks.is_soft()) {
      contact.compliance_n(k) = blocks.softness(c).normal;
      contact.compliance_t(k) = own > 0 ? blocks.softness(c).tangential : 0.0;
      contact.offset_t.segment<2>(2 * k) = blocks.softness(c).offset;
    }
    column += 2 * own;
  }
  contact.N = std::move(N);
  contact.D = std::move(D);
  part.problem = Problem("part", std::move(contact));
  part.solver.load(part.problem);
  part.solver.limit_pivots(kFewestPivots + kPivotsPerContact * nc);
  part.is_loaded = true;
}

/// Solves the part's problem by contact_lemke.
void ExactParts::solve(const ContactBlocks& blocks, double deadline_s, Part& part) {
  double pivots = 1;  // what loading or updating takes, as so many
  if (part.is_loaded) {
    find_velocity(blocks, part);
    part.solver.update(part.v);
  } else {
    load(blocks, part);
    work_ += kWorkOfPart * ContactLemke::load_work(part.problem, 0);
    pivots = static_cast<double>(part.contacts.size());
  }
  part.solver.solve_within({.deadline_s = deadline_s}, part.answer);
  work_ += kWorkOfPart * part.solver.work();
  pivots += static_cast<double>(std::max<std::int64_t>(part.answer.counters.pivots, 0));
  multiplications_ += 2 * pivots * static_cast<double>(part.v.size() * part.v.size());
}

/// Goes to the answer by the share of a step. Sets Part::off.
void ExactParts::take_answer(ContactBlocks& blocks, Part& part) {
  const Vector& z = part.answer.z;
  Vector steps;
  auto column = static_cast<Index>(part.contacts.size());
  part.off = 0;
  for (std::size_t k = 0; k < part.contacts.size(); ++k) {
    const Index c = part.contacts[k];
    const Index own = blocks.rows(c) - 1;
    steps.resize(1 + own);
    steps(0) = z(static_cast<Index>(k));
    for (Index t = 0; t < own; ++t) steps(1 + t) = z(column + t) - z(column + own + t);
    steps -= blocks.impulses.segment(blocks.first_row(c), 1 + own);
    for (Index row = 0; row <= own; ++row) {
      part.off = std::max(part.off, blocks.curvature(c, row) * std::abs(steps(row)));
    }
    steps *= kShareOfStep;
    blocks.add(c, steps.data());
    column += 2 * own;
  }
}

/// Removes a part: from now on its contacts are swept. The last part takes its number.
void ExactParts::give_back(std::size_t number) {
  for (const Index c : parts_[number]->contacts) part_of_[static_cast<std::size_t>(c)] = kNone;
  if (number + 1 < parts_.size()) std::swap(parts_[number], parts_.back());
  parts_.pop_back();
  if (number == parts_.size()) return;
  for (const Index c : parts_[number]->contacts) part_of_[static_cast<std::size_t>(c)] = number;
}

ContactBlocks::Step ExactParts::sweep(ContactBlocks& blocks, double relaxation, double deadline_s) {
  work_ = kSweepsOfOthers * blocks.work();
  multiplications_ = kSweepsOfOthers * 2 * static_cast<double>(entries_);
  double off = 0;
  bool gives_back = false;
  for (std::size_t at = 0; at < parts_.size();) {
    Part& part = *parts_[at];
    solve(blocks, deadline_s, part);
    if (part.answer.claim == Claim::kSolved) {
      take_answer(blocks, part);
      off = std::max(off, part.off);
      ++at;
    } else {
      gives_back = true;
      give_back(at);
    }
  }
  if (gives_back) list_others(blocks);
  ContactBlocks::Step step;
  for (int k = 0; k < kSweepsOfOthers; ++k) step = blocks.sweep(others_, relaxation);
  step.off = std::max(step.off, off);
  return step;
}

}  // namespace lcpbench
