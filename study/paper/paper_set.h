#pragma once

#include <optional>
#include <string>

#include "core/spec.h"

// Drumwright and Shell (2012), "Extensive analysis of linear complementarity problem (LCP) solver performance on
// randomly generated rigid body contact problems": the names of its sets and solvers.

namespace lcpbench::paper {

/// A set of the paper's problems, its name taken apart.
struct PaperSet {
  std::string kind;        ///< "monotone" or "copositive"
  std::string experiment;  ///< "exp5-1e8"
  bool redundant = false;  ///< it has dependent contacts, so that the readings of redundancy differ
  std::string redundancy;  ///< "multiple" (the default) or "combination"
  /// Options but `redundancy`, "key=value,key=value"; "" for the problems that the tables compare with the paper.
  std::string other_readings;
};

/// nullopt for a set that is not "paper/<kind>/<experiment>".
std::optional<PaperSet> paper_set(const std::string& name);

/// The solver that `regularized{...}` wraps, in the form of Grid::solver; "" for a solver that wraps none.
std::string wrapped_solver(const std::string& solver);

/// The solver of the paper's tables that this one stands for: "Lemke" for lemke, "PATH" for path, "IP" for primal_dual
/// (the interior point method), and for `regularized` that of the solver that it wraps. "" for all others.
std::string family_of(const std::string& solver);

/// Whether the solver, or the one that it wraps, follows the rules of the authors' public code (rules=2012).
bool follows_rules_2012(const std::string& solver);

/// The spec that a stored text stands for; a text that is none is taken as a bare name.
Spec spec_or_name(const std::string& text);

}  // namespace lcpbench::paper
