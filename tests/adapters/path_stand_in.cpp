// A shared library with the entry points of PATH that the adapter uses, for tests: the real one cannot be distributed.
// It ends the process (exit code 255) on calls in an order that PATH does not take, checks what the callbacks say
// against each other, and solves by projected Gauss-Seidel. Like PATH it talks a lot, keeps its state in
// globals, and solves up to 300 variables and 2000 nonzeros without a licence. The order of the structures' fields is
// that of PATH's published headers; STAND_IN_VERSION 4 gives the older one.

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = 1e20;  // as PATH has it

[[noreturn]] void complain(const std::string& cause) {
  std::fprintf(stderr, "stand-in: %s\n", cause.c_str());
  std::exit(255);
}

void require(bool condition, const char* cause) {
  if (!condition) complain(cause);
}

}  // namespace

extern "C" {

typedef struct {
  void* output_data;
  void (*print)(void* data, int mode, char* text);
  void (*flush)(void* data, int mode);
} Output_Interface;

typedef struct {
  void* interface_data;
  void (*problem_size)(void* id, int* size, int* nnz);
  void (*bounds)(void* id, int size, double* x, double* l, double* u);
  int (*function_evaluation)(void* id, int n, double* x, double* f);
  int (*jacobian_evaluation)(void* id, int n, double* x, int wantf, double* f, int* nnz, int* col, int* len, int* row,
                             double* data);
#if STAND_IN_VERSION >= 5
  int (*hessian_evaluation)(void* id, int n, double* x, double* l, int* nnz, int* col, int* len, int* row,
                            double* data);
#endif
  void (*start)(void* id);
  void (*finish)(void* id, double* x);
  void (*variable_name)(void* id, int variable, char* buffer, int size);
  void (*constraint_name)(void* id, int constraint, char* buffer, int size);
  void (*basis)(void* id, int size, int* basis);
} MCP_Interface;

typedef struct {
  double residual, distance, steplength, total_time;
#if STAND_IN_VERSION >= 5
  double basis_time;
#endif
  double maximum_distance;
  int major_iterations, minor_iterations, crash_iterations, function_evaluations, jacobian_evaluations, gradient_steps,
      restarts;
  int generate_output, generated_output;
  int forward, backtrace, gradient;
  int use_start, use_basics, used_start, used_basics;
} Information;
}

