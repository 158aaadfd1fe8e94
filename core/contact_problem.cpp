#include "core/contact_problem.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/compliance.h"
#include "core/entries.h"
#include "core/quad_inertia.h"

namespace lcpbench {
namespace {

/// to += G* x. The bodies' blocks are never put into one matrix, which would grow with the square of a scene.
void add_inverse_product(const Inertia& inertia, const Vector& x, Vector& to) {
  if (!std::holds_alternative<BlockInertia>(inertia)) {
    to.noalias() += inverse_inertia(inertia, InverseProof::kDigits) * x;
    return;
  }
  for_each_matrix(inertia, [&](const Matrix& block, Index at) {
    const Matrix inverse = inverse_inertia(DenseInertia{block}, InverseProof::kDigits);
    to.segment(at, block.rows()).noalias() += inverse * x.segment(at, block.rows());
  });
}

Matrix inverse_for(const Inertia& inertia, const MatrixFormation& formation) {
  const bool plain = formation.plain_inverse && !std::holds_alternative<InverseInertia>(inertia);
  return plain ? Matrix(dense_inertia(inertia).partialPivLu().inverse()) : inverse_inertia(inertia);
}

/// post_impact_velocity() in 113 bits: entries of G* may be beyond double where the velocity is not.
Vector post_impact_velocity_in_quad(const ContactProblem& problem, const Vector& z) {
  const QuadInertia inertia(problem.inertia);
  if (!inertia.well_defined()) return Vector::Constant(problem.ngc(), std::numeric_limits<double>::quiet_NaN());
  QuadVector change(static_cast<std::size_t>(problem.ngc()), 0);
  const auto add = [&](const Jacobian& J, Index first) {
    for (Index j = 0; j < cols(J); ++j) {
      const Quad f = z(first + j);
      for_each_entry(J, j, [&](Index i, double entry) { change[static_cast<std::size_t>(i)] += entry * f; });
    }
  };
  add(problem.N, 0);
  add(problem.D, problem.nc());
  if (problem.has_rows()) add(problem.rows.R, z.size() - problem.rows.size());
  inertia.solve(change);
  for (Index i = 0; i < problem.ngc(); ++i) change[static_cast<std::size_t>(i)] += problem.v(i);
  return Vector::NullaryExpr(problem.ngc(), [&](Index i) { return to_double(change[static_cast<std::size_t>(i)]); });
}

void add_softness(const ContactProblem& problem, const ContactLayout& layout, Lcp& lcp) {
  const SoftRows<double> soft(problem, layout);
  for (Index c = 0; c < layout.nc; ++c) {
    lcp.M(c, c) += soft.normal(c);
    const Index edges = problem.edges[static_cast<std::size_t>(c)];
    const Index first = layout.friction_offset() + layout.friction_begin[static_cast<std::size_t>(c)];
    for (Index t = 0; t < edges; ++t) {
      const auto yielding = soft.yielding(c, [&](Index i) { return i == first + t ? 1.0 : 0.0; });
      for (Index k = 0; k < edges; ++k) lcp.M(first + k, first + t) += soft.along(c, k, yielding);
      lcp.q(first + t) += soft.along(c, t, soft.offset(c));
    }
  }
}

/// The last rows and columns of M, and the bounds. @param products  of all columns of J
void add_bounded_rows(const ContactProblem& problem, const ContactLayout& layout, const Matrix& products, Lcp& lcp) {
  const BoundedRows& rows = problem.rows;
  const Index impulses = layout.lambda_offset(), first = layout.row_offset();
  lcp.M.block(first, 0, rows.size(), impulses) = products.bottomLeftCorner(rows.size(), impulses);
  lcp.M.block(0, first, impulses, rows.size()) = products.topRightCorner(impulses, rows.size());
  lcp.M.bottomRightCorner(rows.size(), rows.size()) = products.bottomRightCorner(rows.size(), rows.size());
  lcp.bounds = LcpBounds::nonnegative(layout.size());
  lcp.bounds.lower.tail(rows.size()) = rows.bounds.lower;
  lcp.bounds.upper.tail(rows.size()) = rows.bounds.upper;
  lcp.bounds.mu.tail(rows.size()) = rows.bounds.mu;
  for (Index i = 0; i < rows.size(); ++i) {
    lcp.M(first + i, first + i) += rows.yields(i);
    lcp.q(first + i) += rows.offset(i);
    const int of = rows.bounds.friction_of[static_cast<std::size_t>(i)];
    if (of >= 0) lcp.bounds.friction_of[static_cast<std::size_t>(first + i)] = static_cast<int>(first) + of;
  }
}

}  // namespace

std::string BoundedRows::name_of(Index row) const {
  const std::string number = "row " + std::to_string(row);
  const auto i = static_cast<std::size_t>(row);
  return i < names.size() && !names[i].empty() ? number + " (" + names[i] + ")" : number;
}

Index rows(const Jacobian& J) {
  return std::visit([](const auto& m) { return m.rows(); }, J);
}

Index cols(const Jacobian& J) {
  return std::visit([](const auto& m) { return m.cols(); }, J);
}

Matrix to_dense(const Jacobian& J) {
  return std::visit([](const auto& m) { return Matrix(m); }, J);
}

bool all_finite(const Jacobian& J) {
  if (const auto* dense = std::get_if<Matrix>(&J)) return dense->allFinite();
  const auto& sparse = std::get<SparseMatrix>(J);
  for (Index column = 0; column < sparse.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator entry(sparse, column); entry; ++entry) {
      if (!std::isfinite(entry.value())) return false;
    }
  }
  return true;
}

