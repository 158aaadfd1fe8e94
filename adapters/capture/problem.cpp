#include "adapters/capture/problem.h"

#include <utility>
#include <vector>

namespace lcpbench::capture {
namespace {

/// Halves each entry before adding, as examples/capture/capture.h does, so that the bits agree.
Matrix symmetric(const Matrix& matrix) { return 0.5 * matrix + 0.5 * matrix.transpose(); }

RigidContact rigid_contact(const ContactState& state) {
  RigidContact contact{.body_a = state.body_a, .body_b = state.body_b, .point = state.point, .normal = state.normal};
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const bool turned = contact.body_a == kWorld;  // the world must be body_b: swap the bodies
  if (turned) {
    std::swap(contact.body_a, contact.body_b);
    contact.normal = zero - state.normal;
  }
  if (state.edges != 0) {
    contact.tangent = turned ? Eigen::Vector3d(zero - state.tangent) : state.tangent;
    contact.mu = state.mu;
    contact.edges = state.edges;
  }
  contact.b = state.offset;
  contact.compliance_n = state.compliance_n;
  if (state.edges == 0) return contact;
  contact.compliance_t = state.compliance_t;
  contact.offset_t << state.offset_t(0), (turned ? -1 : 1) * state.offset_t(1);
  return contact;
}

RigidScene rigid_scene(const Snapshot& snapshot) {
  RigidScene scene;
  scene.bodies.reserve(snapshot.bodies.size());
  scene.contacts.reserve(snapshot.contacts.size());
  for (const BodyState& body : snapshot.bodies) {
    scene.bodies.push_back(
        {body.mass, symmetric(body.inertia), body.position, body.linear_velocity, body.angular_velocity});
  }
  for (const ContactState& state : snapshot.contacts) scene.contacts.push_back(rigid_contact(state));
  return scene;
}

/// Columns that are filled one after the other.
class Columns {
 public:
  void add(const std::vector<int>& coordinates, const Eigen::VectorXd& values, double sign) {
    for (std::size_t k = 0; k < coordinates.size(); ++k) {
      const double value = sign * values(static_cast<Index>(k));
      if (value != 0) entries_.emplace_back(coordinates[k], count_, value);
    }
    ++count_;
  }
  SparseMatrix matrix(Index rows) const {
    SparseMatrix result(rows, count_);
    result.setFromTriplets(entries_.begin(), entries_.end());
    return result;
  }

 private:
  std::vector<Eigen::Triplet<double>> entries_;
  int count_ = 0;
};

BoundedRows bounded_rows(const std::vector<RowState>& states, Index coordinates) {
  BoundedRows rows;
  Columns R;
  const auto count = static_cast<Index>(states.size());
  rows.bounds = {Vector(count), Vector(count), std::vector<int>(states.size()), Vector(count)};
  Vector b(count), compliance(count);
  for (Index i = 0; i < count; ++i) {
    const RowState& state = states[static_cast<std::size_t>(i)];
    R.add(state.coordinates, state.direction, 1);
    rows.bounds.lower(i) = state.lower;
    rows.bounds.upper(i) = state.upper;
    b(i) = state.offset;
    compliance(i) = state.compliance;
    rows.bounds.friction_of[static_cast<std::size_t>(i)] = state.friction_of;
    rows.bounds.mu(i) = state.mu;
    rows.is_angle.push_back(state.is_angle ? 1 : 0);
    rows.names.push_back(state.name);
  }
  rows.R = R.matrix(coordinates);
  if (!b.isZero(0)) rows.b = b;
  if (!compliance.isZero(0)) rows.compliance = compliance;
  return rows;
}

ContactProblem contacts_of_blocks(const Snapshot& snapshot) {
  ContactProblem problem;
  BlockInertia inertia;
  Index size = 0;
  for (const BlockState& block : snapshot.blocks) {
    inertia.blocks.push_back(symmetric(block.mass));
    problem.v.conservativeResize(size + block.velocity.size());
    problem.v.tail(block.velocity.size()) = block.velocity;
    size += block.velocity.size();
  }
  problem.inertia = std::move(inertia);
  Columns N;
  Columns D;
  const auto count = static_cast<Index>(snapshot.contacts.size());
  problem.mu = Vector::Zero(count);
  Vector b = Vector::Zero(count), compliance_n = b, compliance_t = b, offset_t = Vector::Zero(2 * count);
  for (const ContactState& contact : snapshot.contacts) {
    const auto i = static_cast<Index>(problem.edges.size());
    const Rows& rows = *contact.rows;
    N.add(rows.coordinates, rows.normal, 1);
    problem.edges.push_back(contact.edges);
    b(i) = contact.offset;
    compliance_n(i) = contact.compliance_n;
    if (contact.edges == 0) continue;
    compliance_t(i) = contact.compliance_t;
    offset_t.segment<2>(2 * i) = contact.offset_t;
    problem.mu(i) = contact.mu;
    for (const double sign : {1.0, -1.0}) {
      D.add(rows.coordinates, rows.tangent, sign);
      if (contact.edges == 4) D.add(rows.coordinates, rows.second_tangent, sign);
    }
  }
  problem.N = N.matrix(size);
  problem.D = D.matrix(size);
  if (!snapshot.rows.empty()) problem.rows = bounded_rows(snapshot.rows, size);
  if (!b.isZero(0)) problem.b = b;
  if (!compliance_n.isZero(0)) problem.compliance_n = compliance_n;
  if (!compliance_t.isZero(0)) problem.compliance_t = compliance_t;
  if (!offset_t.isZero(0)) problem.offset_t = offset_t;
  return problem;
}

}  // namespace

std::variant<RigidScene, ContactProblem> contacts_of(const Snapshot& snapshot) {
  if (snapshot.blocks.empty()) return rigid_scene(snapshot);
  return contacts_of_blocks(snapshot);
}

Problem problem_of(const Snapshot& snapshot) {
  return std::visit([](auto contacts) { return Problem("", std::move(contacts)); }, contacts_of(snapshot));
}

}  // namespace lcpbench::capture
