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

struct Options {
  double tolerance = 1e-6;
  int major_iterations = 500;
  double time_limit_s = 0;  ///< may be infinite
};

class PathLibrary {
 public:
  /// The library that PATH_LIBRARY names; opened once per process, its output silenced, its licence string set from
  /// PATH_LICENSE_STRING if there is one. A relative file name is relative to the folder that lcpbench was started in.
  /// @throws InputError when there is none, it does not open, or it lacks an entry point.
  static PathLibrary& of_user();

  PathLibrary(const PathLibrary&) = delete;
  PathLibrary& operator=(const PathLibrary&) = delete;

  /// "Path 5.0.03": name and number as the library gives them.
  const std::string& version() const { return version_; }

  /// Everything at PATH's defaults but these. @throws std::runtime_error when PATH does not take one.
  void set_options(const Options& options);

  /// Whether the licence covers a problem with n variables and this number of nonzeros.
  bool licensed(int n, int entries);

  /// Solves one problem from the start that `callbacks` gives; fills in claim, z, counters and detail.
  /// @pre set_options() was called; n > 0; answer.z has n entries.
  void solve(McpInterface& callbacks, int n, int entries, Answer& answer);

 private:
  struct EntryPoints;
  explicit PathLibrary(const std::string& file);

  EntryPoints* call_;  ///< lives as long as the process, as the library does
  std::string version_;
  void* options_ = nullptr;
};

}  // namespace lcpbench::path