ContactLayout contact_layout(const ContactProblem& problem, ContactLayout memory) {
  ContactLayout layout = std::move(memory);
  layout.nc = problem.nc();
  layout.friction = layout.cones = 0;
  layout.friction_begin.assign(problem.edges.size() + 1, 0);
  layout.lambda.resize(problem.edges.size());
  layout.cone_contact.resize(problem.edges.size());
  for (std::size_t i = 0; i < problem.edges.size(); ++i) {
    const int edges = problem.edges[i];
    layout.friction += edges;
    layout.friction_begin[i + 1] = layout.friction;
    layout.lambda[i] = edges > 0 ? layout.cones : -1;
    if (edges > 0) layout.cone_contact[static_cast<std::size_t>(layout.cones++)] = static_cast<Index>(i);
  }
  layout.cone_contact.resize(static_cast<std::size_t>(layout.cones));
  layout.rows = problem.rows.size();
  return layout;
}

Index lcp_size(const ContactProblem& problem) {
  Index size = problem.nc() + problem.rows.size();
  for (const int edges : problem.edges) size += edges > 0 ? edges + 1 : 0;
  return size;
}

Index dimension(const Inertia& inertia) {
  Index size = 0;
  for_each_matrix(inertia, [&](const Matrix& matrix, Index) { size += matrix.rows(); });
  return size;
}

Matrix dense_inertia(const Inertia& inertia) {
  if (const auto* dense = std::get_if<DenseInertia>(&inertia)) return dense->G;
  if (const auto* factors = std::get_if<FactoredInertia>(&inertia)) {
    return factors->X * factors->alpha.asDiagonal() * factors->X.transpose();
  }
  if (std::holds_alternative<InverseInertia>(inertia)) return Matrix();
  Matrix G = Matrix::Zero(dimension(inertia), dimension(inertia));
  for_each_matrix(inertia, [&](const Matrix& block, Index at) {
    G.block(at, at, block.rows(), block.cols()) = block;
  });
  return G;
}