namespace {

enum Termination {
  kSolved = 1,
  kNoProgress = 2,
  kMinorIterationLimit = 4,
  kBoundError = 7,
  kDomainError = 8,
  kError = 10
};

Output_Interface* g_output = nullptr;
bool g_options_created = false;
bool g_options_known = false;
std::map<std::string, double> g_options;
int g_licensed_n = 300;
int g_licensed_nnz = 2000;
bool g_licence_checked = false;

void talk(const std::string& text) {
  std::string line = text + "\n";
  if (g_output == nullptr) {
    std::fputs(line.c_str(), stdout);
    std::fflush(stdout);
  } else {
    g_output->print(g_output->output_data, 7, line.data());
    if (g_output->flush != nullptr) g_output->flush(g_output->output_data, 7);
  }
}

struct Mcp {
  MCP_Interface callbacks{};
  bool has_callbacks = false;
  bool constant_structure = false;
  int n = 0;
  std::vector<double> x, lower, upper, f0;
  std::vector<std::vector<double>> J;  // rows
};

void read_jacobian(Mcp& mcp, int nnz_bound) {
  const auto n = static_cast<std::size_t>(mcp.n);
  const auto bound = static_cast<std::size_t>(std::max(nnz_bound, 1));
  std::vector<int> col(n, -7), len(n, -7), row(bound, -7);
  std::vector<double> data(bound, kNaN), f(n, kNaN);
  int nnz = nnz_bound;
  mcp.callbacks.jacobian_evaluation(mcp.callbacks.interface_data, mcp.n, mcp.x.data(), 1, f.data(), &nnz, col.data(),
                                    len.data(), row.data(), data.data());
  require(f == mcp.f0, "the function values of the Jacobian callback are others");
  require(nnz >= 0 && nnz <= nnz_bound, "more nonzeros than were announced");
  mcp.J.assign(n, std::vector<double>(n, 0.0));
  int counted = 0;
  for (std::size_t j = 0; j < n; ++j) {
    require(len[j] >= 0 && (len[j] == 0 || (col[j] >= 1 && col[j] + len[j] - 1 <= nnz)), "a column is out of range");
    for (int k = col[j]; k < col[j] + len[j]; ++k, ++counted) {
      const int i = row[static_cast<std::size_t>(k - 1)];
      const double value = data[static_cast<std::size_t>(k - 1)];
      require(i >= 1 && i <= mcp.n, "a row is out of range");
      require(std::isfinite(value) && value != 0, "an entry is zero or not finite");
      require(mcp.J[static_cast<std::size_t>(i - 1)][j] == 0, "an entry is given twice");
      mcp.J[static_cast<std::size_t>(i - 1)][j] = value;
    }
  }
  require(counted == nnz, "the columns do not add up");
}

/// The callbacks must agree: F(x) - F(0) = J x at a point without symmetry.
void check_linear(Mcp& mcp) {
  const auto n = static_cast<std::size_t>(mcp.n);
  std::vector<double> x(n), f(n, kNaN);
  for (std::size_t j = 0; j < n; ++j) x[j] = 1.0 + 0.5 * static_cast<double>(j);
  mcp.callbacks.function_evaluation(mcp.callbacks.interface_data, mcp.n, x.data(), f.data());
  for (std::size_t i = 0; i < n; ++i) {
    double expected = mcp.f0[i];
    double scale = std::abs(expected);
    for (std::size_t j = 0; j < n; ++j) {
      expected += mcp.J[i][j] * x[j];
      scale += std::abs(mcp.J[i][j] * x[j]);
    }
    require(std::abs(f[i] - expected) <= 1e-12 * scale, "function and Jacobian disagree");
  }
}

/// Projected Gauss-Seidel, which converges on the tests' problems; false when it does not.
bool sweep(Mcp& mcp, double tolerance) {
  const auto n = static_cast<std::size_t>(mcp.n);
  for (int count = 0; count < 1000; ++count) {
    bool moved = false;
    for (std::size_t i = 0; i < n; ++i) {
      double f = mcp.f0[i];
      for (std::size_t j = 0; j < n; ++j) f += mcp.J[i][j] * mcp.x[j];
      if (std::abs(std::min(mcp.x[i], f)) <= tolerance) continue;
      mcp.x[i] = std::max(0.0, mcp.x[i] - f / mcp.J[i][i]);
      moved = true;
    }
    if (!moved) return true;
  }
  return false;
}

Termination solve(Mcp& mcp) {
  int nnz = -1;
  mcp.callbacks.problem_size(mcp.callbacks.interface_data, &mcp.n, &nnz);
  require(mcp.n > 0 && nnz >= 0, "no size");
  const auto n = static_cast<std::size_t>(mcp.n);
  mcp.x.assign(n, kNaN);
  mcp.lower.assign(n, -kInfinity);
  mcp.upper.assign(n, kInfinity);
  mcp.callbacks.bounds(mcp.callbacks.interface_data, mcp.n, mcp.x.data(), mcp.lower.data(), mcp.upper.data());
  for (std::size_t i = 0; i < n; ++i) {
    if (!(mcp.lower[i] == 0 && mcp.upper[i] >= kInfinity && mcp.x[i] == 0)) return kBoundError;
  }
  mcp.f0.assign(n, kNaN);
  mcp.callbacks.function_evaluation(mcp.callbacks.interface_data, mcp.n, mcp.x.data(), mcp.f0.data());
  for (const double f : mcp.f0) {
    if (!std::isfinite(f)) return kDomainError;
  }
  read_jacobian(mcp, nnz);
  check_linear(mcp);
  if (g_options["major_iteration_limit"] == 1) return kMinorIterationLimit;
  talk("sweeping");
  return sweep(mcp, g_options["convergence_tolerance"]) ? kSolved : kNoProgress;
}

}  // namespace

