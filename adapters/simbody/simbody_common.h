#pragma once

// Shared by the Simbody adapters: one of Simbody's impulse solvers on a problem, without a Simbody system.

#include "adapters/define_adapter.h"

#ifndef LCPBENCH_DESCRIBE_ONLY
#include <exception>
#include <vector>

#include "adapters/round_cone.h"
#include "adapters/simbody/impulse_solver.h"
#endif

namespace lcpbench {

inline constexpr const char* kConeHelp =
    "solve contacts with friction with the round cone, which is another problem; false: refuse them";

template <class Settings>
class SimbodySolver;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// Settings: a struct with `cone`, a function request(), and a static member `capabilities`.
template <class Settings>
class SimbodySolver final : public Solver {
 public:
  explicit SimbodySolver(const Settings& settings) : settings_(settings) {}
  const Capabilities& capabilities() const override {
    return settings_.cone ? kConeCapabilities : Settings::capabilities;
  }

 protected:
  void on_load(const Problem& problem) override {
    refusal_ = cones_.load(problem, RoundCones::Frictionless::kOneRow);
    if (!refusal_.empty()) return;
    contacts_.clear();
    for (Index i = 0; i < cones_.contacts(); ++i) {
      contacts_.push_back({static_cast<int>(cones_.normal_row(i)), cones_.has_tangents(i), cones_.mu(i)});
    }
    r_.resize(cones_.q().size());
  }

  void on_solve(const SolveRequest&, Answer& answer) override {
    if (!refusal_.empty()) {
      answer.claim = Claim::kUnsupported;
      answer.detail = refusal_;
      return;
    }
    if (contacts_.empty()) {
      answer.claim = Claim::kSolved;
      return;
    }
    try {
      const bool solved = simbody::solve(settings_.request(), contacts_, static_cast<int>(r_.size()), cones_.W().data(),
                                         cones_.q().data(), r_.data());
      answer.claim = solved ? Claim::kSolved : Claim::kNumericalFailure;
    } catch (const std::exception& error) {
      answer.detail = error.what();
      return;
    }
    cones_.write(r_, answer.z);
    if (cones_.frictional()) {
      answer.detail = "another problem: the round friction cone";
    } else if (answer.claim != Claim::kSolved) {
      answer.detail = "solve returned false";
    }
  }

 private:
  static constexpr Capabilities kConeCapabilities{.guarantees = Settings::capabilities.guarantees};

  Settings settings_;
  std::string refusal_;
  RoundCones cones_;
  std::vector<simbody::Contact> contacts_;
  Vector r_;
};

#endif

/// Completes a definition with the capabilities that stand in its settings.
template <class Settings>
SolverDefinition define_simbody(SolverDefinition definition) {
  definition.capabilities = Settings::capabilities;
  return define_adapter<SimbodySolver<Settings>, Settings>(std::move(definition));
}

}  // namespace lcpbench