Lcp form_lcp(const ContactProblem& problem, const MatrixFormation& formation) {
  const ContactLayout layout = contact_layout(problem);
  const Index impulses = layout.nc + layout.friction;
  Matrix J(problem.ngc(), impulses + layout.rows);
  J.leftCols(layout.nc) = to_dense(problem.N);
  J.middleCols(layout.nc, layout.friction) = to_dense(problem.D);
  if (problem.has_rows()) J.rightCols(layout.rows) = to_dense(problem.rows.R);

  Lcp lcp;
  lcp.M = Matrix::Zero(layout.size(), layout.size());
  lcp.q = Vector::Zero(layout.size());
  const Matrix response = inverse_for(problem.inertia, formation) * J;
  const auto form_products = [&](auto&& products) {
    products.noalias() = response.transpose() * J;  // Eigen's order for this one, not its transpose, gives M's last bits
    products.transposeInPlace();
  };
  Matrix products;  // of all columns; not the same order as of M
  if (problem.has_rows()) {
    form_products(products);
    lcp.M.topLeftCorner(impulses, impulses) = products.topLeftCorner(impulses, impulses);
  } else {
    form_products(lcp.M.topLeftCorner(impulses, impulses));
  }
  const Vector velocities = J.transpose() * problem.v;
  lcp.q.head(impulses) = velocities.head(impulses);
  lcp.q.tail(layout.rows) = velocities.tail(layout.rows);
  if (problem.has_offset()) lcp.q.head(layout.nc) += problem.b;
  if (problem.is_soft()) add_softness(problem, layout, lcp);
  if (problem.has_rows()) add_bounded_rows(problem, layout, products, lcp);
  for (Index c = 0; c < layout.cones; ++c) {
    const Index contact = layout.cone_contact[static_cast<std::size_t>(c)];
    const Index lambda = layout.lambda_offset() + c;
    lcp.M(lambda, contact) = problem.mu(contact);
    lcp.M(lambda, lambda) = formation.cone_diagonal;
    for (Index t = layout.friction_begin[static_cast<std::size_t>(contact)];
         t < layout.friction_begin[static_cast<std::size_t>(contact) + 1]; ++t) {
      lcp.M(layout.friction_offset() + t, lambda) = 1.0;
      lcp.M(lambda, layout.friction_offset() + t) = -1.0;
    }
  }
  return lcp;
}

Vector post_impact_velocity(const ContactProblem& problem, const Vector& z) {
  const ContactLayout layout = contact_layout(problem);
  const auto times = [](const Jacobian& J, const auto& x) {
    return std::visit([&](const auto& m) { return Vector(m * x); }, J);
  };
  const auto add_response = [&](const Vector& f, Vector& to) {
    Vector impulse = times(problem.N, f.head(layout.nc)) + times(problem.D, f.segment(layout.nc, layout.friction));
    if (problem.has_rows()) impulse += times(problem.rows.R, f.tail(layout.rows));
    add_inverse_product(problem.inertia, impulse, to);
  };
  Vector f(layout.lambda_offset() + layout.rows);
  f << z.head(layout.lambda_offset()), z.tail(layout.rows);
  // Tiny impulses take a product of their own, scaled so that it does not underflow.
  const Vector tiny = f.unaryExpr([](double x) { return is_near_underflow(x) ? x : 0.0; });
  Vector velocity = problem.v;
  add_response(f - tiny, velocity);
  if (!tiny.isZero(0)) {
    constexpr double kScale = 0x1p600;
    Vector response = Vector::Zero(problem.ngc());
    add_response(tiny * kScale, response);
    velocity += response / kScale;
  }
  if (!velocity.allFinite() && problem.v.allFinite() && z.allFinite()) return post_impact_velocity_in_quad(problem, z);
  return velocity;
}

Vector complete_impulses(const ContactProblem& problem, const Vector& impulses) {
  const ContactLayout layout = contact_layout(problem);
  Vector z = Vector::Zero(layout.size());
  z.head(layout.lambda_offset()) = impulses.head(layout.lambda_offset());
  z.tail(layout.rows) = impulses.tail(layout.rows);
  const Vector velocity = post_impact_velocity(problem, z);
  const Vector slip = std::visit([&](const auto& D) { return Vector(D.transpose() * velocity); }, problem.D);
  const SoftRows<double> soft(problem, layout);
  for (Index cone = 0; cone < layout.cones; ++cone) {
    const Index contact = layout.cone_contact[static_cast<std::size_t>(cone)];
    const auto i = static_cast<std::size_t>(contact);
    double& lambda = z(layout.lambda_offset() + cone);
    const auto yielding = soft.yielding(contact, [&](Index j) { return z(j); });
    for (Index t = layout.friction_begin[i]; t < layout.friction_begin[i + 1]; ++t) {
      double own = slip(t);
      if (problem.is_soft()) {
        const Index k = t - layout.friction_begin[i];
        own += soft.along(contact, k, soft.offset(contact)) + soft.along(contact, k, yielding);
      }
      lambda = std::max(lambda, -own);
    }
  }
  return z;
}

}  // namespace lcpbench
