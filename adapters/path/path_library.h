#pragma once

#include <string>

#include "core/solver.h"

/// The part of PATH's C interface that the solver `path` uses. PATH is a library that is opened at run time.
///
/// The declarations follow PATH's published headers (MCP_Interface.h, Options.h, Output_Interface.h, Types.h). PATH
/// keeps its state in globals: one library per process, one thread.
namespace lcpbench::path {

/// Bounds of this size mean none to PATH.
inline constexpr double kInfinity = 1e20;

/// MCP_Interface: the callbacks of a problem. `entries` are nonzeros of the Jacobian, which `jacobian` writes by
/// columns, with starts and rows counted from 1. `function` and `jacobian` return the number of domain errors. Builds
/// of PATH differ in whether a slot for second derivatives follows `jacobian`. All slots after `jacobian` are optional,
/// and null here, so that this struct serves both.
struct McpInterface {
  void* data = nullptr;
  void (*problem_size)(void* data, int* n, int* entries) = nullptr;
  void (*bounds)(void* data, int n, double* start, double* lower, double* upper) = nullptr;
  int (*function)(void* data, int n, double* z, double* f) = nullptr;
  int (*jacobian)(void* data, int n, double* z, int wants_f, double* f, int* entries, int* starts, int* lengths,
                  int* rows, double* values) = nullptr;
  void* optional[6] = {};
};

/// The options that solve() sets. It also silences PATH's output; all other options keep PATH's defaults.
struct Options {
  double tolerance = 0;      ///< convergence_tolerance
  int major_iterations = 0;  ///< major_iteration_limit
  double time_limit_s = 0;   ///< may be infinite; PATH is given 1e6 s at most
};

/// Opens the library that PATH_LIBRARY names, once per process: its output silenced, its licence string set from
/// PATH_LICENSE_STRING if there is one. A relative name with a folder is relative to the folder that lcpbench was
/// started in; the dynamic linker looks for a name without a folder.
/// @throws InputError when PATH_LIBRARY is not set, the library does not open, or it lacks an entry point.
void open_library();

/// Solves one problem with n variables and `entries` nonzeros, from the start that `callbacks` gives; fills in claim,
/// z, counters and detail. kUnsupported, with z unchanged, where the licence does not cover these numbers.
/// @pre n > 0; answer.z has n entries. @throws as open_library(), and std::runtime_error when PATH does not take an
/// option.
void solve(McpInterface& callbacks, int n, int entries, const Options& options, Answer& answer);

}  // namespace lcpbench::path
