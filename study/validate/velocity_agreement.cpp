#include "study/validate/velocity_agreement.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

namespace lcpbench {

bool VelocityAgreement::applies(const Problem& problem, bool definite) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr || !definite || contact->frictional() || contact->has_rows() || contact->ngc() == 0 ||
      contact->ngc() > kLargest) {
    return false;
  }
  // If all contacts yield, `definite` says nothing of the inertia. Soft contacts are compared only where G is given.
  return !contact->is_soft() || std::holds_alternative<DenseInertia>(contact->inertia) ||
         std::holds_alternative<BlockInertia>(contact->inertia);
}

VelocityAgreement::VelocityAgreement(const Problem& problem) : problem_(problem) {
  const ContactProblem& contact = *problem.contact();
  const auto* given = std::get_if<InverseInertia>(&contact.inertia);
  inverse_ = given != nullptr;
  const Matrix matrix = inverse_ ? given->Ginv : dense_inertia(contact.inertia);
  factor_ = Eigen::LLT<Matrix>(matrix).matrixL();
  const Eigen::SelfAdjointEigenSolver<Matrix> spectrum(matrix, Eigen::EigenvaluesOnly);
  const double least = spectrum.eigenvalues().minCoeff();
  const double largest = spectrum.eigenvalues().maxCoeff();
  // Where rounding leaves no smallest eigenvalue above 0, nothing can be said to differ.
  const double condition = least > 0 ? largest / least : std::numeric_limits<double>::max();
  rounding_ = static_cast<double>(contact.ngc()) * std::numeric_limits<double>::epsilon() * condition;
  mobility_ = inverse_ ? std::sqrt(largest) : std::sqrt(condition) / std::sqrt(largest);
  velocity_before_ = whiten(contact.v).norm();
}

// G = L L': ||u||_G = |L'u|. G* = L L': ||u||_G = |L^-1 u|.
Vector VelocityAgreement::whiten(const Vector& velocity) const {
  const auto lower = factor_.triangularView<Eigen::Lower>();
  return inverse_ ? Vector(lower.solve(velocity)) : Vector(lower.transpose() * velocity);
}

VelocityAgreement::Side VelocityAgreement::side(const Answer& answer, const Errors& errors) const {
  const ContactProblem& contact = *problem_.contact();
  const Vector implied = post_impact_velocity(contact, answer.z);
  Side side;
  side.velocity = whiten(answer.velocity.size() == contact.ngc() ? answer.velocity : implied);
  side.impulses = answer.z.cwiseAbs().sum();
  const Matrix normals = to_dense(contact.N);
  side.cancelled = mobility_ * normals.colwise().norm().dot(answer.z.cwiseAbs());
  Vector slacks = normals.transpose() * implied;
  if (contact.has_offset()) slacks += contact.b;
  if (contact.compliance_n.size() > 0) slacks += contact.compliance_n.cwiseProduct(answer.z.head(contact.nc()));
  side.slacks = slacks.cwiseAbs().sum();
  side.complementarity = std::fabs(errors.complementarity_j);
  side.violation = errors.violation_m_per_s;
  side.negativity = std::max(0.0, -errors.min_z);
  return side;
}

bool VelocityAgreement::agree(const Side& a, const Side& b) const {
  const double gap = a.complementarity + b.complementarity + a.impulses * b.violation + b.impulses * a.violation +
                     a.negativity * b.slacks + b.negativity * a.slacks;
  const double rounding = rounding_ * (velocity_before_ + a.velocity.norm() + b.velocity.norm()) +
                          static_cast<double>(problem_.contact()->nc()) * std::numeric_limits<double>::epsilon() *
                              (a.cancelled + b.cancelled);
  return (a.velocity - b.velocity).norm() <= std::sqrt(gap) + rounding;
}

}  // namespace lcpbench