extern "C" {

const char* Path_Version() {
#if STAND_IN_VERSION >= 5
  return "Path 5.0.99 (stand-in)";
#else
  return "Path 4.7.99 (stand-in)";
#endif
}

void Output_SetInterface(Output_Interface* output) { g_output = output; }

void* Options_Create() {
  require(g_output != nullptr, "Options_Create before Output_SetInterface");
  g_options_created = true;
  return &g_options;
}

void Path_AddOptions(void* options) {
  require(g_options_created && options == &g_options, "Path_AddOptions before Options_Create");
  g_options = {
      {"convergence_tolerance", kNaN}, {"time_limit", kNaN}, {"major_iteration_limit", kNaN}, {"output", kNaN}};
}

void Options_Default(const void* options) {
  require(options == &g_options && !g_options.empty(), "Options_Default before Path_AddOptions");
  g_options = {{"convergence_tolerance", 1e-6}, {"time_limit", 3600}, {"major_iteration_limit", 500}, {"output", 1}};
  g_options_known = true;
  talk("options at their defaults");
}

int Options_Set(const void*, const char* text) {
  require(g_options_known, "Options_Set before Options_Default");
  if (std::strcmp(text, "output no") == 0) g_options["output"] = 0;
  return 0;
}

int Options_SetDouble(const void*, const char* name, double value) {
  require(g_options_known && g_options.count(name) == 1, "Options_SetDouble: unknown option");
  g_options[name] = value;
  return 0;
}

int Options_SetInt(const void* options, const char* name, int value) { return Options_SetDouble(options, name, value); }

double Options_GetDouble(const void*, const char* name) {
  require(g_options_known && g_options.count(name) == 1, "Options_GetDouble: unknown option");
  return g_options[name];
}

int Options_GetInt(const void* options, const char* name) { return static_cast<int>(Options_GetDouble(options, name)); }

int License_SetString(const char* licence) {
  const bool known = std::strcmp(licence, "a licence for everything") == 0;
  if (known) g_licensed_n = g_licensed_nnz = std::numeric_limits<int>::max();
  return known ? 0 : 4;
}

int Path_CheckLicense(int n, int nnz) {
  require(g_output != nullptr, "Path_CheckLicense before Output_SetInterface");
  g_licence_checked = true;
  talk("licence checked");
  return n <= g_licensed_n && nnz <= g_licensed_nnz ? 1 : 0;
}

Mcp* MCP_Create(int n, int nnz) {
  require(g_options_known, "MCP_Create before the options");
  require(g_licence_checked, "MCP_Create before Path_CheckLicense");
  require(n > 0 && nnz > 0, "MCP_Create without a size");
  return new Mcp;
}

void MCP_Jacobian_Structure_Constant(Mcp* mcp, int yes) { mcp->constant_structure = yes != 0; }

void MCP_SetInterface(Mcp* mcp, MCP_Interface* callbacks) {
  mcp->callbacks = *callbacks;
  mcp->has_callbacks = true;
#if STAND_IN_VERSION >= 5
  require(callbacks->hessian_evaluation == nullptr, "a callback for second derivatives");
#endif
  require(callbacks->start == nullptr && callbacks->finish == nullptr && callbacks->variable_name == nullptr &&
              callbacks->constraint_name == nullptr && callbacks->basis == nullptr,
          "an optional callback is not empty");
}

int Path_Solve(Mcp* mcp, Information* information) {
  require(mcp->has_callbacks, "Path_Solve before MCP_SetInterface");
  require(mcp->constant_structure, "Path_Solve before MCP_Jacobian_Structure_Constant");
  require(g_options["output"] == 0 && information->generate_output == 0, "Path_Solve with its output on");
  require(information->use_start == 1 && information->use_basics == 0, "Path_Solve without the given start");
  const Termination termination = solve(*mcp);
  information->residual = 0;
  information->maximum_distance = kNaN;
  information->major_iterations = 7;
  information->minor_iterations = 42;
  information->used_start = information->used_basics = 1;
  return termination;
}

double* MCP_GetX(Mcp* mcp) { return mcp->x.data(); }

void MCP_Destroy(Mcp* mcp) {
  std::fill(mcp->x.begin(), mcp->x.end(), kNaN);  // for a caller that still holds MCP_GetX
  delete mcp;
}
}
