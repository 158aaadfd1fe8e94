#pragma once

#include <memory>
#include <optional>

#include "study/certificates/certificate_table.h"
#include "study/certify/certificate.h"

namespace lcpbench {

/// Settles by exact arithmetic whether a problem has a solution where a solver denies it and shows no proof.
///
/// One for each thread. What it finds is the truth for all answers to the problem, whoever asked.
class Settler {
 public:
  /// Larger problems are left alone.
  static constexpr Index kLargestOrder = 32;
  /// For each problem.
  static constexpr double kTimeLimitS = 0.25;

  Settler();
  ~Settler();

  /// Whether an answer asks for it: it claims unsolvable, and its proof, if there is one, does not hold.
  static bool asked_by(Claim claim, bool farkas_checked) { return claim == Claim::kUnsolvable && !farkas_checked; }

  /// What is proven of the problem; nullopt where that is nothing within the limits above.
  std::optional<Certificate> settle(const Problem& problem);
  /// The same as a store keeps it.
  std::optional<CertificateRow> settle_row(const Problem& problem);

 private:
  std::unique_ptr<Certifier> certifier_;
};

}  // namespace lcpbench
