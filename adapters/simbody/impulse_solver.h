#pragma once

// SimTK::ImpulseSolver behind plain data. Simbody's headers do not compile as C++20, so impulse_solver.cpp is C++17 and
// includes nothing of this project but this file.

#include <vector>

namespace lcpbench::simbody {

enum class Method { kPgs, kPlus };

/// A contact's normal row; with friction the next two rows are its tangents.
struct Contact {
  int normal_row = 0;
  bool friction = false;
  double mu = 0;
};

struct Request {
  Method method = Method::kPgs;
  double tolerance = 0;
  int max_iterations = 0;
  double slip_speed = 0;
};

/// W r + q = u for m rows. `W` is symmetric, m x m. Writes r. @returns the library's word for success. @throws what
/// Simbody throws, a std::exception.
bool solve(const Request& request, const std::vector<Contact>& contacts, int m, const double* W, const double* q,
           double* r);

}  // namespace lcpbench::simbody
