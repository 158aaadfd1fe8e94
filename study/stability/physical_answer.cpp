#include "study/stability/physical_answer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "study/inspect/inspection.h"
#include "study/inspect/spectra.h"

namespace lcpbench {

PhysicalAnswers::PhysicalAnswers(const Problem& problem) : problem_(problem) {
  if (problem.contact() == nullptr) return;
  inertia_ = std::make_unique<RefinedInertia>(problem.contact()->inertia);
  if (inertia_->well_defined()) lcp_ = std::make_unique<ContactLcp>(*problem_.contact(), *inertia_);
}

Vector PhysicalAnswers::of(const Answer& answer) const {
  if (problem_.contact() == nullptr) return answer.z;
  if (answer.velocity.size() == problem_.contact()->ngc()) return answer.velocity;
  const QuadVector velocity = lcp_->response(QuadVector(answer.z.begin(), answer.z.end()));
  Vector rounded(static_cast<Index>(velocity.size()));
  std::transform(velocity.begin(), velocity.end(), rounded.begin(), [](Quad x) { return to_double(x); });
  return rounded;
}

double PhysicalAnswers::length(const Vector& velocity) const {
  if (const auto* inverse = std::get_if<InverseInertia>(&problem_.contact()->inertia)) {
    return Eigen::LLT<Matrix>(inverse->Ginv).matrixL().solve(velocity).norm();
  }
  const QuadVector x(velocity.begin(), velocity.end());
  const QuadVector weighted = inertia_->apply(x);
  Quad square = 0;
  for (std::size_t i = 0; i < x.size(); ++i) square += x[i] * weighted[i];
  return to_double(sqrt(square));
}

double PhysicalAnswers::change(const Vector& a, const Vector& b) const {
  if (a.size() == 0) return 0;
  const bool bare = problem_.contact() == nullptr;
  const double moved = bare ? (b - a).cwiseAbs().maxCoeff() : length(b - a);
  return to_double(
      quotient(moved, bare ? a.cwiseAbs().maxCoeff() : std::max(length(problem_.contact()->v), length(a))));
}

double PhysicalAnswers::condition() const {
  if (problem_.contact() == nullptr) {
    const Matrix& M = problem_.lcp().M;
    return scaled_condition(M / 2 + M.transpose() / 2);
  }
  const auto* inverse = std::get_if<InverseInertia>(&problem_.contact()->inertia);
  const double inertia =
      scaled_condition(inverse != nullptr ? inverse->Ginv : dense_inertia(problem_.contact()->inertia));
  return std::fmax(inertia, response_condition(*problem_.contact()));  // NaN, where it is not known, is passed over
}

double scaled_condition(const Matrix& symmetric) {
  const Spectrum spectrum = spectrum_of(unit_diagonal(QuadMatrix(symmetric)), 0);
  return spectrum.rank > 0 ? spectrum.largest / spectrum.smallest_nonzero : 1;
}

}  // namespace lcpbench
