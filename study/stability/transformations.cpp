#include "study/stability/transformations.h"

#include <cmath>
#include <utility>
#include <vector>

#include "study/inspect/rigid_bodies.h"
#include "study/stability/contact_changes.h"
#include "study/stability/drawing.h"
#include "study/stability/scene_transformations.h"

namespace lcpbench {
namespace {

constexpr int kLargestExponent = 10;

Problem changed(const Problem& problem, const std::function<void(ContactProblem&)>& change) {
  ContactProblem contact = *problem.contact();
  change(contact);
  return Problem(problem.name(), std::move(contact), problem.formation());
}

Problem changed(const Problem& problem, const std::function<void(Lcp&)>& change) {
  Lcp lcp = problem.lcp();
  change(lcp);
  return Problem(problem.name(), std::move(lcp));
}

Vector powers_of_two(DrawSequence& draws, Index count) {
  Vector factors(count);
  for (double& factor : factors) {
    factor = std::ldexp(1.0, static_cast<int>(draws.integer(-kLargestExponent, kLargestExponent)));
  }
  return factors;
}

Transformation row_scaling(const Problem& problem, DrawSequence& draws) {
  const Vector factors = powers_of_two(draws, problem.size());
  const auto scale = [](const Problem& p, const Vector& by) {
    return changed(p, [&](Lcp& lcp) {
      lcp.M = by.asDiagonal() * lcp.M;
      lcp.q = by.cwiseProduct(lcp.q);
    });
  };
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) { return scale(p, factors); };
  result.undo = [=](const Problem& p) { return scale(p, factors.cwiseInverse()); };
  return result;
}

Transformation column_scaling(const Problem& problem, DrawSequence& draws) {
  const Vector factors = powers_of_two(draws, problem.size());
  const auto scale = [](const Problem& p, const Vector& by) {
    return changed(p, [&](Lcp& lcp) { lcp.M = lcp.M * by.asDiagonal(); });
  };
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) { return scale(p, factors); };
  result.undo = [=](const Problem& p) { return scale(p, factors.cwiseInverse()); };
  result.unknowns_back = [=](const Vector& z) { return Vector(factors.cwiseProduct(z)); };
  return result;
}

Transformation contact_scaling(const Problem& problem, DrawSequence& draws) {
  const Vector factors = powers_of_two(draws, problem.contact()->nc());
  const auto scale = [](const Problem& p, const Vector& by) {
    return changed(p, [&](ContactProblem& contact) { scale_contacts(contact, by); });
  };
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) { return scale(p, factors); };
  result.undo = [=](const Problem& p) { return scale(p, factors.cwiseInverse()); };
  return result;
}

/// Products by 1,000 are rounded: a singular G* would change its rank.
bool is_singular_inverse(const Inertia& inertia) {
  return std::holds_alternative<InverseInertia>(inertia) && !has_definite_inertia(inertia);
}

std::optional<Transformation> mass_unit(const Problem& problem) {
  if (is_singular_inverse(problem.contact()->inertia)) return std::nullopt;
  Transformation result = with_answers_as_they_are();
  result.apply = [](const Problem& p) {
    return changed(p, [](ContactProblem& contact) { change_inertia(contact.inertia, times(kUnit), over(kUnit)); });
  };
  result.undo = [](const Problem& p) {
    return changed(p, [](ContactProblem& contact) { change_inertia(contact.inertia, over(kUnit), times(kUnit)); });
  };
  return result;
}

