#include "study/run/provenance.h"

#include <ctime>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <thread>
#include <vector>

#include <flint/flint.h>
#include <fmt/chrono.h>
#include <gmp.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/utsname.h>

#include "core/isa.h"
#include "core/registry.h"
#include "study/run/build_info.h"
#include "study/run/open_solver.h"

namespace lcpbench {
namespace {

/// PRETTY_NAME of /etc/os-release; "" where there is none.
std::string distribution() {
  std::ifstream file("/etc/os-release");
  const std::string key = "PRETTY_NAME=\"";
  for (std::string line; std::getline(file, line);) {
    if (line.rfind(key, 0) == 0 && line.size() > key.size())
      return line.substr(key.size(), line.size() - key.size() - 1);
  }
  return {};
}

nlohmann::ordered_json solver_versions() {
  nlohmann::ordered_json versions = nlohmann::ordered_json::object();
  for (const RegisteredSolver& solver : registered_solvers()) {
    versions[solver.definition.name] = {
        {"library", solver.library}, {"version", solver.version}, {"available", why_unavailable(solver).empty()}};
  }
  return versions;
}

/// What the program was compiled against, beside the solvers' own.
nlohmann::ordered_json library_versions() {
  return {{"eigen", fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"flint", FLINT_VERSION},
          {"gmp", fmt::format("{}.{}.{}", __GNU_MP_VERSION, __GNU_MP_VERSION_MINOR, __GNU_MP_VERSION_PATCHLEVEL)},
          {"nlohmann_json", fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                        NLOHMANN_JSON_VERSION_PATCH)}};
}

}  // namespace

nlohmann::ordered_json provenance(const std::string& command_line, const std::string& started) {
  utsname system{};
  uname(&system);
  return {{"lcpbench", kBuildInfo.version},
          {"commit", kBuildInfo.commit},
          {"compiler", kBuildInfo.compiler},
          {"flags", kBuildInfo.flags},
          {"build_type", kBuildInfo.build_type},
          {"processor", processor_name()},
          {"isa", to_string(isa_level())},
          {"cores", std::thread::hardware_concurrency()},
          {"os", distribution()},
          {"kernel", fmt::format("{} {} {}", system.sysname, system.release, system.machine)},
          {"sqlite", sqlite3_libversion()},
          {"libraries", library_versions()},
          {"solvers", solver_versions()},
          {"command", command_line},
          {"started", started}};
}

std::string utc_now() { return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))); }

double processor_seconds() {
  double seconds = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime}) {
      seconds += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }
  }
  return seconds;
}

double memory_bytes() {
  std::vector<std::string> processes{"self"};
  std::error_code ignored;
  for (const auto& thread : std::filesystem::directory_iterator("/proc/self/task", ignored)) {
    std::ifstream children(thread.path() / "children");
    for (std::string child; children >> child;) processes.push_back(child);
  }
  double bytes = 0;
  for (const std::string& process : processes) {
    std::ifstream status("/proc/" + process + "/status");
    double kibibytes = 0;
    for (std::string word; status >> word;) {
      if (word == "VmHWM:" && status >> kibibytes) bytes += 1024 * kibibytes;
    }
  }
  return bytes;
}

}  // namespace lcpbench
