#pragma once

#include <memory>
#include <optional>

#include "study/certificates/certificate_table.h"
#include "study/certify/certificate.h"

namespace lcpbench {

/// Decides in exact arithmetic whether a problem has a solution, if a solver claims without proof that it has none.
///
/// Use one object for each thread. Its result is the truth for all answers to the problem.
class Settler {
 public:
  /// Larger problems are not tried.
  static constexpr Index kLargestOrder = 32;
  /// For each problem.
  static constexpr double kTimeLimitS = 0.25;

  Settler();
  ~Settler();

  /// Whether an answer asks for it: it claims unsolvable, and its proof, if there is one, does not hold.
  static bool asked_by(Claim claim, bool farkas_checked) { return claim == Claim::kUnsolvable && !farkas_checked; }

  /// The certificate of the problem; nullopt if nothing is proven within the limits above.
  std::optional<Certificate> settle(const Problem& problem);
  /// The same as a store keeps it.
  std::optional<CertificateRow> settle_row(const Problem& problem);

 private:
  std::unique_ptr<Certifier> certifier_;
};

}  // namespace lcpbench