/// Where the inertia is not that of rigid bodies, every coordinate counts as a length.
std::optional<Transformation> length_unit(const Problem& problem) {
  if (is_singular_inverse(problem.contact()->inertia)) return std::nullopt;
  const bool bodies = !rigid_bodies(problem.contact()->inertia).empty();
  const auto scale = [bodies](const Problem& p, const EntryChange& multiply, const EntryChange& divide) {
    return changed(p, [&](ContactProblem& contact) {
      if (bodies) {
        change_length_of_bodies(contact, multiply, divide);
      } else {
        contact.v = contact.v.unaryExpr(multiply).eval();
        contact.b = contact.b.unaryExpr(multiply).eval();
      }
    });
  };
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) { return scale(p, times(kUnit), over(kUnit)); };
  result.undo = [=](const Problem& p) { return scale(p, over(kUnit), times(kUnit)); };
  if (bodies) {
    result.velocity_back = linear_velocities_over_unit;
  } else {
    result.velocity_back = [](const Vector& velocity) { return Vector(velocity / kUnit); };
  }
  return result;
}

std::optional<Transformation> permutation(const Problem& problem, DrawSequence& draws) {
  const bool bare = problem.contact() == nullptr;
  const Index count = bare ? problem.size() : problem.contact()->nc();
  if (count < 2) return std::nullopt;
  const std::vector<Index> order = shuffled(draws, count);
  const std::vector<Index> inverse = inverse_order(order);
  const auto permute = [bare](const Problem& p, const std::vector<Index>& by) {
    if (!bare) return changed(p, [&](ContactProblem& contact) { select_contacts(contact, by); });
    return changed(p, [&](Lcp& lcp) {
      lcp.M = Matrix(lcp.M(by, by));
      lcp.q = Vector(lcp.q(by));
    });
  };
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) { return permute(p, order); };
  result.undo = [=](const Problem& p) { return permute(p, inverse); };
  result.unknowns_back = [=](const Vector& z) { return Vector(z(inverse)); };
  return result;
}

std::optional<Transformation> direction_order(const Problem& problem, DrawSequence& draws) {
  if (!problem.contact()->frictional()) return std::nullopt;
  std::vector<int> forward;
  std::vector<int> backward;
  for (const int edges : problem.contact()->edges) {
    const int shift = edges > 1 ? static_cast<int>(draws.integer(1, edges - 1)) : 0;
    forward.push_back(shift);
    backward.push_back(edges - shift);
  }
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) {
    return changed(p, [&](ContactProblem& contact) { shift_directions(contact, forward); });
  };
  result.undo = [=](const Problem& p) {
    return changed(p, [&](ContactProblem& contact) { shift_directions(contact, backward); });
  };
  return result;
}

/// Entries of the column times 1 + sign 2^-30. Not one factor: the direction is to change.
Vector nearby(const Vector& column, DrawSequence& draws) {
  Vector result = column;
  for (double& entry : result) entry *= 1 + (draws.integer(0, 1) == 0 ? -kNearby : kNearby);
  return result;
}

std::optional<Transformation> duplicate(const Problem& problem, DrawSequence& draws, bool near) {
  const ContactProblem& contact = *problem.contact();
  if (contact.nc() == 0) return std::nullopt;
  const Index chosen = draws.integer(0, contact.nc() - 1);
  const auto begin = contact_layout(contact).friction_begin[static_cast<std::size_t>(chosen)];
  Vector normal = to_dense(contact.N).col(chosen);
  Matrix directions = to_dense(contact.D).middleCols(begin, contact.edges[static_cast<std::size_t>(chosen)] / 2);
  if (near) {
    normal = nearby(normal, draws);
    for (Index t = 0; t < directions.cols(); ++t) directions.col(t) = nearby(directions.col(t), draws);
  }
  std::vector<Index> twice = first_indices(contact.nc());
  twice.push_back(chosen);
  Transformation result = with_answers_as_they_are();
  result.apply = [=](const Problem& p) {
    return changed(p, [&](ContactProblem& c) {
      select_contacts(c, twice);
      move_last_contact(c, normal, directions);
    });
  };
  result.undo = [](const Problem& p) {
    return changed(p, [](ContactProblem& c) { select_contacts(c, first_indices(c.nc() - 1)); });
  };
  result.data_change = near ? kNearby : 0;
  return result;
}

