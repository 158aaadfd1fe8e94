#include "study/shrink/numbers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace lcpbench {
namespace {

void add(Draft::Group& group, double& place) {
  if (place != 0) {
    group.emplace_back(&place);
  } else {
    place = 0;  // no negative zeros
  }
}

template <class Values>
void add_all(Draft::Group& group, Values& values) {
  for (Index i = 0; i < values.size(); ++i) add(group, values.data()[i]);
}

/// The upper triangle holds what the lower one does.
template <class Square>
void add_symmetric(Draft::Group& group, Square& matrix) {
  for (Index column = 0; column < matrix.cols(); ++column) {
    add(group, matrix(column, column));
    for (Index row = column + 1; row < matrix.rows(); ++row) {
      if (matrix(row, column) == 0) continue;
      add(group, matrix(row, column));
      group.back().also(&matrix(column, row), 1);
    }
  }
}

void add_jacobian(Draft::Group& group, Jacobian& J) {
  if (auto* dense = std::get_if<Matrix>(&J)) return add_all(group, *dense);
  auto& sparse = std::get<SparseMatrix>(J);
  for (Index i = 0; i < sparse.nonZeros(); ++i) add(group, sparse.valuePtr()[i]);
}

/// The first half of each contact's directions, with their opposites.
void add_directions(Draft::Group& group, ContactProblem& contact) {
  const ContactLayout layout = contact_layout(contact);
  for (std::size_t i = 0; i < contact.edges.size(); ++i) {
    const Index half = contact.edges[i] / 2;
    for (Index t = layout.friction_begin[i]; t < layout.friction_begin[i] + half; ++t) {
      const auto add_column = [&](auto& D) {
        for (Index row = 0; row < D.rows(); ++row) {
          if (D.coeff(row, t) == 0) continue;
          add(group, D.coeffRef(row, t));
          group.back().also(&D.coeffRef(row, t + half), -1);
        }
      };
      std::visit(add_column, contact.D);
    }
  }
}

void add_inertia(std::vector<Draft::Group>& groups, Inertia& inertia) {
  Draft::Group group;
  if (auto* dense = std::get_if<DenseInertia>(&inertia)) add_symmetric(group, dense->G);
  if (auto* inverse = std::get_if<InverseInertia>(&inertia)) add_symmetric(group, inverse->Ginv);
  if (auto* blocks = std::get_if<BlockInertia>(&inertia)) {
    for (Matrix& block : blocks->blocks) add_symmetric(group, block);
  }
  if (auto* factored = std::get_if<FactoredInertia>(&inertia)) {
    add_all(group, factored->X);
    groups.emplace_back();
    add_all(groups.back(), factored->alpha);
  }
  groups.push_back(std::move(group));
}

std::variant<Lcp, ContactProblem, RigidScene> data_of(const Problem& problem) {
  if (problem.scene() != nullptr) return *problem.scene();
  if (problem.contact() != nullptr) return *problem.contact();
  return problem.lcp();
}

}  // namespace

int digits_of(double value) {
  if (value == 0) return 0;
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific).ptr;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return static_cast<int>(std::count_if(text.data(), std::find(text.data(), end, 'e'), is_digit));
}

double rounded(double value, int digits) {
  std::array<char, 64> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific,
                                 std::max(digits, 1) - 1);
  double result = value;
  std::from_chars(text.data(), end.ptr, result);
  return result;
}

bool has_symmetric_matrix(const Problem& problem) {
  return problem.kind() == ProblemKind::kLcp && problem.lcp().M == problem.lcp().M.transpose();
}

Draft::Draft(const Problem& problem, bool symmetric)
    : symmetric_(symmetric), name_(problem.name()), data_(data_of(problem)) {
  std::visit([this](auto& data) { collect(data); }, data_);
}

Problem Draft::problem() const {
  return std::visit([this](const auto& data) { return Problem(name_, data); }, data_);
}

void Draft::collect(RigidScene& scene) {
  enum Meaning { kSpin, kVelocity, kOffset, kFriction, kMass, kInertia, kPlace, kMeanings };
  groups_.resize(kMeanings);
  for (RigidBody& body : scene.bodies) {
    add_all(groups_[kSpin], body.angular_velocity);
    add_all(groups_[kVelocity], body.linear_velocity);
    add(groups_[kMass], body.mass);
    add_symmetric(groups_[kInertia], body.inertia);
    add_all(groups_[kPlace], body.position);
  }
  for (RigidContact& contact : scene.contacts) {
    for (double* value : {&contact.b, &contact.offset_t(0), &contact.offset_t(1)}) add(groups_[kOffset], *value);
    for (double* value : {&contact.compliance_n, &contact.compliance_t}) add(groups_[kFriction], *value);
    add(groups_[kFriction], contact.mu);
    add_all(groups_[kPlace], contact.point);
  }
}

void Draft::collect(ContactProblem& contact) {
  groups_.resize(5);
  add_all(groups_[0], contact.b);
  add_all(groups_[0], contact.rows.b);
  add_all(groups_[0], contact.offset_t);
  add_all(groups_[1], contact.v);
  add_all(groups_[2], contact.mu);
  add_all(groups_[2], contact.compliance_n);
  add_all(groups_[2], contact.compliance_t);
  add_all(groups_[2], contact.rows.bounds.mu);
  add_all(groups_[2], contact.rows.compliance);
  add_directions(groups_[3], contact);
  add_jacobian(groups_[4], contact.N);
  add_jacobian(groups_[4], contact.rows.R);
  add_inertia(groups_, contact.inertia);
  if (!contact.has_rows()) return;
  groups_.emplace_back();
  for (Vector* bounds : {&contact.rows.bounds.lower, &contact.rows.bounds.upper}) {
    for (double& bound : *bounds) {
      if (std::isfinite(bound)) add(groups_.back(), bound);
    }
  }
}

void Draft::collect(Lcp& lcp) {
  groups_.resize(2);
  add_all(groups_[0], lcp.q);
  if (symmetric_) {
    add_symmetric(groups_[1], lcp.M);
  } else {
    add_all(groups_[1], lcp.M);
  }
}

}  // namespace lcpbench
