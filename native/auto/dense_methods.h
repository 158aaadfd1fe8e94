#pragma once

#include <memory>
#include <optional>

#include "core/problem.h"
#include "native/active_set/active_set.h"
#include "native/auto/methods.h"
#include "native/contact_lemke/contact_lemke.h"

namespace lcpbench {

/// The dense methods, for whole problems and for whatever another method gave up on.
///
/// What solve() needs is loaded there, one problem after the other, with memory that was taken before: that of the
/// largest problem so far, most of which is never touched.
class DenseMethods {
 public:
  DenseMethods()
      : later_(std::make_shared<LaterEngines>()),
        active_set_(ActiveSetSettings{}),
        contact_lemke_(ContactLemkeSettings{}, later_) {}

  /// What follows `method` on this problem: contact_lemke after active_set and friction_ipm, active_set after
  /// velocity_ipm, up to what take() says.
  std::optional<AutoMethod> after(AutoMethod method, const Problem& problem) const;

  /// Whether solve(method, problem, ...) is possible: the method is dense, and the problem not too large.
  bool take(AutoMethod method, const Problem& problem) const;

  /// Takes the memory for solve(method, problem, ...).
  void reserve(AutoMethod method, const Problem& problem);

  /// Solves by `method`, and where that gives up by what follows it. Allocates nothing.
  /// @param v of the problem now @param start SolveRequest::start @pre reserve(method, problem)
  void solve(AutoMethod method, const Problem& problem, const Vector& v, const Vector* start, const AutoLimits& limits,
             Answer& answer, AutoReport& report);

  /// With the problem of the last solve() that tried it, or with what the caller loads. @pre the method is dense
  Solver& solver(AutoMethod method);
  ContactLemke& contact_lemke() { return contact_lemke_; }
  /// What the rungs beyond double run on, for all islands: they take turns.
  const std::shared_ptr<LaterEngines>& later_engines() const { return later_; }

 private:
  /// ngc (ngc + nc) of a problem up to which memory is taken in advance: half a gigabyte of addresses.
  static constexpr Index kMostEntries = 1'000'000;

  std::shared_ptr<LaterEngines> later_;
  ActiveSet active_set_;
  ContactLemke contact_lemke_;
};

}  // namespace lcpbench
