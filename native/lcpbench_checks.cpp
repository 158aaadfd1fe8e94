#include "native/lcpbench_checks.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "core/error.h"
#include "core/settings.h"

namespace lcpbench {
namespace {

/// Largest accepted asymmetry of an inertia, relative to its largest entry. It covers the rounding of R I R' in single
/// precision, a few times 6e-8.
constexpr double kInertiaRounding = 1e-6;

/// Six digits: what single-precision engines keep of a unit vector.
constexpr double kDirectionTolerance = 1e-6;

std::string at(const char* list, std::size_t i, const char* field) {
  return std::string(list) + "[" + std::to_string(i) + "]." + field;
}

[[noreturn]] void refuse(const std::string& field, const std::string& value, const std::string& expected) {
  throw InputError(field + " is " + value + ", expected " + expected);
}

template <class Dense>
void check_finite(const Dense& values, const char* list, std::size_t i, const char* field) {
  if (!values.allFinite()) throw InputError(at(list, i, field) + " holds NaN or infinity");
}

/// As in files, with the same tolerance.
void check_unit(const Eigen::Vector3d& direction, std::size_t i, const char* field) {
  check_finite(direction, "contacts", i, field);
  const double length = direction.norm();
  if (std::abs(length - 1) <= kDirectionTolerance) return;
  throw InputError(at("contacts", i, field) + " has length " + format_real(length) + ", expected 1");
}

void check_body(const RigidBody& body, std::size_t i) {
  if (!(body.mass > 0) || !std::isfinite(body.mass)) {
    refuse(at("bodies", i, "mass"), format_real(body.mass), "a finite number > 0");
  }
  if (!std::isfinite(1 / body.mass)) {
    throw InputError(at("bodies", i, "mass") + " is " + format_real(body.mass) + "; its inverse overflows");
  }
  check_finite(body.position, "bodies", i, "position");
  check_finite(body.linear_velocity, "bodies", i, "linear_velocity");
  check_finite(body.angular_velocity, "bodies", i, "angular_velocity");
  check_finite(body.inertia, "bodies", i, "inertia");
  const double asymmetry = (body.inertia - body.inertia.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > kInertiaRounding * body.inertia.cwiseAbs().maxCoeff()) {
    throw InputError(at("bodies", i, "inertia") + " is not symmetric");
  }
  const Eigen::LLT<Eigen::Matrix3d> cholesky(body.inertia);
  const Eigen::Vector3d pivots = cholesky.matrixLLT().diagonal();
  if (cholesky.info() != Eigen::Success || !(pivots.array() > 0).all()) {  // Eigen's own test lets NaN pass
    throw InputError(at("bodies", i, "inertia") + " is not positive definite");
  }
}

void check_body_index(int body, int lowest, std::size_t bodies, const std::string& field) {
  if (body >= lowest && body < static_cast<std::int64_t>(bodies)) return;
  refuse(field, std::to_string(body),
         (lowest < 0 ? "-1 (world) or " : "") + std::string("one of ") + std::to_string(bodies) +
             " bodies, counted from 0");
}

/// Of the tangents of a contact without edges.
void check_zero(double value, const std::string& field) {
  if (std::abs(value) > 0) throw InputError(field + " would be ignored: the contact has no edges");
}

void check_friction(double mu, int edges, const std::string& field) {
  if (!(mu >= 0) || !std::isfinite(mu)) refuse(field, format_real(mu), "a finite number >= 0");
  if (edges == 0) check_zero(mu, field);
}

void check_compliance(double r, const std::string& field) {
  if (!(r >= 0) || !std::isfinite(r)) refuse(field, format_real(r), "a finite number >= 0");
}

void check_contact(const RigidScene& scene, std::size_t i) {
  const RigidContact& contact = scene.contacts[i];
  if (contact.body_a == RigidContact::kWorld && contact.body_b != RigidContact::kWorld) {
    throw InputError(at("contacts", i, "body_a") +
                     " is -1, the world, which has to be body_b: swap the bodies and turn the normal");
  }
  check_body_index(contact.body_a, 0, scene.bodies.size(), at("contacts", i, "body_a"));
  check_body_index(contact.body_b, RigidContact::kWorld, scene.bodies.size(), at("contacts", i, "body_b"));
  if (contact.body_a == contact.body_b) throw InputError(at("contacts", i, "body_b") + " is body_a");
  if (contact.edges != 0 && contact.edges != 4) {
    refuse(at("contacts", i, "edges"), std::to_string(contact.edges), "0 or 4");
  }
  check_finite(contact.point, "contacts", i, "point");
  check_unit(contact.normal, i, "normal");
  if (contact.edges == 0) {
    check_finite(contact.tangent, "contacts", i, "tangent");
  } else {
    check_unit(contact.tangent, i, "tangent");
    const double cosine = contact.normal.dot(contact.tangent);
    if (!(std::abs(cosine) <= kDirectionTolerance)) {
      throw InputError(at("contacts", i, "tangent") + " is not orthogonal to the normal: their scalar product is " +
                       format_real(cosine));
    }
  }
  check_friction(contact.mu, contact.edges, at("contacts", i, "mu"));
  if (!std::isfinite(contact.b)) refuse(at("contacts", i, "b"), format_real(contact.b), "a finite number");
  check_compliance(contact.compliance_n, at("contacts", i, "compliance_n"));
  check_compliance(contact.compliance_t, at("contacts", i, "compliance_t"));
  check_finite(contact.offset_t, "contacts", i, "offset_t");
  if (contact.edges > 0) return;
  check_zero(contact.compliance_t, at("contacts", i, "compliance_t"));
  for (const int k : {0, 1}) check_zero(contact.offset_t(k), at("contacts", i, "offset_t"));
}

void check_shape(Index rows, Index cols, Index expected_rows, Index expected_cols, const std::string& field) {
  if (rows == expected_rows && cols == expected_cols) return;
  refuse(field, std::to_string(rows) + " x " + std::to_string(cols),
         std::to_string(expected_rows) + " x " + std::to_string(expected_cols));
}

void check_count(std::size_t found, Index count, const std::string& field) {
  if (static_cast<Index>(found) == count) return;
  throw InputError(field + " has " + std::to_string(found) + " entries, expected " + std::to_string(count));
}

void check_length(const Vector& values, Index count, const std::string& field) {
  check_count(static_cast<std::size_t>(values.size()), count, field);
}

/// A vector without entries stands for zeros.
void check_optional(const Vector& values, Index count, const std::string& field) {
  if (values.size() > 0) check_length(values, count, field);
}

/// As in files.
void check_rows(const BoundedRows& bounded, Index ngc) {
  const Index count = bounded.size();
  const LcpBounds& bounds = bounded.bounds;
  check_shape(rows(bounded.R), cols(bounded.R), ngc, count, "rows.R");
  check_length(bounds.upper, count, "rows.upper");
  check_length(bounds.mu, count, "rows.mu");
  check_count(bounds.friction_of.size(), count, "rows.friction_of");
  check_optional(bounded.b, count, "rows.b");
  check_optional(bounded.compliance, count, "rows.compliance");
  check_count(bounded.is_angle.size(), count, "rows.is_angle");
  if (!bounded.names.empty()) check_count(bounded.names.size(), count, "rows.names");
  for (Index i = 0; i < count; ++i) {
    const auto field = [&](const char* name) { return std::string("rows.") + name + "[" + std::to_string(i) + "]"; };
    check_compliance(bounded.yields(i), field("compliance"));
    const double lower = bounds.lower(i), upper = bounds.upper(i);
    const int of = bounds.friction_of[static_cast<std::size_t>(i)];
    if (of < 0) {
      if (!(lower <= 0)) refuse(field("lower"), format_real(lower), "at most 0");
      if (!(upper >= 0)) refuse(field("upper"), format_real(upper), "at least 0");
      if (!(lower < upper)) throw InputError(field("lower") + " and the upper bound are 0: leave the row out");
      continue;
    }
    check_friction(bounds.mu(i), 2, field("mu"));
    if (of >= count || bounds.friction_of[static_cast<std::size_t>(of)] >= 0 || bounds.lower(of) != 0) {
      refuse(field("friction_of"), std::to_string(of), "a row with the lower bound 0 of its own");
    }
    if (std::isfinite(lower) || std::isfinite(upper)) {
      throw InputError(field("lower") + " or the upper bound is given, but friction_of bounds this row");
    }
  }
}

struct CheckInertiaShape {
  Index ngc;

