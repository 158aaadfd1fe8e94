#include "native/auto/dense_methods.h"

namespace lcpbench {

bool DenseMethods::take(AutoMethod method, const Problem& problem) const {
  const ContactProblem& contact = *problem.contact();
  if (contact.ngc() * (contact.ngc() + contact.nc()) > kMostEntries) return false;
  if (method == AutoMethod::kContactLemke) return takes(contact_lemke_, problem);
  return method == AutoMethod::kActiveSet && takes(active_set_, problem);
}

std::optional<AutoMethod> DenseMethods::after(AutoMethod method, const Problem& problem) const {
  if (method == AutoMethod::kContactLemke) return std::nullopt;
  const AutoMethod next = method == AutoMethod::kVelocityIpm ? AutoMethod::kActiveSet : AutoMethod::kContactLemke;
  return take(next, problem) ? std::optional(next) : std::nullopt;
}

void DenseMethods::reserve(AutoMethod method, const Problem& problem) {
  for (std::optional<AutoMethod> next = method; next; next = after(*next, problem)) {
    if (*next == AutoMethod::kActiveSet) {
      active_set_.reserve(problem);
    } else {
      contact_lemke_.reserve(problem);
    }
  }
}

Solver& DenseMethods::solver(AutoMethod method) {
  if (method == AutoMethod::kActiveSet) return active_set_;
  return contact_lemke_;
}

void DenseMethods::solve(AutoMethod method, const Problem& problem, const Vector& v, const Vector* start,
                         const AutoLimits& limits, Answer& answer, AutoReport& report) {
  for (std::optional<AutoMethod> next = method; next; next = after(*next, problem)) {
    solver(*next).load(problem);
    solver(*next).update(v);
    run_method(*next, solver(*next), {.start = start, .time_limit_s = limits.time()}, limits, answer, report);
    if (!gave_up(answer.claim, limits.max_pivots)) return;
  }
}

}  // namespace lcpbench
