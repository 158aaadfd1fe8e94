#include "study/stability/scene_transformations.h"

#include <functional>
#include <utility>
#include <vector>

#include "study/stability/drawing.h"

namespace lcpbench {
namespace {

using SceneChange = std::function<void(RigidScene&)>;

Transformation of_changes(const SceneChange& apply, const SceneChange& undo) {
  const auto changed = [](const SceneChange& change) {
    return [change](const Problem& problem) {
      RigidScene scene = *problem.scene();
      change(scene);
      return Problem(problem.name(), std::move(scene));
    };
  };
  Transformation result = with_answers_as_they_are();
  result.apply = changed(apply);
  result.undo = changed(undo);
  return result;
}

template <class Entries>
void each_entry(Entries& entries, const EntryChange& change) {
  entries = entries.unaryExpr(change).eval();
}

Transformation mass_unit() {
  const auto scale = [](RigidScene& scene, const EntryChange& change) {
    for (RigidBody& body : scene.bodies) {
      body.mass = change(body.mass);
      each_entry(body.inertia, change);
    }
  };
  return of_changes([=](RigidScene& scene) { scale(scene, times(kUnit)); },
                    [=](RigidScene& scene) { scale(scene, over(kUnit)); });
}

Transformation length_unit() {
  const auto scale = [](RigidScene& scene, const EntryChange& change) {
    for (RigidBody& body : scene.bodies) {
      each_entry(body.inertia, change);
      each_entry(body.inertia, change);
      each_entry(body.position, change);
      each_entry(body.linear_velocity, change);
    }
    for (RigidContact& contact : scene.contacts) {
      each_entry(contact.point, change);
      contact.b = change(contact.b);
    }
  };
  Transformation result = of_changes([=](RigidScene& scene) { scale(scene, times(kUnit)); },
                                     [=](RigidScene& scene) { scale(scene, over(kUnit)); });
  result.velocity_back = linear_velocities_over_unit;
  return result;
}

std::optional<Transformation> permutation(DrawSequence& draws, const RigidScene& scene) {
  if (scene.contacts.size() < 2) return std::nullopt;
  const std::vector<Index> order = shuffled(draws, static_cast<Index>(scene.contacts.size()));
  const auto permute = [](RigidScene& changed, const std::vector<Index>& by) {
    std::vector<RigidContact> contacts;
    for (const Index i : by) contacts.push_back(changed.contacts[static_cast<std::size_t>(i)]);
    changed.contacts = std::move(contacts);
  };
  return of_changes([=](RigidScene& changed) { permute(changed, order); },
                    [=](RigidScene& changed) { permute(changed, inverse_order(order)); });
}

/// A near duplicate touches at another point: normals stay of length 1.
std::optional<Transformation> duplicate(DrawSequence& draws, const RigidScene& scene, bool near) {
  if (scene.contacts.empty()) return std::nullopt;
  const auto chosen = static_cast<std::size_t>(draws.integer(0, static_cast<std::int64_t>(scene.contacts.size()) - 1));
  RigidContact second = scene.contacts[chosen];
  for (Index i = 0; i < 3 && near; ++i) second.point(i) *= 1 + (draws.integer(0, 1) == 0 ? -kNearby : kNearby);
  Transformation result = of_changes([=](RigidScene& changed) { changed.contacts.push_back(second); },
                                     [](RigidScene& changed) { changed.contacts.pop_back(); });
  result.data_change = near ? kNearby : 0;
  return result;
}

template <class Triple>
void nudge_triple(Triple& triple, Nudge& nudge) {
  for (Index i = 0; i < 3; ++i) nudge(triple(i));
}

/// Directions are left alone: their lengths and angles are data too.
void nudge_scene(RigidScene& scene, Nudge& nudge) {
  for (RigidBody& body : scene.bodies) {
    nudge(body.mass);
    Matrix inertia = body.inertia;
    nudge.symmetric(inertia);
    body.inertia = inertia;
    nudge_triple(body.position, nudge);
    nudge_triple(body.linear_velocity, nudge);
    nudge_triple(body.angular_velocity, nudge);
  }
  for (RigidContact& contact : scene.contacts) {
    nudge_triple(contact.point, nudge);
    nudge(contact.mu);
    nudge(contact.b);
  }
}

std::optional<Transformation> one_ulp(const DrawSequence& draws, const RigidScene& scene) {
  const auto all_nudged = [draws](bool forth) {
    return [draws, forth](RigidScene& changed) {
      Nudge nudge(draws, forth);
      nudge_scene(changed, nudge);
    };
  };
  Nudge nudge(draws, true);
  RigidScene neighbour = scene;
  nudge_scene(neighbour, nudge);
  if (!has_definite_inertia(contact_problem(neighbour).inertia)) return std::nullopt;
  Transformation result = of_changes(all_nudged(true), all_nudged(false));
  result.data_change = nudge.largest_change();
  return result;
}

}  // namespace

bool is_of_scenes(TransformationKind kind) {
  switch (kind) {
    case TransformationKind::kMassUnit:
    case TransformationKind::kLengthUnit:
    case TransformationKind::kPermutation:
    case TransformationKind::kDuplicate:
    case TransformationKind::kNearDuplicate:
    case TransformationKind::kOneUlp: return true;
    default: return false;
  }
}

std::optional<Transformation> draw_for_scene(TransformationKind kind, DrawSequence& draws, const RigidScene& scene) {
  switch (kind) {
    case TransformationKind::kMassUnit: return mass_unit();
    case TransformationKind::kLengthUnit: return length_unit();
    case TransformationKind::kPermutation: return permutation(draws, scene);
    case TransformationKind::kDuplicate: return duplicate(draws, scene, false);
    case TransformationKind::kNearDuplicate: return duplicate(draws, scene, true);
    default: return one_ulp(draws, scene);
  }
}

}  // namespace lcpbench
