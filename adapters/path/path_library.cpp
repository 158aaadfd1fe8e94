#include "adapters/path/path_library.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <utility>

#include <dlfcn.h>

#include "adapters/worker/start_directory.h"
#include "core/error.h"

namespace lcpbench::path {

namespace {

/// Output_Interface.
struct OutputInterface {
  void* data = nullptr;
  void (*print)(void* data, int mode, char* text) = nullptr;
  void (*flush)(void* data, int mode) = nullptr;
};

/// PATH's structure Information is some doubles and then ints, as PATH's Boolean is one. Places among the ints:
constexpr std::size_t kMajorIterations = 0;
constexpr std::size_t kMinorIterations = 1;
constexpr std::size_t kUseStart = 12;

/// How many ints fit into the doubles: six in version 5 (basis_time is the new one), five in earlier versions.
std::size_t ints_before(const std::string& version) {
  const auto digit = version.find_first_of("0123456789");
  const bool is_before_5 = digit != std::string::npos && std::atoi(version.c_str() + digit) < 5;
  return (is_before_5 ? 5U : 6U) * sizeof(double) / sizeof(int);
}

/// By MCP_Termination less 1. The licence error is 11 in PATH's older headers and 12 in those where 11 is MCP_Reduced;
/// the other meanings of 11 and 12 are of presolve, which nobody asks for here.
constexpr std::pair<Claim, const char*> kTerminations[] = {{Claim::kSolved, "solved"},
                                                           {Claim::kNumericalFailure, "no progress"},
                                                           {Claim::kIterationLimit, "major iteration limit"},
                                                           {Claim::kIterationLimit, "minor iteration limit"},
                                                           {Claim::kTimeLimit, "time limit"},
                                                           {Claim::kNumericalFailure, "user interrupt"},
                                                           {Claim::kNumericalFailure, "bound error"},
                                                           {Claim::kNumericalFailure, "domain error"},
                                                           {Claim::kUnsolvable, "infeasible"},
                                                           {Claim::kNumericalFailure, "error"},
                                                           {Claim::kUnsupported, "licence error"},
                                                           {Claim::kUnsupported, "licence error"}};

constexpr double kLongestTimeLimit_s = 1e6;

/// "Path 5.0.03 (Tue Jul 19 ...)" gives "Path 5.0.03".
std::string short_version(const char* text) {
  if (text == nullptr) return "Path";
  std::string version(text);
  version = version.substr(0, version.find('('));
  return version.substr(0, version.find_last_not_of(" \n") + 1);
}

/// Every `from` replaced by `to`.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// An opened library. The errors do not name the folder of its file, because reports show them.
struct Library {
  /// Becomes a pointer to a function of whatever type is asked for.
  struct Symbol {
    void* address;
    template <class Function>
    operator Function*() const {
      return reinterpret_cast<Function*>(address);
    }
  };

  explicit Library(const std::string& file)
      : name(std::filesystem::path(file).filename()), handle(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (handle == nullptr) throw InputError("PATH_LIBRARY: " + replaced(dlerror(), file, name));
  }
  Symbol find(const char* symbol) const {
    void* const address = dlsym(handle, symbol);
    if (address == nullptr) throw InputError("PATH_LIBRARY: " + name + " has no " + symbol);
    return {address};
  }

  std::string name;
  void* handle;
  const char* (*Path_Version)() = find("Path_Version");
  void (*Output_SetInterface)(OutputInterface*) = find("Output_SetInterface");
  void* (*Options_Create)() = find("Options_Create");
  void (*Path_AddOptions)(void* options) = find("Path_AddOptions");
  void (*Options_Default)(const void* options) = find("Options_Default");
  int (*Options_Set)(const void* options, const char* text) = find("Options_Set");
  int (*Options_SetInt)(const void* options, const char* name, int value) = find("Options_SetInt");
  int (*Options_SetDouble)(const void* options, const char* name, double value) = find("Options_SetDouble");
  int (*Options_GetInt)(const void* options, const char* name) = find("Options_GetInt");
  double (*Options_GetDouble)(const void* options, const char* name) = find("Options_GetDouble");
  int (*Path_CheckLicense)(int n, int entries) = find("Path_CheckLicense");
  /// Null without a licence string.
  int (*License_SetString)(const char* licence) =
      std::getenv("PATH_LICENSE_STRING") != nullptr ? find("License_SetString") : Symbol{nullptr};
  void* (*MCP_Create)(int n, int entries) = find("MCP_Create");
  void (*MCP_Jacobian_Structure_Constant)(void* mcp, int yes) = find("MCP_Jacobian_Structure_Constant");
  void (*MCP_SetInterface)(void* mcp, McpInterface* callbacks) = find("MCP_SetInterface");
  int (*Path_Solve)(void* mcp, void* information) = find("Path_Solve");
  double* (*MCP_GetX)(void* mcp) = find("MCP_GetX");
  void (*MCP_Destroy)(void* mcp) = find("MCP_Destroy");

