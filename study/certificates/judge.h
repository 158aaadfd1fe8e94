#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>

#include "study/certify/certificate.h"
#include "study/evaluation/evaluation.h"
#include "study/evaluation/friction_model.h"

namespace lcpbench {

/// Settles by exact arithmetic whether a problem has a solution. What it finds does not depend on the machine's speed.
/// One for each thread.
class BoundedCertifier {
 public:
  /// Problems with more contacts and bounded rows, rows of a bare LCP, or coordinates are left alone.
  static constexpr Index kMostRows = 32;
  static constexpr Index kMostCoordinates = 64;
  /// For each problem: see CertifyOptions::most_work. Mostly below half a second; numbers that span hundreds of
  /// binary orders can take seconds.
  static constexpr std::int64_t kMostWork = 100000;

  /// What is proven of the problem; nullopt where that is nothing within the limits above.
  std::optional<Certificate> certify(const Problem& problem);
  /// With ten times the work: enough to try every basis of Certifier::kFewUnknowns.
  std::optional<Certificate> certify_longer(const Problem& problem);

 private:
  std::optional<Certificate> certify(const Problem& problem, Certifier& certifier);

  std::unique_ptr<Certifier> certifier_;
};

/// Judges the answers to one problem, equal ones once, and collects what they and exact arithmetic tell of it. Where
/// theory does not decide the problem, an answer that denies a solution without a valid proof, or brings a vector that
/// is no proof, of whatever friction model, has it settled within the limits of BoundedCertifier; what is found is the
/// truth for all answers. Not in study/evaluation, which knows no solver: a Certifier's candidates come from solvers.
class Judge {
 public:
  /// Both must outlive this object. @param solved_at  the verdict's bound, instead of that of the problem's kind
  Judge(const Problem& problem, BoundedCertifier& certifier, std::optional<double> solved_at = std::nullopt);

  /// An answer to another model than the pyramid is measured by that model, and does not count as evidence of the
  /// problem.
  /// @returns the number of the answer among those that differ in a bit of a vector, or in their model: 0 for the
  /// first, 1 for the next
  std::size_t judge(const Answer& answer, FrictionModel model = FrictionModel::kPyramid);
  /// Settles the problem all the same if it has at most Certifier::kFewUnknowns and nothing is known of it.
  void settle_few_unknowns();
  const Judgement& judgement(std::size_t number) const { return distinct_[number].judgement; }

  /// All that is known of the problem by now.
  const Findings& findings() const { return findings_; }
  /// What settling it has proven; nullopt where it was not tried, or proved nothing.
  const std::optional<Certificate>& certificate() const { return certificate_; }

 private:
  struct Distinct {
    Vector z, velocity, farkas;
    FrictionModel model;
    bool is_refusal;  ///< no answer, although that to a problem without unknowns has no numbers either
    Judgement judgement;
  };

  std::size_t find_or_judge(const Answer& answer, FrictionModel model);
  Judgement judge_alone(const Answer& answer, FrictionModel model);
  void settle(std::optional<Certificate> certificate);

  const Problem& problem_;
  BoundedCertifier& certifier_;
  std::optional<double> solved_at_;
  Evaluator evaluator_;
  Findings findings_;
  std::deque<Distinct> distinct_;
  bool settled_ = false;
  std::optional<Certificate> certificate_;
};

}  // namespace lcpbench
