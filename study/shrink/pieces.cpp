#include "study/shrink/pieces.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/compliance.h"

namespace lcpbench {
namespace {

/// For each index its place among those kept; -1 where it is not.
std::vector<Index> places(Index count, const std::vector<Index>& kept) {
  std::vector<Index> place(static_cast<std::size_t>(count), -1);
  for (std::size_t i = 0; i < kept.size(); ++i) place[static_cast<std::size_t>(kept[i])] = static_cast<Index>(i);
  return place;
}

bool is_kept(const std::vector<Index>& kept, Index index) {
  return std::binary_search(kept.begin(), kept.end(), index);
}

Jacobian part_of(const Jacobian& J, const std::vector<Index>& rows, const std::vector<Index>& columns) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return Matrix((*dense)(rows, columns));
  const auto& sparse = std::get<SparseMatrix>(J);
  const std::vector<Index> row_place = places(sparse.rows(), rows);
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (SparseMatrix::InnerIterator entry(sparse, columns[c]); entry; ++entry) {
      const Index row = row_place[static_cast<std::size_t>(entry.row())];
      if (row >= 0) entries.emplace_back(static_cast<int>(row), static_cast<int>(c), entry.value());
    }
  }
  SparseMatrix part(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  part.setFromTriplets(entries.begin(), entries.end());
  return part;
}

/// The friction directions of these contacts.
std::vector<Index> directions_of(const ContactProblem& problem, const std::vector<Index>& contacts) {
  const ContactLayout layout = contact_layout(problem);
  std::vector<Index> directions;
  for (const Index contact : contacts) {
    const auto i = static_cast<std::size_t>(contact);
    for (Index t = layout.friction_begin[i]; t < layout.friction_begin[i + 1]; ++t) directions.push_back(t);
  }
  return directions;
}

ContactProblem contacts_of(const ContactProblem& problem, const std::vector<Index>& kept) {
  ContactProblem part = problem;
  const std::vector<Index> rows = all(problem.ngc());
  part.N = part_of(problem.N, rows, kept);
  part.D = part_of(problem.D, rows, directions_of(problem, kept));
  part.mu = problem.mu(kept);
  if (problem.has_offset()) part.b = problem.b(kept);
  select_softness(problem, kept, part);
  part.edges.clear();
  for (const Index contact : kept) part.edges.push_back(problem.edges[static_cast<std::size_t>(contact)]);
  return part;
}

Lcp rows_of(const Lcp& lcp, const std::vector<Index>& kept) { return {lcp.M(kept, kept), lcp.q(kept)}; }

/// The blocks of those coordinates; a block without any is gone.
Inertia blocks_of(const BlockInertia& inertia, const std::vector<Index>& kept) {
  BlockInertia part;
  Index begin = 0;
  for (const Matrix& block : inertia.blocks) {
    std::vector<Index> inside;
    for (Index i = 0; i < block.rows(); ++i) {
      if (is_kept(kept, begin + i)) inside.push_back(i);
    }
    if (!inside.empty()) part.blocks.emplace_back(block(inside, inside));
    begin += block.rows();
  }
  return part;
}

Inertia inertia_of(const Inertia& inertia, const std::vector<Index>& kept) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return DenseInertia{dense->G(kept, kept)};
  if (const auto* inverse = std::get_if<InverseInertia>(&inertia)) return InverseInertia{inverse->Ginv(kept, kept)};
  if (const auto* blocks = std::get_if<BlockInertia>(&inertia)) return blocks_of(*blocks, kept);
  const auto& factored = std::get<FactoredInertia>(inertia);
  return FactoredInertia{factored.X(kept, Eigen::all), factored.alpha};
}

ContactProblem coordinates_of(const ContactProblem& problem, const std::vector<Index>& kept) {
  ContactProblem part = problem;
  part.v = problem.v(kept);
  part.N = part_of(problem.N, kept, all(problem.nc()));
  part.D = part_of(problem.D, kept, all(cols(problem.D)));
  part.inertia = inertia_of(problem.inertia, kept);
  return part;
}

RigidScene bodies_of(const RigidScene& scene, const std::vector<Index>& kept) {
  const std::vector<Index> place = places(static_cast<Index>(scene.bodies.size()), kept);
  const auto moved = [&](int body) {
    return body == RigidContact::kWorld ? RigidContact::kWorld
                                        : static_cast<int>(place[static_cast<std::size_t>(body)]);
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

std::vector<Index> all(Index count) {
  std::vector<Index> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), Index{0});
  return indices;
}

Index contact_count(const Problem& problem) {
  return problem.contact() != nullptr ? problem.contact()->nc() : problem.size();
}

Problem with_contacts(const Problem& problem, const std::vector<Index>& kept) {
  if (const RigidScene* scene = problem.scene()) {
    RigidScene part{scene->bodies, {}};
    for (const Index contact : kept) part.contacts.push_back(scene->contacts[static_cast<std::size_t>(contact)]);
    return {problem.name(), std::move(part)};
  }
  if (problem.contact() != nullptr) return renewed(problem, contacts_of(*problem.contact(), kept));
  return {problem.name(), rows_of(problem.lcp(), kept)};
}

Index body_count(const Problem& problem) {
  if (problem.scene() != nullptr) return static_cast<Index>(problem.scene()->bodies.size());
  return problem.contact() != nullptr ? problem.contact()->ngc() : 0;
}

Problem with_bodies(const Problem& problem, const std::vector<Index>& kept) {
  if (const RigidScene* scene = problem.scene()) return {problem.name(), bodies_of(*scene, kept)};
  return renewed(problem, coordinates_of(*problem.contact(), kept));
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
  part.D = part_of(part.D, all(part.ngc()), directions_of(part, kept));
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
  part.D = part_of(part.D, all(part.ngc()), directions);
  return renewed(problem, std::move(part));
}

}  // namespace lcpbench