  std::string version;  ///< "Path 5.0.03": name and number as the library gives them
  void* options = nullptr;
};

/// In the order that PATH asks for: first where output goes, then the options, then the rest. The version may be asked
/// first.
Library* start_library(const std::string& file) {
  static OutputInterface silence{nullptr, [](void*, int, char*) {}, [](void*, int) {}};
  auto path = std::make_unique<Library>(file);
  path->Output_SetInterface(&silence);
  path->version = short_version(path->Path_Version());
  path->options = path->Options_Create();
  path->Path_AddOptions(path->options);
  if (const char* licence = std::getenv("PATH_LICENSE_STRING")) path->License_SetString(licence);
  return path.release();
}

const Library& library() {
  const char* name = std::getenv("PATH_LIBRARY");
  if (name == nullptr || *name == '\0') throw InputError("PATH_LIBRARY is not set");
  std::filesystem::path file = name;
  if (file.has_parent_path() && file.is_relative()) file = start_directory() / file;
  static const Library* const started = start_library(file.string());  // lives as long as the process
  return *started;
}

void set_options(const Library& path, const Options& options) {
  const double time_limit_s = std::min(options.time_limit_s, kLongestTimeLimit_s);
  path.Options_Default(path.options);
  path.Options_Set(path.options, "output no");
  path.Options_SetDouble(path.options, "convergence_tolerance", options.tolerance);
  path.Options_SetDouble(path.options, "time_limit", time_limit_s);
  path.Options_SetInt(path.options, "major_iteration_limit", options.major_iterations);
  // The return values of the functions above are not documented. So read back what they stored.
  if (path.Options_GetDouble(path.options, "convergence_tolerance") != options.tolerance ||
      path.Options_GetDouble(path.options, "time_limit") != time_limit_s ||
      path.Options_GetInt(path.options, "major_iteration_limit") != options.major_iterations) {
    throw std::runtime_error(path.version + " did not take its options");
  }
}

}  // namespace

void open_library() { library(); }

void solve(McpInterface& callbacks, int n, int entries, const Options& options, Answer& answer) {
  const Library& path = library();
  set_options(path, options);
  if (path.Path_CheckLicense(n, entries) == 0) {
    answer.claim = Claim::kUnsupported;
    answer.detail = path.version + ": the licence does not cover n = " + std::to_string(n) + " with " +
                    std::to_string(entries) + " nonzeros; set PATH_LICENSE_STRING";
    return;
  }
  void* const mcp = path.MCP_Create(n, std::max(entries, 1));
  if (mcp == nullptr) {
    answer.detail = path.version + ": MCP_Create gave nothing";
    return;
  }
  path.MCP_Jacobian_Structure_Constant(mcp, 1);
  path.MCP_SetInterface(mcp, &callbacks);
  alignas(double) std::array<int, 128> information{};  // with room to spare, should a version write more
  int* const ints = information.data() + ints_before(path.version);
  ints[kUseStart] = 1;
  const int code = path.Path_Solve(mcp, information.data());
  if (const double* z = path.MCP_GetX(mcp)) answer.z = Eigen::Map<const Vector>(z, n);
  path.MCP_Destroy(mcp);

  answer.counters.iterations = ints[kMajorIterations];
  answer.counters.pivots = ints[kMinorIterations];
  answer.detail = path.version + ": unknown status " + std::to_string(code);
  if (code < 1 || code > static_cast<int>(std::size(kTerminations))) return;
  const auto& [claim, meaning] = kTerminations[code - 1];
  answer.claim = claim;
  answer.detail = path.version + ": " + meaning;
}

}  // namespace lcpbench::path