Problem nudged(const Problem& problem, Nudge& nudge) {
  if (problem.contact() == nullptr) {
    return changed(problem, [&](Lcp& lcp) {
      if (lcp.M == lcp.M.transpose()) {
        nudge.symmetric(lcp.M);
      } else {
        nudge.matrix(lcp.M);
      }
      nudge.vector(lcp.q);
    });
  }
  return changed(problem, [&](ContactProblem& contact) { nudge.contact(contact); });
}

std::optional<Transformation> one_ulp(const Problem& problem, const DrawSequence& draws) {
  const auto all_nudged = [draws](bool forth) {
    return [draws, forth](const Problem& p) {
      Nudge nudge(draws, forth);
      return nudged(p, nudge);
    };
  };
  Nudge nudge(draws, true);
  const Problem neighbour = nudged(problem, nudge);
  if (neighbour.contact() != nullptr && !has_definite_inertia(neighbour.contact()->inertia)) return std::nullopt;
  Transformation result = with_answers_as_they_are();
  result.apply = all_nudged(true);
  result.undo = all_nudged(false);
  result.data_change = nudge.largest_change();
  return result;
}

std::optional<Transformation> draw_for_bare(TransformationKind kind, const Problem& problem, DrawSequence& draws) {
  switch (kind) {
    case TransformationKind::kRowScaling: return row_scaling(problem, draws);
    case TransformationKind::kColumnScaling: return column_scaling(problem, draws);
    case TransformationKind::kPermutation: return permutation(problem, draws);
    case TransformationKind::kOneUlp: return one_ulp(problem, draws);
    default: return std::nullopt;
  }
}

std::optional<Transformation> draw_for_contacts(TransformationKind kind, const Problem& problem, DrawSequence& draws) {
  switch (kind) {
    case TransformationKind::kContactScaling: return contact_scaling(problem, draws);
    case TransformationKind::kMassUnit: return mass_unit(problem);
    case TransformationKind::kLengthUnit: return length_unit(problem);
    case TransformationKind::kPermutation: return permutation(problem, draws);
    case TransformationKind::kDirectionOrder: return direction_order(problem, draws);
    case TransformationKind::kDuplicate: return duplicate(problem, draws, false);
    case TransformationKind::kNearDuplicate: return duplicate(problem, draws, true);
    case TransformationKind::kOneUlp: return one_ulp(problem, draws);
    default: return std::nullopt;
  }
}

}  // namespace

const char* to_string(TransformationKind kind) {
  switch (kind) {
    case TransformationKind::kRowScaling: return "row_scaling";
    case TransformationKind::kColumnScaling: return "column_scaling";
    case TransformationKind::kContactScaling: return "contact_scaling";
    case TransformationKind::kMassUnit: return "kg_to_g";
    case TransformationKind::kLengthUnit: return "m_to_mm";
    case TransformationKind::kPermutation: return "permutation";
    case TransformationKind::kDirectionOrder: return "direction_order";
    case TransformationKind::kDuplicate: return "duplicate";
    case TransformationKind::kNearDuplicate: return "near_duplicate";
    case TransformationKind::kOneUlp: break;
  }
  return "one_ulp";
}

bool perturbs(TransformationKind kind) {
  return kind == TransformationKind::kNearDuplicate || kind == TransformationKind::kOneUlp;
}

std::optional<Transformation> draw_transformation(TransformationKind kind, const Problem& problem, const TrialKey& key,
                                                  std::uint64_t attempt) {
  DrawSequence draws(key, Purpose::kTransformation, attempt);
  if (problem.scene() != nullptr && is_of_scenes(kind)) return draw_for_scene(kind, draws, *problem.scene());
  return problem.contact() == nullptr ? draw_for_bare(kind, problem, draws) : draw_for_contacts(kind, problem, draws);
}

}  // namespace lcpbench
