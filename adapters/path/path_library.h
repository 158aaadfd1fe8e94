#pragma once

#include <string>

#include "core/solver.h"

/// PATH's C interface, as far as we use it, behind a library that is opened at run time.
///
/// The declarations follow PATH's published headers (MCP_Interface.h, Options.h, Output_Interface.h, Types.h). PATH
/// keeps its state in globals: one library per process, one thread.
namespace lcpbench::path {

/// PATH's value for infinity.
inline constexpr double kInfinity = 1e20;

/// MCP_Interface. Builds of PATH differ in whether a slot for second derivatives follows `jacobian`; all slots after it
/// are optional, and empty here, so that both read the same.
struct McpInterface {
  void* data = nullptr;
  void (*problem_size)(void* data, int* n, int* entries) = nullptr;
  void (*bounds)(void* data, int n, double* start, double* lower, double* upper) = nullptr;
  int (*function)(void* data, int n, double* z, double* f) = nullptr;
  int (*jacobian)(void* data, int n, double* z, int wants_f, double* f, int* entries, int* starts, int* lengths,
                  int* rows, double* values) = nullptr;
  void* optional[6] = {};
};

/// PATH's options that are not at PATH's defaults.
struct Options {
  double tolerance = 0;
  int major_iterations = 0;
  double time_limit_s = 0;  ///< may be infinite
};

/// Opens the library that PATH_LIBRARY names, once per process: its output silenced, its licence string set from
/// PATH_LICENSE_STRING if there is one. A relative file name is relative to the folder that lcpbench was started in.
/// @throws InputError when there is none, it does not open, or it lacks an entry point.
void open_library();

/// Solves one problem with n variables and this number of nonzeros, from the start that `callbacks` gives; fills in
/// claim, z, counters and detail. kUnsupported where the licence does not cover these numbers.
/// @pre n > 0; answer.z has n entries. @throws as open_library(), and std::runtime_error when PATH does not take an
/// option.
void solve(McpInterface& callbacks, int n, int entries, const Options& options, Answer& answer);

}  // namespace lcpbench::path
