#include "study/certificates/settle.h"

#include <exception>
#include "study/certificates/certify_store.h"

namespace lcpbench {

Settler::Settler() = default;
Settler::~Settler() = default;

std::optional<Certificate> Settler::settle(const Problem& problem) {
  if (problem.size() > kLargestOrder) return std::nullopt;
  if (certifier_ == nullptr) certifier_ = std::make_unique<Certifier>(CertifyOptions{.time_limit_s = kTimeLimitS});
  try {
    Certificate certificate = certifier_->certify(problem);
    if (certificate.kind != CertificateKind::kOpen) return certificate;
  } catch (const std::exception&) {  // data that are not finite, memory: nothing is proven
  }
  return std::nullopt;
}

std::optional<CertificateRow> Settler::settle_row(const Problem& problem) {
  const std::optional<Certificate> certificate = settle(problem);
  if (!certificate) return std::nullopt;
  CertificateRow row = certificate_row(problem, *certificate, kTimeLimitS);
  if (row.kind == CertificateKind::kOpen) return std::nullopt;
  return row;
}

}  // namespace lcpbench
