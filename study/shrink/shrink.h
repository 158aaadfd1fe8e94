#pragma once

#include <csignal>
#include <cstdint>
#include <functional>

#include "core/problem.h"

namespace lcpbench {

/// How large a problem is, and how long its numbers are.
struct ProblemSize {
  Index contacts = 0;  ///< of a bare LCP: rows
  Index rows = 0;      ///< bounded rows of a contact problem
  Index bodies = 0;    ///< of a contact problem: coordinates; of a bare LCP 0
  Index friction_edges = 0;
  Index numbers = 0;  ///< that are not zero, without the normals and tangents of a scene
  Index digits = 0;   ///< significant decimal digits of all of them together
};

ProblemSize problem_size(const Problem& problem);

struct ShrinkOptions {
  double budget_s = 120;                             ///< wall clock, after which no problem is tried any more
  const volatile std::sig_atomic_t* stop = nullptr;  ///< raised: the same
  /// Called before each try with the smallest problem so far and the number of tries.
  std::function<void(const Problem& smallest, std::int64_t tries)> progress = {};
};

struct Shrunk {
  Problem problem;
  std::int64_t tries = 0;
  bool complete = false;  ///< nothing more can be left out or made rounder; false: time or `stop` ended it
};

/// Looks for the smallest problem of the same kind that still fails: delta debugging over contacts, bounded rows, bodies
/// (or coordinates), factors of the inertia, frictional contacts and friction edges; then rounder numbers; all of it
/// again until nothing changes.
///
/// Every problem tried has been written as a problem file's text and read again, so that what fails is what the file
/// holds. One that no problem file may hold (an inertia that is not positive definite, ...) counts as one that does
/// not fail, and so does one with more columns of N, D and R that are zero. Without the end of the budget the result
/// is a function of the problem and of `fails`.
/// @pre start, read from a problem file, fails
Shrunk shrink(const Problem& start, const std::function<bool(const Problem&)>& fails, const ShrinkOptions& options);

}  // namespace lcpbench
