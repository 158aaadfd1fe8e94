#include "study/run/sweeps.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/registry.h"

namespace lcpbench {
namespace {

constexpr const char* kPaper = "paper";
constexpr const char* kInnerSolver = "solver";

/// 1e<first>, 1e<first + step>, ..., none above 1e-4, the paper's upper end. @pre step > 0
std::vector<std::string> decades(int first, int step) {
  std::vector<std::string> values;
  for (int exponent = first; exponent <= -4; exponent += step) values.push_back("1e" + std::to_string(exponent));
  return values;
}

/// The test of answers, the same in all cells. The paper's Lemke and interior-point programs have none.
SweepAxis test_axis(std::string value) { return {"test", {std::move(value)}}; }

/// The paper's grid for one of its own solvers; empty for others.
std::vector<SweepAxis> axes_of_paper_solver(const std::string& solver) {
  if (solver == "lemke") {
    return {{"pivot_tolerance", decades(-20, 2)}, {"zero_tolerance", decades(-20, 2)}, test_axis("none")};
  }
  if (solver == "primal_dual") return {{"eps", decades(-20, 6)}, {"eps_feas", decades(-20, 6)}, test_axis("none")};
  if (solver == "path") return {{"tolerance", decades(-20, 2)}};
  return {};
}

/// The value that a setting has under this spec, by default or by its options; nullopt when the solver has no setting
/// of this name. @throws InputError for an unknown solver and for options that it does not take
std::optional<std::string> value_of(const Spec& solver, const std::string& setting) {
  for (const auto& [key, value] : find_solver(solver.name).definition.all_settings(solver.options)) {
    if (key == setting) return value;
  }
  return std::nullopt;
}

/// The option of this name, or the end of the options.
auto find_option(auto& options, const std::string& key) {
  return std::find_if(options.begin(), options.end(), [&](const auto& option) { return option.first == key; });
}

/// builtin_sweep()'s axes for "paper", also of a solver that wraps another; empty without a grid.
std::vector<SweepAxis> paper_axes_of(const Spec& solver) {
  std::vector<SweepAxis> axes = axes_of_paper_solver(solver.name);
  if (!axes.empty()) return axes;
  const std::optional<std::string> inner = value_of(solver, kInnerSolver);
  if (!inner) return {};
  axes = paper_axes_of(parse_spec(*inner));
  if (axes.empty()) return {};
  for (SweepAxis& axis : axes) axis.setting = std::string(kInnerSolver) + "." + axis.setting;
  const bool names_test = find_option(solver.options, "test") != solver.options.end();
  if (solver.name == "regularized" && !names_test) axes.push_back(test_axis("original"));
  return axes;
}

void set_option(Options& options, const std::string& key, const std::string& value) {
  const auto found = find_option(options, key);
  if (found != options.end()) {
    found->second = value;
  } else {
    options.emplace_back(key, value);
  }
}

void set_path(Spec& spec, const std::string& path, const std::string& value) {
  const auto dot = path.find('.');
  if (dot == std::string::npos) return set_option(spec.options, path, value);
  const std::string key = path.substr(0, dot);
  const std::optional<std::string> text = value_of(spec, key);
  if (!text) throw InputError(spec.name + ": unknown option '" + key + "'");
  Spec inner = parse_spec(*text);
  set_path(inner, path.substr(dot + 1), value);
  set_option(spec.options, key, inner.text());
}

}  // namespace

bool has_builtin_sweep(const std::string& name, const Spec& solver) {
  return name == kPaper && !paper_axes_of(solver).empty();
}

Sweep builtin_sweep(const std::string& name, const Spec& solver) {
  if (name != kPaper) throw InputError("unknown sweep '" + name + "'; known: " + kPaper);
  std::vector<SweepAxis> axes = paper_axes_of(solver);
  if (axes.empty()) throw InputError("sweep '" + name + "': the paper has no grid for solver '" + solver.name + "'");
  return {name, std::move(axes)};
}

std::vector<Spec> sweep_cells(const Sweep& sweep, const Spec& solver) {
  std::vector<Spec> cells{solver};
  for (const SweepAxis& axis : sweep.axes) {
    std::vector<Spec> finer;
    finer.reserve(cells.size() * axis.values.size());
    for (const Spec& cell : cells) {
      for (const std::string& value : axis.values) {
        finer.push_back(cell);
        set_path(finer.back(), axis.setting, value);
      }
    }
    cells = std::move(finer);
  }
  for (Spec& cell : cells) cell = canonical_solver_spec(cell);
  return cells;
}

std::string sweep_label(const std::string& sweep, const Spec& solver) {
  Spec label = canonical_solver_spec(solver);
  label.name = sweep;
  return label.text();
}

}  // namespace lcpbench
