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
  double tolerance = 0;    ///< kPgs: on the root mean square of active rows' velocities [m/s]; kPlus: of Newton steps
  int max_iterations = 0;  ///< kPgs: sweeps; kPlus: Newton steps
  double slip_speed = 0;   ///< kPlus: a contact that begins slower may roll [m/s]; kPgs does not use it
};

/// Solves W r + q = u for m rows: r and u are complementary in normal rows, and |r_t| <= mu r_N on their tangents. `W`
/// is symmetric, m x m. Writes r, also on failure. @returns whether the library reports success.
/// @throws what Simbody throws, a std::exception.
bool solve(const Request& request, const std::vector<Contact>& contacts, int m, const double* W, const double* q,
           double* r);

}  // namespace lcpbench::simbody
