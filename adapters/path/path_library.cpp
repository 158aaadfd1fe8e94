#include "adapters/path/path_library.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

#include <dlfcn.h>

#include "adapters/worker/start_directory.h"
#include "core/error.h"

namespace lcpbench::path {

/// Output_Interface.
struct OutputInterface {
  void* data = nullptr;
  void (*print)(void* data, int mode, char* text) = nullptr;
  void (*flush)(void* data, int mode) = nullptr;
};

namespace {

/// Information: six doubles in version 5 (basis_time is the new one) and five in earlier versions, then ints, as PATH's
/// Boolean is one. There is room to spare behind, should a version write more.
class Information {
 public:
  enum Int { kMajorIterations = 0, kMinorIterations = 1, kUseStart = 12 };

  explicit Information(const std::string& version) : ints_at_((is_before_5(version) ? 5 : 6) * sizeof(double)) {
    const int yes = 1;
    std::memcpy(place_of(kUseStart), &yes, sizeof yes);
  }
  void* data() { return bytes_.data(); }
  int get(Int which) {
    int value = 0;
    std::memcpy(&value, place_of(which), sizeof value);
    return value;
  }

 private:
  static bool is_before_5(const std::string& version) {
    const auto digit = version.find_first_of("0123456789");
    return digit != std::string::npos && std::atoi(version.c_str() + digit) < 5;
  }
  std::byte* place_of(Int which) { return bytes_.data() + ints_at_ + static_cast<std::size_t>(which) * sizeof(int); }

  std::size_t ints_at_;
  alignas(std::max_align_t) std::array<std::byte, 512> bytes_{};
};

struct Termination {
  int code;
  Claim claim;
  const char* meaning;
};

/// MCP_Termination.
constexpr std::array<Termination, 13> kTerminations{{{1, Claim::kSolved, "solved"},
                                                     {2, Claim::kNumericalFailure, "no progress"},
                                                     {3, Claim::kIterationLimit, "major iteration limit"},
                                                     {4, Claim::kIterationLimit, "minor iteration limit"},
                                                     {5, Claim::kTimeLimit, "time limit"},
                                                     {6, Claim::kNumericalFailure, "user interrupt"},
                                                     {7, Claim::kNumericalFailure, "bound error"},
                                                     {8, Claim::kNumericalFailure, "domain error"},
                                                     {9, Claim::kUnsolvable, "infeasible"},
                                                     {10, Claim::kNumericalFailure, "error"},
                                                     {11, Claim::kNumericalFailure, "reduced by presolve"},
                                                     {12, Claim::kUnsupported, "licence error"},
                                                     {13, Claim::kNumericalFailure, "not modified by presolve"}}};

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

void discard(void*, int, char*) {}
void discard_flush(void*, int) {}

}  // namespace

/// The library's entry points. The errors do not name the folder of its file, because reports show them.
struct PathLibrary::EntryPoints {
  /// Becomes a pointer to a function of whatever type is asked for.
  struct Symbol {
    void* address;
    template <class Function>
    operator Function*() const {
      return reinterpret_cast<Function*>(address);
    }
  };

  explicit EntryPoints(const std::string& file)
      : name(std::filesystem::path(file).filename()), library(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (library == nullptr) throw InputError("PATH_LIBRARY: " + replaced(dlerror(), file, name));
  }
  Symbol find(const char* symbol) const {
    void* const address = dlsym(library, symbol);
    if (address == nullptr) throw InputError("PATH_LIBRARY: " + name + " has no " + symbol);
    return {address};
  }

  std::string name;
  void* library;
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
};

PathLibrary& PathLibrary::of_user() {
  const char* name = std::getenv("PATH_LIBRARY");
  if (name == nullptr || *name == '\0') throw InputError("PATH_LIBRARY is not set");
  std::filesystem::path file = name;
  if (file.has_parent_path() && file.is_relative()) file = start_directory() / file;
  static auto* const library = new PathLibrary(file.string());
  return *library;
}

// PATH asks for this order: first where output goes, then the options, then the rest. The version may be asked first.
PathLibrary::PathLibrary(const std::string& file) : call_(new EntryPoints(file)) {
  static OutputInterface silence{nullptr, discard, discard_flush};
  call_->Output_SetInterface(&silence);
  version_ = short_version(call_->Path_Version());
  options_ = call_->Options_Create();
  call_->Path_AddOptions(options_);
  if (const char* licence = std::getenv("PATH_LICENSE_STRING")) call_->License_SetString(licence);
}

void PathLibrary::set_options(const Options& options) {
  const double time_limit_s = std::min(options.time_limit_s, kLongestTimeLimit_s);
  call_->Options_Default(options_);
  call_->Options_Set(options_, "output no");
  call_->Options_SetDouble(options_, "convergence_tolerance", options.tolerance);
  call_->Options_SetDouble(options_, "time_limit", time_limit_s);
  call_->Options_SetInt(options_, "major_iteration_limit", options.major_iterations);
  // The return values of the functions above are not documented. So read back what they stored.
  if (call_->Options_GetDouble(options_, "convergence_tolerance") != options.tolerance ||
      call_->Options_GetDouble(options_, "time_limit") != time_limit_s ||
      call_->Options_GetInt(options_, "major_iteration_limit") != options.major_iterations) {
    throw std::runtime_error(version_ + " did not take its options");
  }
}

bool PathLibrary::licensed(int n, int entries) { return call_->Path_CheckLicense(n, entries) != 0; }

void PathLibrary::solve(McpInterface& callbacks, int n, int entries, Answer& answer) {
  void* const mcp = call_->MCP_Create(n, std::max(entries, 1));
  if (mcp == nullptr) {
    answer.detail = version_ + ": MCP_Create gave nothing";
    return;
  }
  call_->MCP_Jacobian_Structure_Constant(mcp, 1);
  call_->MCP_SetInterface(mcp, &callbacks);
  Information information(version_);
  const int code = call_->Path_Solve(mcp, information.data());
  if (const double* z = call_->MCP_GetX(mcp)) answer.z = Eigen::Map<const Vector>(z, n);
  call_->MCP_Destroy(mcp);

  answer.counters.iterations = information.get(Information::kMajorIterations);
  answer.counters.pivots = information.get(Information::kMinorIterations);
  answer.detail = version_ + ": unknown status " + std::to_string(code);
  for (const Termination& termination : kTerminations) {
    if (termination.code != code) continue;
    answer.claim = termination.claim;
    answer.detail = version_ + ": " + termination.meaning;
  }
}

}  // namespace lcpbench::path
