#include "study/stability/physical_answer.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <limits>

#include "study/inspect/contact_facts.h"
#include "study/inspect/spectra.h"

namespace lcpbench {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

double contact_condition(const Problem& problem) {
  const ContactProblem& contact = *problem.contact();
  const auto* inverse = std::get_if<InverseInertia>(&contact.inertia);
  const Matrix inertia = inverse != nullptr ? inverse->Ginv : dense_inertia(contact.inertia);
  const std::vector<Index> rows = independent_rows(contact);
  return std::max(visible_condition(inertia), visible_condition(problem.lcp().M(rows, rows)));
}

}  // namespace

Judge::Judge(const Problem& problem) : problem_(problem), evaluator_(problem) {
  if (problem.contact() == nullptr) return;
  inertia_ = std::make_unique<QuadInertia>(problem.contact()->inertia);
  if (inertia_->well_defined()) lcp_ = std::make_unique<ContactQuadLcp>(*problem_.contact(), *inertia_);
}

bool Judge::proves_unsolvable(const Answer& answer) const {
  return answer.farkas.size() > 0 && evaluator_.check_farkas(answer.farkas);
}

Vector Judge::physical_answer(const Answer& answer) {
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
    if (unique_) condition_ = visible_condition(M / 2 + M.transpose() / 2);
    return;
  }
  const ContactProblem& contact = *problem.contact();
  if (!unique_) {
    factor_ = to_dense(contact.N).transpose();
    scale_ = problem.lcp().q.cwiseAbs().maxCoeff();
    return;
  }
  const auto* inverse = std::get_if<InverseInertia>(&contact.inertia);
  inverse_ = inverse != nullptr;
  factor_ = Eigen::LLT<Matrix>(inverse_ ? inverse->Ginv : dense_inertia(contact.inertia)).matrixL();
  scale_ = coordinates(contact.v).norm();
  condition_ = contact_condition(problem);
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
  return to_double(quotient(unique_ ? moved.norm() : moved.cwiseAbs().maxCoeff(), scale_));
}

double visible_condition(const Matrix& symmetric) {
  if (symmetric.rows() == 0) return 1;
  const Vector values =
      Eigen::SelfAdjointEigenSolver<Matrix>(unit_diagonal(symmetric), Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = values(values.size() - 1);
  const double cut = static_cast<double>(values.size()) * kEps * largest;
  for (const double value : values) {
    if (value > cut) return largest / value;
  }
  return 1;
}

}  // namespace lcpbench
