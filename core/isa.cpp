#include "core/isa.h"

#include <array>
#include <cstdlib>
#include <fstream>
#include <istream>
#include <string_view>

#include "core/error.h"

namespace lcpbench {

const char* to_string(IsaLevel level) {
  constexpr std::array kNames{"baseline", "avx2", "avx512"};
  return kNames[static_cast<std::size_t>(level)];
}

IsaLevel best_isa_level() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    return IsaLevel::kAvx512;
  }
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return IsaLevel::kAvx2;
#endif
  return IsaLevel::kBaseline;
}

IsaLevel isa_level() {
  static const IsaLevel level = [] {
    const char* text = std::getenv("LCPBENCH_ISA");
    if (text == nullptr || *text == '\0') return best_isa_level();
    for (const IsaLevel candidate : {IsaLevel::kBaseline, IsaLevel::kAvx2, IsaLevel::kAvx512}) {
      if (std::string_view(text) != to_string(candidate)) continue;
      if (candidate > best_isa_level()) {
        throw InputError("LCPBENCH_ISA: this processor has no more than " + std::string(to_string(best_isa_level())));
      }
      return candidate;
    }
    throw InputError("LCPBENCH_ISA = '" + std::string(text) + "': expected baseline|avx2|avx512");
  }();
  return level;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  return processor_name(file);
}

std::string processor_name(std::istream& cpuinfo) {
  std::string implementer;
  for (std::string line; std::getline(cpuinfo, line);) {
    const auto colon = line.find(": ");
    if (colon == std::string::npos) continue;
    const std::string key = line.substr(0, line.find_last_not_of(" \t", colon - 1) + 1);
    const std::string value = line.substr(colon + 2);
    if (key == "model name" || key == "cpu" || key == "uarch") return value;
    if (key == "CPU implementer") implementer = value;
    if (key == "CPU part") return "CPU implementer " + implementer + " part " + value;
  }
  return "unknown";
}

}  // namespace lcpbench
