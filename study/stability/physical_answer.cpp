#include "study/stability/physical_answer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "study/inspect/contact_facts.h"
#include "study/inspect/spectra.h"

namespace lcpbench {
namespace {

double contact_condition(const ContactProblem& contact) {
  const auto* inverse = std::get_if<InverseInertia>(&contact.inertia);
  const Matrix inertia = inverse != nullptr ? inverse->Ginv : dense_inertia(contact.inertia);
  const double of_matrix = contact_facts(contact).condition;
  return std::isnan(of_matrix) ? scaled_condition(inertia) : std::max(scaled_condition(inertia), of_matrix);
}

}  // namespace

PhysicalAnswers::PhysicalAnswers(const Problem& problem) : problem_(problem) {
  if (problem.contact() == nullptr) return;
  inertia_ = std::make_unique<QuadInertia>(problem.contact()->inertia);
  if (inertia_->well_defined()) lcp_ = std::make_unique<ContactQuadLcp>(*problem_.contact(), *inertia_);
}

Vector PhysicalAnswers::of(const Answer& answer) {
  if (problem_.contact() == nullptr) return answer.z;
  if (answer.velocity.size() == problem_.contact()->ngc()) return answer.velocity;
  const QuadVector velocity = lcp_->response(QuadVector(answer.z.begin(), answer.z.end()));
  Vector rounded(static_cast<Index>(velocity.size()));
  std::transform(velocity.begin(), velocity.end(), rounded.begin(), [](Quad x) { return to_double(x); });
  return rounded;
}

Distance::Distance(const Problem& problem, bool unique) : unique_(unique), bare_(problem.contact() == nullptr) {
  if (bare_) {
    const Matrix& M = problem.lcp().M;
    if (unique_) condition_ = scaled_condition(M / 2 + M.transpose() / 2);
    return;
  }
  const ContactProblem& contact = *problem.contact();
  if (!unique_) {
    factor_ = to_dense(contact.N).transpose();
    scale_ = problem.lcp().q.lpNorm<Eigen::Infinity>();
    return;
  }
  const auto* inverse = std::get_if<InverseInertia>(&contact.inertia);
  inverse_ = inverse != nullptr;
  factor_ = Eigen::LLT<Matrix>(inverse_ ? inverse->Ginv : dense_inertia(contact.inertia)).matrixL();
  scale_ = coordinates(contact.v).norm();
  condition_ = contact_condition(contact);
}

// G = L L': ||u||_G = |L'u|. G* = L L': ||u||_G = |L^-1 u|.
Vector Distance::coordinates(const Vector& difference) const {
  if (!unique_) return factor_ * difference;
  const auto lower = factor_.triangularView<Eigen::Lower>();
  return inverse_ ? Vector(lower.solve(difference)) : Vector(lower.transpose() * difference);
}

double Distance::operator()(const Vector& a, const Vector& b) const {
  const Vector difference = b - a;
  if (difference.size() == 0) return 0;
  if (bare_) return to_double(quotient(difference.cwiseAbs().maxCoeff(), a.cwiseAbs().maxCoeff()));
  const Vector moved = coordinates(difference);
  return to_double(quotient(unique_ ? moved.norm() : moved.lpNorm<Eigen::Infinity>(), scale_));
}

double scaled_condition(const Matrix& symmetric) {
  const Spectrum spectrum = symmetric.rows() <= kLargestQuad ? spectrum_of(unit_diagonal(QuadMatrix(symmetric)), 0)
                                                             : spectrum_of(unit_diagonal(symmetric));
  return spectrum.rank > 0 ? spectrum.largest / spectrum.smallest_nonzero : 1;
}

}  // namespace lcpbench