  void operator()(const DenseInertia& inertia) const {
    check_shape(inertia.G.rows(), inertia.G.cols(), ngc, ngc, "inertia.G");
  }
  void operator()(const BlockInertia& inertia) const {
    Index size = 0;
    for (std::size_t i = 0; i < inertia.blocks.size(); ++i) {
      const Matrix& block = inertia.blocks[i];
      check_shape(block.rows(), block.cols(), block.rows(), block.rows(), "inertia.blocks[" + std::to_string(i) + "]");
      size += block.rows();
    }
    check_shape(size, size, ngc, ngc, "inertia.blocks together");
  }
  void operator()(const FactoredInertia& inertia) const {
    check_shape(inertia.X.rows(), inertia.X.cols(), ngc, inertia.alpha.size(), "inertia.X");
  }
  void operator()(const InverseInertia& inertia) const {
    check_shape(inertia.Ginv.rows(), inertia.Ginv.cols(), ngc, ngc, "inertia.Ginv");
  }
};

}  // namespace

void check_usable(const RigidScene& scene) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) check_body(scene.bodies[i], i);
  for (std::size_t i = 0; i < scene.contacts.size(); ++i) check_contact(scene, i);
}

void check_usable(const ContactProblem& contacts) {
  const Index nc = contacts.nc();
  check_length(contacts.mu, nc, "mu");
  Index friction = 0;
  for (Index i = 0; i < nc; ++i) {
    const int edges = contacts.edges[static_cast<std::size_t>(i)];
    const std::string index = std::string("[") + std::to_string(i) + "]";
    if (edges < 0 || edges % 2 != 0) refuse("edges" + index, std::to_string(edges), "an even number >= 0");
    check_friction(contacts.mu(i), edges, "mu" + index);
    friction += edges;
  }
  check_shape(rows(contacts.N), cols(contacts.N), contacts.ngc(), nc, "N");
  check_shape(rows(contacts.D), cols(contacts.D), contacts.ngc(), friction, "D");
  check_optional(contacts.b, nc, "b");
  check_optional(contacts.compliance_n, nc, "compliance_n");
  check_optional(contacts.compliance_t, nc, "compliance_t");
  check_optional(contacts.offset_t, 2 * nc, "offset_t");
  for (Index i = 0; i < nc; ++i) {
    check_compliance(contacts.normal_compliance(i), "compliance_n[" + std::to_string(i) + "]");
    check_compliance(contacts.tangential_compliance(i), "compliance_t[" + std::to_string(i) + "]");
    if (contacts.edges[static_cast<std::size_t>(i)] > 0) continue;
    check_zero(contacts.tangential_compliance(i), "compliance_t[" + std::to_string(i) + "]");
    for (const int k : {0, 1}) {
      check_zero(contacts.tangential_offset(i, k), "offset_t[" + std::to_string(2 * i + k) + "]");
    }
  }
  if (contacts.has_rows() || cols(contacts.rows.R) > 0) check_rows(contacts.rows, contacts.ngc());
  std::visit(CheckInertiaShape{contacts.ngc()}, contacts.inertia);
}

}  // namespace lcpbench
