#pragma once

#include <cctype>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/types.h>

#include "core/timed_solve.h"

/// Problems whose names say what a worker or a program is to do, what is made of it, and the processes that are about.
namespace lcpbench {

inline constexpr Index kSize = 5;
inline constexpr TimedRequest kPatient{.time_limit_s = 20.0};

inline Problem named(const std::string& behaviour, double q = -1.0) {
  return {behaviour, Lcp{2.0 * Matrix::Identity(kSize, kSize), Vector::Constant(kSize, q)}};
}

struct Fault {
  const char* behaviour;
  Claim claim;
  const char* detail;  ///< part of it
  TimedRequest request = kPatient;
};

inline void PrintTo(const Fault& fault, std::ostream* out) { *out << fault.behaviour; }

inline std::string fault_name(const testing::TestParamInfo<Fault>& test) {
  std::string name = test.param.behaviour;
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name + std::to_string(test.index);
}

struct ProcessState {
  char state = '?';
  pid_t parent = 0;
};

inline ProcessState process_state(const std::filesystem::path& folder) {
  std::ifstream file(folder / "stat");
  std::string text;
  ProcessState result;
  if (std::getline(file, text)) std::istringstream(text.substr(text.rfind(')') + 1)) >> result.state >> result.parent;
  return result;
}

/// Processes whose parent is `parent`, zombies included.
inline std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> children;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    if (process_state(entry.path()).parent == parent) children.push_back(std::stoi(entry.path().filename()));
  }
  return children;
}

}  // namespace lcpbench
