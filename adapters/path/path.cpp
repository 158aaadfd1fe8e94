// PATH, from a library of the user's own: opened at run time, never linked.
#include <cstdlib>
#include <filesystem>

#include "adapters/define_adapter.h"

#ifdef LCPBENCH_DESCRIBE_ONLY
#define XXH_INLINE_ALL
#include <array>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include <xxhash.h>
#else
#include <algorithm>
#include <memory>

#include "adapters/path/path_library.h"
#endif

namespace lcpbench {
namespace {

struct PathSettings {
  static constexpr Capabilities capabilities{.guarantees = "none stated by the library", .obeys_time_limit = true};

  double tolerance = 1e-6;
  std::int64_t major_iterations = 500;

  void visit(auto&& field) {
    field("tolerance", tolerance, RealRange{.min = 1e-300, .max = 1.0},
          "PATH's convergence_tolerance; 1e-6 is PATH's default");
    field("major_iterations", major_iterations, IntegerRange{.min = 1, .max = 1000000000},
          "PATH's major_iteration_limit; 500 is PATH's default");
  }
};

class Path;

#ifndef LCPBENCH_DESCRIBE_ONLY

/// The mixed complementarity problem F(z) = M z + q with 0 <= z, in the form that PATH's callbacks ask for: the
/// columns' entries that are not zero.
class LinearMcp {
 public:
  explicit LinearMcp(const Lcp& lcp) : q_(lcp.q), M_(lcp.M.sparseView()) {}

  int size() const { return static_cast<int>(q_.size()); }
  int entries() const { return static_cast<int>(M_.nonZeros()); }

  path::McpInterface callbacks() {
    path::McpInterface callbacks;
    callbacks.data = this;
    callbacks.problem_size = [](void* self, int* n, int* entries) {
      *n = of(self).size();
      *entries = of(self).entries();
    };
    callbacks.bounds = [](void*, int n, double* z, double* lower, double* upper) {
      std::fill_n(z, n, 0.0);
      std::fill_n(lower, n, 0.0);
      std::fill_n(upper, n, path::kInfinity);
    };
    callbacks.function = [](void* self, int, double* z, double* f) {
      of(self).evaluate(z, f);
      return 0;
    };
    callbacks.jacobian = [](void* self, int, double* z, int wants_f, double* f, int* entries, int* starts, int* lengths,
                            int* rows, double* values) {
      if (wants_f != 0) of(self).evaluate(z, f);
      of(self).write_jacobian(starts, lengths, rows, values);
      *entries = of(self).entries();
      return 0;
    };
    return callbacks;
  }

 private:
  static const LinearMcp& of(void* self) { return *static_cast<const LinearMcp*>(self); }

  void evaluate(const double* z, double* f) const {
    Eigen::Map<Vector> result(f, q_.size());
    result = q_;
    result.noalias() += M_ * Eigen::Map<const Vector>(z, q_.size());
  }

  /// Starts and rows are counted from 1.
  void write_jacobian(int* starts, int* lengths, int* rows, double* values) const {
    for (int j = 0; j < size(); ++j) {
      starts[j] = M_.outerIndexPtr()[j] + 1;
      lengths[j] = M_.outerIndexPtr()[j + 1] - M_.outerIndexPtr()[j];
    }
    std::transform(M_.innerIndexPtr(), M_.innerIndexPtr() + entries(), rows, [](int row) { return row + 1; });
    std::copy_n(M_.valuePtr(), entries(), values);
  }

  Vector q_;
  SparseMatrix M_;
};

class Path final : public Adapter<PathSettings> {
 public:
  explicit Path(const PathSettings& settings) : Adapter(settings) { path::open_library(); }

 private:
  std::string take(const Problem& problem) override {
    mcp_ = std::make_unique<LinearMcp>(finite_lcp(problem));
    return {};
  }

  void call(const SolveRequest& request, Answer& answer) override {
    path::McpInterface callbacks = mcp_->callbacks();
    path::solve(callbacks, mcp_->size(), mcp_->entries(),
                {.tolerance = settings_.tolerance,
                 .major_iterations = static_cast<int>(settings_.major_iterations),
                 .time_limit_s = request.time_limit_s},
                answer);
  }

  std::unique_ptr<LinearMcp> mcp_;
};

#endif

}  // namespace

#ifdef LCPBENCH_DESCRIBE_ONLY

namespace {

std::filesystem::path users_library() {
  const char* file = std::getenv("PATH_LIBRARY");
  return file == nullptr ? "" : file;
}

/// 16 hexadecimal digits: XXH3-64 of the file's bytes. nullopt when it cannot be read.
std::optional<std::string> content_hash(const std::filesystem::path& file) {
  const std::ifstream in(file, std::ios::binary);
  std::ostringstream copy;
  if (!in || !(copy << in.rdbuf())) return std::nullopt;
  const std::string bytes = copy.str();
  std::array<char, 17> text;
  std::snprintf(text.data(), text.size(), "%016llx",
                static_cast<unsigned long long>(XXH3_64bits(bytes.data(), bytes.size())));
  return text.data();
}

}  // namespace

// Stores and reports show the texts of these two functions. So they name the file without the user's folder.

std::string lcpbench_unavailable_path() {
  const std::filesystem::path file = users_library();
  if (file.empty()) return "set PATH_LIBRARY to the file of your libpath (and PATH_LICENSE_STRING to its licence)";
  // A bare name is looked for by the dynamic linker, in the worker.
  if (file.has_parent_path() && !content_hash(file)) {
    return "PATH_LIBRARY names a file " + file.filename().string() + " that is not there or cannot be read";
  }
  return {};
}

std::string lcpbench_version_path() {
  const std::filesystem::path file = users_library();
  const std::optional<std::string> hash = file.has_parent_path() ? content_hash(file) : std::nullopt;
  return file.filename().string() + (hash ? " " + *hash : "");
}

#endif

SolverDefinition lcpbench_solver_path() {
  return define_adapter<Path, PathSettings>(
      {.name = "path",
       .summary = "PATH on the LCP as a mixed complementarity problem; the library is the user's own",
       .source = "Dirkse, Ferris 1995, Optim. Methods Softw. 5; Ferris, Munson 1999, Comput. Optim. Appl. 12"});
}

}  // namespace lcpbench
