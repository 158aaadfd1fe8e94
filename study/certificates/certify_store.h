#pragma once

#include <csignal>
#include <cstdint>
#include <functional>

#include "study/certificates/certificate_table.h"

namespace lcpbench {

/// Certifies one problem.
using CertifyProblem = std::function<Certificate(const Problem&)>;

struct CertifyRun {
  CertifyScope scope;
  int jobs = 1;
  /// Makes what one thread certifies with; called in that thread.
  std::function<CertifyProblem()> open;
  /// Set to non-zero from outside (a signal handler) to end in good order.
  const volatile std::sig_atomic_t* stop = nullptr;
  /// Called by the thread that called certify_store, some ten times a second.
  std::function<void(std::int64_t done, std::int64_t total)> on_progress;
};

struct CertifyOutcome {
  std::int64_t done = 0;   ///< problems that this call finished
  std::int64_t total = 0;  ///< problems that it had to do
};

/// What every answer violates some contact or bounded row by, at least (core/answer/farkas.h), from the exact u of a
/// proof kFarkas; NaN for other proofs and bare LCPs. [m/s, rad/s]
double least_violation(const Problem& problem, const Certificate& certificate);

/// Of a proof that a bare LCP has no solution, lcpbench::proof_margin(), rounded; NaN for all else.
double proof_margin(const Problem& problem, const Certificate& certificate);

/// The row of a certificate; an open one where no problem file can hold the problem: nobody could check the proof.
CertificateRow certificate_row(const Problem& problem, const Certificate& certificate, double time_limit_s);

/// Certifies the problems of a store that have no certificate yet, keeps proofs with their problems, and evaluates the
/// forward errors of the stored answers wherever only one velocity is right. Nothing is solved again.
///
/// A problem is made again from its set, seed and trial, and must have the hash that the store has. `jobs` threads take
/// problems from one queue; the calling thread alone writes, in transactions of at most about a second. A call that
/// ends early, in whatever way, loses the problems in flight and what was not yet committed of that second; the next
/// call does the rest. The rows are the same for any number of threads, but for `certificate_timings` and what the time
/// limit left open.
/// A problem that its certifier throws for stays open, with the reason.
/// @throws InputError when a problem is not what it was, what generating or `open` throws, after committing what was
/// done.
CertifyOutcome certify_store(Store& store, const CertifyRun& run);

}  // namespace lcpbench
