#include "generators/to_problem.h"

namespace lcpbench {
namespace {

Vector to_vector(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Index>(values.size()));
}

Eigen::Vector3d to_vector(const Triple& values) { return {values[0], values[1], values[2]}; }

Matrix to_matrix(const ColumnMajor<double>& values) {
  return Eigen::Map<const Matrix>(values.data.data(), static_cast<Index>(values.rows), static_cast<Index>(values.cols));
}

Inertia to_inertia(const PaperSample& sample) {
  switch (sample.form) {
    case InertiaForm::kFactored: return FactoredInertia{to_matrix(sample.X), to_vector(sample.alpha)};
    case InertiaForm::kInverse: return InverseInertia{to_matrix(sample.G)};
    case InertiaForm::kDense: break;
  }
  return DenseInertia{to_matrix(sample.G)};
}

// D for more than four edges: of each contact, the columns of friction_directions(), then their negatives. The column
// of a direction is the column of N of a contact that has this direction as its normal.
SparseMatrix friction_columns(const RigidSample& sample) {
  RigidSample along_normals{.bodies = sample.bodies};
  for (const RigidContactSample& contact : sample.contacts) {
    for (const Triple& direction : friction_directions(contact, static_cast<PyramidEdges>(sample.edges))) {
      along_normals.contacts.push_back(contact);
      along_normals.contacts.back().normal = direction;
    }
  }
  const auto half = std::get<SparseMatrix>(contact_problem(to_scene(along_normals)).N);
  const Index directions = sample.edges / 2;  // of a contact in `half`
  std::vector<Eigen::Triplet<double>> triplets;
  for (Index column = 0; column < half.cols(); ++column) {
    const Index first = 2 * directions * (column / directions) + column % directions;
    for (SparseMatrix::InnerIterator entry(half, column); entry; ++entry) {
      triplets.emplace_back(entry.row(), first, entry.value());
      triplets.emplace_back(entry.row(), first + directions, -entry.value());
    }
  }
  SparseMatrix columns(half.rows(), 2 * half.cols());
  columns.setFromTriplets(triplets.begin(), triplets.end());
  return columns;
}

}  // namespace

ContactProblem to_contact_problem(const PaperSample& sample) {
  return {to_vector(sample.v), to_matrix(sample.N),  to_matrix(sample.D),
          sample.edges,        to_vector(sample.mu), to_inertia(sample)};
}

RigidScene to_scene(const RigidSample& sample) {
  RigidScene scene;
  for (const RigidBodySample& body : sample.bodies) {
    scene.bodies.push_back({body.mass, Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix3d>(body.inertia.data.data())),
                            to_vector(body.position), to_vector(body.linear_velocity),
                            to_vector(body.angular_velocity)});
  }
  for (const RigidContactSample& sampled : sample.contacts) {
    RigidContact contact;
    contact.body_a = sampled.body_a;
    contact.body_b = sampled.body_b;
    contact.point = to_vector(sampled.point);
    contact.normal = to_vector(sampled.normal);
    if (sample.edges > 0) {
      contact.tangent = to_vector(sampled.tangent);
      contact.mu = sampled.mu;
      contact.edges = sample.edges;
    }
    scene.contacts.push_back(contact);
  }
  return scene;
}

ContactProblem to_contact_problem(const RigidSample& sample) {
  if (sample.edges <= 4) return contact_problem(to_scene(sample));
  RigidSample frictionless = sample;
  frictionless.edges = 0;
  ContactProblem problem = contact_problem(to_scene(frictionless));
  problem.D = friction_columns(sample);
  for (std::size_t i = 0; i < sample.contacts.size(); ++i) {
    problem.edges[i] = sample.edges;
    problem.mu(static_cast<Index>(i)) = sample.contacts[i].mu;
  }
  return problem;
}

ContactProblem to_contact_problem(const MadeSample& sample) {
  const auto jacobian = [&sample](const std::vector<MadeSample::Column>& columns) {
    std::vector<Eigen::Triplet<double>> triplets;
    for (std::size_t j = 0; j < columns.size(); ++j) {
      for (const auto& [row, entry] : columns[j]) {
        triplets.emplace_back(static_cast<Index>(row), static_cast<Index>(j), entry);
      }
    }
    SparseMatrix J(static_cast<Index>(sample.v.size()), static_cast<Index>(columns.size()));
    J.setFromTriplets(triplets.begin(), triplets.end());
    return J;
  };
  BlockInertia inertia;
  for (const ColumnMajor<double>& block : sample.blocks) inertia.blocks.push_back(to_matrix(block));
  const Vector b = to_vector(sample.b);
  ContactProblem problem{to_vector(sample.v),  jacobian(sample.N), jacobian(sample.D),      sample.edges,
                         to_vector(sample.mu), std::move(inertia), b.isZero(0) ? Vector{} : b};
  if (!sample.is_dense) return problem;
  problem.N = to_dense(problem.N);
  problem.D = to_dense(problem.D);
  problem.inertia = DenseInertia{dense_inertia(problem.inertia)};
  return problem;
}

ContactProblem to_contact_problem(const PlantedSample& sample) {
  const std::size_t n = sample.q.size();
  const auto order = static_cast<Index>(n);
  return {to_vector(sample.q),         Matrix(Matrix::Identity(order, order)), Matrix(order, 0), std::vector<int>(n, 0),
          Vector(Vector::Zero(order)), InverseInertia{to_matrix(sample.M)}};
}

Lcp to_lcp(const PlantedSample& sample) { return {to_matrix(sample.M), to_vector(sample.q)}; }

Lcp to_lcp(const HardCase& problem) { return {to_matrix(problem.M), to_vector(problem.q)}; }

}  // namespace lcpbench
