#pragma once

namespace lcpbench {

/// What this executable was built from and with; "" for the commit where there was no repository, a "+"
/// behind it where the tree had changes that no commit has.
struct BuildInfo {
  const char* version;
  const char* commit;
  const char* compiler;
  const char* flags;
  const char* build_type;
};

/// Written anew by each build.
extern const BuildInfo kBuildInfo;

}  // namespace lcpbench
