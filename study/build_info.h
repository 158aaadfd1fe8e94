#pragma once

namespace lcpbench {

/// What this executable was built from and with; "" for the commit where there was no repository.
struct BuildInfo {
  const char* version;
  const char* commit;
  const char* compiler;
  const char* flags;
  const char* build_type;
};

/// Written by CMake when it configures.
extern const BuildInfo kBuildInfo;

}  // namespace lcpbench
