#include "native/auto/plan.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "native/answer_test/contact_solvability.h"
#include "native/auto/held_contacts.h"
#include "native/auto/islands.h"
#include "native/auto/separator.h"
#include "native/contact_lemke/contact_lemke.h"

namespace lcpbench {
namespace {

// Sizes of an island: contacts times coordinates. docs/reference/solvers/auto.md has the measurements.

/// Below this the ladder of contact_lemke takes less time than friction_ipm.
constexpr Index kSmall = 400;
/// From this on friction_ipm is faster than contact_lemke where contacts do not slide. Below it contact_lemke that is
/// loaded takes less time than to try whether the contacts of the last step hold.
constexpr Index kLarge = 800;
/// Below this contact_lemke takes less time than that to be loaded, too: of separate bodies, and of one block of G,
/// such as a robot's.
constexpr Index kHeldUnloaded = 100;
constexpr Index kHeldUnloadedBlock = 30;
/// From this on the first convex problem of friction_ipm finds the impulses of least energy faster than active sets.
constexpr Index kRestByIpm = 5000;
/// Contacts that do not slide take friction_ipm one convex problem, or two. Of stacks it may take one for so much of
/// the size, a third of the time of contact_lemke.
constexpr Index kBriefRounds = 2;
constexpr Index kSizePerRound = 1000;
/// From this on friction_ipm takes less time than contact_lemke on stacks that slide.
constexpr Index kSlidingStack = 2000;
/// From this on psor takes less time than the rungs of contact_lemke beyond double.
constexpr Index kHuge = 8000;
/// From this on friction_ipm takes less time than contact_lemke where contacts slide, too.
constexpr Index kByIpm = 20'000;

/// Slip ratio up to which friction holds most islands, and above which it holds hardly any. Contacts of a grip press
/// more than they approach.
constexpr double kLittleSlip = 0.5;
constexpr double kMostSlip = 16;
/// Of s the separator's coordinates and nc contacts: s^3 / nc times this is a third of the sparse method's time in
/// sweeps.
constexpr double kSweepsPerCube = 0.15;
/// A pile takes so many sweeps for each decimal digit of the error, or more.
constexpr double kSweepsPerDigit = 8;
constexpr double kMostSweeps = 10000;
/// Of ngc coordinates of a pile with friction: ngc^2 times this, if that is more than ngc, is a third of
/// contact_lemke's time in sweeps.
constexpr double kSweepsPerSquare = 1.0 / 32;
/// Of a size from kRestByIpm up to this, walls with friction take so many sweeps for each digit, and less time than
/// friction_ipm takes beyond its first convex problems.
constexpr Index kLargestSweptWall = 100'000;
constexpr std::int64_t kWallSweepsPerDigit = 225;
/// Where an error is stated, piles take at most so many sweeps for each coordinate, or contact_lemke is as fast.
constexpr std::int64_t kSweepsPerCoordinate = 6;
/// Up to this redundancy() bodies are a pile then if they slide faster than kPileSlip, or if the error is at least
/// kLooseError; if it is, large ones are a pile below kStackRedundancy.
constexpr double kLoosePileRedundancy = 1.6;
constexpr double kPileSlip = 2;
constexpr double kLooseError = 1e-7;
constexpr Index kLargePile = 3000;
/// Where the stated error is at least this, those of size kSmall or more take a sweep for each coordinate.
constexpr double kRoughError = 1e-3;
/// Up to this redundancy() sliding bodies are a pile rather than a stack, a wall or a box on the ground.
constexpr double kPileRedundancy = 1.25;
/// That of boxes on boxes, of which each rests on one; in a wall on two.
constexpr double kStackRedundancy = 2;

/// ngc (ngc + nc) of a problem up to which memory is taken in advance: half a gigabyte of addresses.
constexpr Index kMostEntries = 1'000'000;

/// max|d'v| over the first half of the directions d of each contact, which the others oppose.
template <class Directions>
double fastest_slip(const ContactProblem& contact, const Directions& D, const Vector& v) {
  double slip = 0;
  Index direction = 0;
  for (const int edges : contact.edges) {
    for (Index t = 0; t < edges / 2; ++t) slip = std::max(slip, std::abs(D.col(direction + t).dot(v)));
    direction += edges;
  }
  return slip;
}

/// The fastest slip, over the largest mu times the fastest approach: friction may hold every contact where that is at
/// most 1.
double slip_ratio(const ContactProblem& contact, const Vector& v) {
  double approach = 0;
  double mu = 0;
  for (Index c = 0; c < contact.nc(); ++c) {
    approach = std::max(approach, -(dot_column(contact.N, c, v) + contact.offset(c)));
    mu = std::max(mu, contact.mu(c));
  }
  const double slip = std::visit([&](const auto& D) { return fastest_slip(contact, D, v); }, contact.D);
  return slip == 0 ? 0 : slip / (mu * approach);
}

/// Normals and tangents over coordinates. Up to 1 the impulses of rest are mostly the only ones, and contact_lemke
/// comes to them. Box on box has 2, a pile of spheres about 1.
/// @param idle coordinates that no contact moves
double redundancy(const ContactProblem& contact, Index idle = 0) {
  Index rows = contact.nc();
  for (Index c = 0; c < contact.nc(); ++c) {
    if (contact.mu(c) > 0) rows += contact.edges[static_cast<std::size_t>(c)] > 0 ? 2 : 0;
  }
  return static_cast<double>(rows) / static_cast<double>(contact.ngc() - idle);
}

bool may_be_singular(const ContactProblem& contact) {
  const bool is_regular =
      std::holds_alternative<BlockInertia>(contact.inertia) || std::holds_alternative<DenseInertia>(contact.inertia);
  return !is_regular && ContactSolvability::is_asked(contact);
}

bool lemke_takes(const Problem& problem) { return problem.size() <= contact_lemke_capabilities({}).max_size; }

bool is_sparse(const ContactProblem& contact) {
  return std::holds_alternative<BlockInertia>(contact.inertia) && std::holds_alternative<SparseMatrix>(contact.N);
}

/// Whether a sparse method comes first: velocity_ipm, or with friction friction_ipm.
bool is_large_scene(const AutoSettings& settings, const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  if (!is_sparse(contact)) return false;
  return contact.frictional() ? problem.size() >= settings.sparse_friction_from : contact.nc() >= settings.sparse_from;
}

AutoPlan frictionless_plan(const AutoSettings& settings, const Problem& problem, std::int64_t sweeps) {
  AutoPlan plan;
  const bool by_interior = is_large_scene(settings, problem);
  if (sweeps > 0) plan.add_sweeps(sweeps, false);
  if (by_interior) plan.add(AutoMethod::kVelocityIpm);
  if (!by_interior || fits_in_advance(AutoMethod::kActiveSet, problem)) plan.add(AutoMethod::kActiveSet);
  if (fits_in_advance(AutoMethod::kContactLemke, problem)) plan.add(AutoMethod::kContactLemke);
  return plan;
}

/// When the impulses of least energy are tried. @param slip slip_ratio
AutoPlan::Rest rest_for(Index size, double slip) {
  const bool may_hold = size >= kLarge && slip <= 1;
  if (slip > kMostSlip || (may_hold && size >= kRestByIpm)) return AutoPlan::Rest::kNotSought;
  return may_hold || slip <= kLittleSlip ? AutoPlan::Rest::kFirst : AutoPlan::Rest::kAfter;
}

double digits_of(const AutoSettings& settings) {
  return -std::log10(settings.error > 0 ? settings.error : kSweptResidual);
}

bool is_pile(const ContactProblem& contact, Index idle = 0) {
  return is_sparse(contact) && redundancy(contact, idle) <= kPileRedundancy;
}

/// Sweeps for a pile with friction: up to a third of the time that contact_lemke takes.
std::int64_t pile_sweeps(Index coordinates) {
  const auto ngc = static_cast<double>(coordinates);
  return static_cast<std::int64_t>(std::min(std::max(ngc, kSweepsPerSquare * ngc * ngc), kMostSweeps));
}

/// Sweeps for a wall with friction; 0: none.
std::int64_t wall_sweeps(const AutoSettings& settings, const ContactProblem& contact) {
  const Index size = contact.nc() * contact.ngc();
  if (!is_sparse(contact) || size < kRestByIpm || size > kLargestSweptWall) return 0;
  if (redundancy(contact) <= kStackRedundancy) return 0;
  return kWallSweepsPerDigit * static_cast<std::int64_t>(std::ceil(digits_of(settings)));
}

/// Whether psor reaches the stated error before contact_lemke does, as a rule, where is_pile() is false.
/// @param rows redundancy @param slip slip_ratio @param size kLarge or more
bool is_loose_pile(const AutoSettings& settings, double rows, double slip, Index size) {
  const bool is_loose = settings.error >= kLooseError;
  if (rows <= kLoosePileRedundancy) return is_loose || (settings.error > 0 && slip > kPileSlip);
  return is_loose && rows < kStackRedundancy && size >= kLargePile;
}

/// Sweeps for an island of size kSmall or more; 0: none. @param slip slip_ratio
std::int64_t sweeps_before_lemke(const AutoSettings& settings, const ContactProblem& contact, double slip, Index idle) {
  if (!is_sparse(contact)) return 0;
  const Index coordinates = contact.ngc() - idle;
  const Index size = contact.nc() * coordinates;
  const double rows = redundancy(contact, idle);
  if (size < kLarge) return settings.error >= kRoughError && rows < kStackRedundancy ? coordinates : 0;
  const std::int64_t by_error = settings.error > 0 ? kSweepsPerCoordinate * coordinates : 0;
  if (is_pile(contact, idle)) return std::max(by_error, pile_sweeps(coordinates));
  return is_loose_pile(settings, rows, slip, size) ? by_error : wall_sweeps(settings, contact);
}

/// Of islands that are not too large for contact_lemke.
AutoPlan frictional_plan(const AutoSettings& settings, const ContactProblem& contact, const Vector& v, Index idle) {
  using enum AutoMethod;
  AutoPlan plan;
  const Index size = contact.nc() * (contact.ngc() - idle);
  const bool is_scene = std::holds_alternative<BlockInertia>(contact.inertia);
  const bool seeks_rest = (is_scene || std::holds_alternative<DenseInertia>(contact.inertia)) &&
                          (size >= kLarge || redundancy(contact, idle) > 1);
  const double slip = seeks_rest || size >= kLarge ? slip_ratio(contact, v) : 0;
  if (seeks_rest) plan.rest = rest_for(size, slip);
  if (size < kLarge && may_be_singular(contact)) {  // only contact_lemke tells what has a solution from what has none
    plan.add(kContactLemke);
    return plan;
  }
  const bool sticks = slip <= 1;
  if (size < kSmall || (!is_scene && (size < kLarge || !sticks))) {
    plan.add(kContactLemke);
    plan.add(kFrictionIpm);
    plan.add_psor(false);
    return plan;
  }
  const bool piles_up = is_pile(contact, idle);
  const std::int64_t sweeps = sweeps_before_lemke(settings, contact, slip, idle);
  if (size >= kLarge) {
    const bool has_one_rest = piles_up && redundancy(contact, idle) <= 1;
    if (has_one_rest) plan.rest = AutoPlan::Rest::kNotSought;
    const bool is_stack = is_sparse(contact) && sweeps == 0 && size >= (sticks ? kRestByIpm : kSlidingStack) &&
                          redundancy(contact, idle) >= kStackRedundancy;
    const bool holds = sticks && !has_one_rest && plan.rest == AutoPlan::Rest::kNotSought;
    if (is_stack || holds) plan.add_rounds(is_stack ? std::max(kBriefRounds, size / kSizePerRound) : kBriefRounds);
  }
  if (sweeps > 0) plan.add_sweeps(sweeps, piles_up);
  if (size < kByIpm) plan.add(kContactLemke, true);
  if (sweeps == 0 && settings.error > 0 && is_sparse(contact) && redundancy(contact, idle) < kStackRedundancy) {
    plan.add_sweeps(kSweepsPerCoordinate * (contact.ngc() - idle), false);
  }
  plan.add(kFrictionIpm);
  if (size >= kHuge) plan.add_psor(piles_up);
  plan.add(kContactLemke);
  if (size < kHuge) plan.add_psor(piles_up);
  return plan;
}

}  // namespace

bool friction_may_hold(const ContactProblem& contact, bool is_loaded) {
  const auto* bodies = std::get_if<BlockInertia>(&contact.inertia);
  const Index unloaded = bodies == nullptr || bodies->blocks.size() == 1 ? kHeldUnloadedBlock : kHeldUnloaded;
  const Index least = is_loaded ? kLarge : unloaded;
  return contact.frictional() && contact.nc() * contact.ngc() >= least && HeldContacts::takes(contact);
}

bool fits_in_advance(AutoMethod method, const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  if (contact.ngc() * (contact.ngc() + contact.nc()) > kMostEntries) return false;
  return method == AutoMethod::kActiveSet || lemke_takes(problem);
}

std::int64_t worthwhile_sweeps(const AutoSettings& settings, const Problem& problem) {
  if (!is_large_scene(settings, problem)) return 0;
  const ContactProblem& contact = *problem.contact();
  const double separator = separator_size(contact);
  const double sweeps = kSweepsPerCube * separator * separator * separator / static_cast<double>(contact.nc());
  if (!(sweeps >= kSweepsPerDigit * digits_of(settings))) return 0;
  return static_cast<std::int64_t>(std::min(sweeps, kMostSweeps));
}

AutoPlan plan_for(const AutoSettings& settings, const Problem& problem, const Vector& v, std::int64_t sweeps,
                  Index idle) {
  using enum AutoMethod;
  const ContactProblem& contact = *problem.contact();
  if (!contact.frictional()) return frictionless_plan(settings, problem, sweeps);
  if (!is_large_scene(settings, problem) && lemke_takes(problem)) return frictional_plan(settings, contact, v, idle);
  AutoPlan plan;
  const bool piles_up = is_pile(contact);
  if (piles_up) {
    plan.add_sweeps(std::max(sweeps, pile_sweeps(contact.ngc())), true);
    plan.add_psor(true);
  } else if (sweeps > 0) {
    plan.add_sweeps(sweeps, false);
  } else if (const std::int64_t of_wall = wall_sweeps(settings, contact); of_wall > 0) {
    plan.add_rounds(kBriefRounds);
    plan.add_sweeps(of_wall, false);
  }
  plan.add(kFrictionIpm);
  if (!fits_in_advance(kContactLemke, problem)) {
    if (!piles_up) plan.add_psor(false);
    return plan;
  }
  const Index size = contact.nc() * contact.ngc();
  if (size >= kHuge) {
    plan.add(kContactLemke, true);
    if (!piles_up) plan.add_psor(false);
  }
  plan.add(kContactLemke);
  if (size < kHuge && !piles_up) plan.add_psor(false);
  return plan;
}

}  // namespace lcpbench
