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
    scene.contacts.push_back(contact);
  }
  return scene;
}

ContactProblem to_contact_problem(const PlantedSample& sample) {
  const std::size_t n = sample.q.size();
  const auto order = static_cast<Index>(n);
  return {to_vector(sample.q),         Matrix(Matrix::Identity(order, order)), Matrix(order, 0), std::vector<int>(n, 0),
          Vector(Vector::Zero(order)), InverseInertia{to_matrix(sample.M)}};
}

Lcp to_lcp(const PlantedSample& sample) { return {to_matrix(sample.M), to_vector(sample.q)}; }

}  // namespace lcpbench
