#include "study/shrink/pieces.h"

#include <algorithm>
#include <utility>

#include "core/selection.h"

namespace lcpbench {
namespace {

bool is_kept(const std::vector<Index>& kept, Index index) {
  return std::binary_search(kept.begin(), kept.end(), index);
}

RigidScene bodies_of(const RigidScene& scene, const std::vector<Index>& kept) {
  const auto moved = [&](int body) {
    return is_kept(kept, body) ? static_cast<int>(std::lower_bound(kept.begin(), kept.end(), body) - kept.begin())
                               : RigidContact::kWorld;
  };
  RigidScene part;
  for (const Index body : kept) part.bodies.push_back(scene.bodies[static_cast<std::size_t>(body)]);
  for (RigidContact contact : scene.contacts) {
    contact.body_a = moved(contact.body_a);
    contact.body_b = moved(contact.body_b);
    if (contact.body_a == RigidContact::kWorld && contact.body_b == RigidContact::kWorld) continue;
    if (contact.body_a == RigidContact::kWorld) {  // the world is always the second
      std::swap(contact.body_a, contact.body_b);
      contact.normal = Eigen::Vector3d::Zero() - contact.normal;  // no negative zeros
      contact.tangent = Eigen::Vector3d::Zero() - contact.tangent;
    }
    part.contacts.push_back(contact);
  }
  return part;
}

Problem renewed(const Problem& problem, ContactProblem contact) { return {problem.name(), std::move(contact)}; }

}  // namespace

Index contact_count(const Problem& problem) {
  return problem.contact() != nullptr ? problem.contact()->nc() : problem.size();
}

Problem with_contacts(const Problem& problem, const std::vector<Index>& kept) {
  if (const RigidScene* scene = problem.scene()) {
    RigidScene part{scene->bodies, {}};
    for (const Index contact : kept) part.contacts.push_back(scene->contacts[static_cast<std::size_t>(contact)]);
    return {problem.name(), std::move(part)};
  }
  if (problem.contact() != nullptr) return renewed(problem, select_contacts(*problem.contact(), kept));
  const Lcp& lcp = problem.lcp();
  return {problem.name(), Lcp{lcp.M(kept, kept), lcp.q(kept), lcp.bounds.of_rows(kept)}};
}

Index row_count(const Problem& problem) {
  return problem.contact() != nullptr ? problem.contact()->rows.size() : 0;
}

Problem with_rows(const Problem& problem, const std::vector<Index>& kept) {
  const std::vector<int>& friction_of = problem.contact()->rows.bounds.friction_of;
  std::vector<Index> borne;
  for (const Index row : kept) {
    const int of = friction_of[static_cast<std::size_t>(row)];
    if (of < 0 || is_kept(kept, of)) borne.push_back(row);
  }
  return renewed(problem, select_rows(*problem.contact(), borne));
}

Index body_count(const Problem& problem) {
  if (problem.scene() != nullptr) return static_cast<Index>(problem.scene()->bodies.size());
  return problem.contact() != nullptr ? problem.contact()->ngc() : 0;
}

Problem with_bodies(const Problem& problem, const std::vector<Index>& kept) {
  if (const RigidScene* scene = problem.scene()) return {problem.name(), bodies_of(*scene, kept)};
  return renewed(problem, select_coordinates(*problem.contact(), kept));
}

Index factor_count(const Problem& problem) {
  if (problem.kind() != ProblemKind::kContact) return 0;
  const auto* factored = std::get_if<FactoredInertia>(&problem.contact()->inertia);
  return factored != nullptr ? factored->alpha.size() : 0;
}

Problem with_factors(const Problem& problem, const std::vector<Index>& kept) {
  ContactProblem part = *problem.contact();
  const auto& factored = std::get<FactoredInertia>(problem.contact()->inertia);
  part.inertia = FactoredInertia{factored.X(Eigen::all, kept), factored.alpha(kept)};
  return renewed(problem, std::move(part));
}

std::vector<Index> frictional_contacts(const Problem& problem) {
  std::vector<Index> contacts;
  if (problem.contact() == nullptr) return contacts;
  for (Index i = 0; i < problem.contact()->nc(); ++i) {
    if (problem.contact()->edges[static_cast<std::size_t>(i)] > 0) contacts.push_back(i);
  }
  return contacts;
}

Problem with_friction(const Problem& problem, const std::vector<Index>& kept) {
  if (const RigidScene* scene = problem.scene()) {
    RigidScene part = *scene;
    for (std::size_t i = 0; i < part.contacts.size(); ++i) {
      if (is_kept(kept, static_cast<Index>(i))) continue;
      part.contacts[i].edges = 0;
      part.contacts[i].mu = part.contacts[i].compliance_t = 0;
      part.contacts[i].offset_t.setZero();
    }
    return {problem.name(), std::move(part)};
  }
  ContactProblem part = *problem.contact();
  part.D = part_of(part.D, all_indices(part.ngc()), directions_of(part, kept));
  for (Index i = 0; i < part.nc(); ++i) {
    if (is_kept(kept, i)) continue;
    part.edges[static_cast<std::size_t>(i)] = 0;
    part.mu(i) = 0;
    if (part.compliance_t.size() > 0) part.compliance_t(i) = 0;
    if (part.offset_t.size() > 0) part.offset_t.segment<2>(2 * i).setZero();
  }
  return renewed(problem, std::move(part));
}

std::vector<Index> contacts_of_many_edges(const Problem& problem) {
  std::vector<Index> contacts;
  if (problem.kind() != ProblemKind::kContact) return contacts;
  for (const Index i : frictional_contacts(problem)) {
    if (problem.contact()->edges[static_cast<std::size_t>(i)] > 2) contacts.push_back(i);
  }
  return contacts;
}

Problem with_fewer_edges(const Problem& problem, const std::vector<Index>& kept) {
  ContactProblem part = *problem.contact();
  const ContactLayout layout = contact_layout(part);
  std::vector<Index> directions;
  for (Index i = 0; i < part.nc(); ++i) {
    int& edges = part.edges[static_cast<std::size_t>(i)];
    const int apart = edges <= 2 || is_kept(kept, i) ? 1 : edges % 4 == 0 ? 2 : edges / 2;
    for (int t = 0; t < edges; t += apart) {
      directions.push_back(layout.friction_begin[static_cast<std::size_t>(i)] + t);
    }
    edges /= apart;
  }
  part.D = part_of(part.D, all_indices(part.ngc()), directions);
  return renewed(problem, std::move(part));
}

}  // namespace lcpbench
