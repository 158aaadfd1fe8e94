#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "study/certify/certificate.h"
#include "study/store/store.h"

namespace lcpbench {

/// Which problems of a store are to be certified.
struct CertifyScope {
  std::vector<std::string> sets;  ///< names as the store has them; empty: all
  /// Of the frictional problems, only trials that are multiples of this number. All others are taken.
  std::int64_t every = 1;
  double time_limit_s = 10;  ///< for each problem; problems left open by a shorter limit are tried again
};

/// A problem that still needs work.
struct CertifyTask {
  std::int64_t problem_id = 0;
  std::string set;
  std::uint64_t seed = 0;
  std::int64_t trial = 0;
  std::string hash;
  bool certify = false;  ///< it has no certificate, or one that a shorter time limit left open
};

/// A certificate as a store keeps it.
struct CertificateRow {
  CertificateKind kind = CertificateKind::kOpen;
  ProofKind proof = ProofKind::kNone;
  Vector velocity;
  std::optional<bool> velocity_unique;
  double least_violation_m_per_s = 0;  ///< NaN where nothing is known of it
  double proof_margin = 0;             ///< likewise
  std::string detail;
  double seconds = 0;
  double time_limit_s = 0;
  std::string document;  ///< deflated; empty where open
};

/// The forward error of one answer to a problem, and which answer that is.
struct ForwardError {
  std::int64_t solver_id = 0;
  std::int64_t part = 0;
  double forward_velocity = 0;  ///< see Errors::forward_velocity; NaN: none
};

/// Counts of a set's certificates.
struct CertifiedSet {
  std::string set;
  bool frictional = false;  ///< some problem is
  std::int64_t problems = 0;
  std::int64_t solution = 0;
  std::int64_t unsolvable = 0;
  std::int64_t open = 0;
  double seconds_mean = 0;  ///< wall clock; NaN for none certified
  double seconds_max = 0;
  std::int64_t other_velocity = 0;  ///< solutions of which a second velocity is certified
  std::int64_t answers = 0;         ///< to certified problems, by any solver; equal ones of a sweep count once
  std::int64_t verified = 0;        ///< those that pass the evaluation, by their own model of friction
  std::int64_t forward = 0;         ///< answers with a certified forward error

  std::int64_t certified() const { return solution + unsolvable + open; }
};

/// Certificates, proofs and forward errors in a store. For the thread that writes the store.
class CertificateTable {
 public:
  explicit CertificateTable(Store& store) : store_(store) {}

  /// What is to be done, by trial: problems without certificate (or left open by a shorter time limit), and certified
  /// ones of one velocity with answers whose forward error is missing.
  std::vector<CertifyTask> pending(const CertifyScope& scope);

  bool has_proof(std::int64_t problem_id);
  /// Takes the place of what was left open. @pre a transaction is open.
  void add(std::int64_t problem_id, const CertificateRow& row);
  void add(std::int64_t problem_id, const std::vector<ForwardError>& errors);

  /// v*, where every solution of the problem is certified to have this velocity.
  std::optional<Vector> unique_velocity(std::int64_t problem_id);
  /// The usable answers to a problem that have no forward error yet.
  std::vector<ForwardError> answers_without_forward_error(std::int64_t problem_id);

  /// Every proof, inflated, by set, seed and trial. @throws InputError that names the store when one is damaged.
  void for_each_proof(const CertifyScope& scope, const std::function<void(std::string_view document)>& visit);

  std::vector<CertifiedSet> counts(const CertifyScope& scope);

  /// One line for each answer that cannot be as good as the evaluation found it when the certificate holds, and for
  /// each certificate that another proof contradicts; at most 100 lines.
  std::vector<std::string> contradictions(const CertifyScope& scope);

 private:
  Store& store_;
};

}  // namespace lcpbench
