#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/problem.h"

namespace lcpbench {

/// Significant decimal digits of the shortest text that reads back to this double; 0 for zero.
int digits_of(double value);

/// The value with this many significant decimal digits, correctly rounded.
double rounded(double value, int digits);

/// A number of a problem with all places that must hold it: the two triangles of a symmetric matrix, a friction
/// direction and its opposite.
class Number {
 public:
  explicit Number(double* place) : places_{{place, 1.0}} {}
  void also(double* place, double sign) { places_.emplace_back(place, sign); }
  double value() const { return *places_.front().first; }
  void set(double value) const {
    for (const auto& [place, sign] : places_) *place = sign > 0 ? value : 0 - value;
  }

 private:
  std::vector<std::pair<double*, double>> places_;
};

/// Whether the problem is a bare LCP with a symmetric M.
bool has_symmetric_matrix(const Problem& problem);

/// A copy of a problem whose numbers can be changed.
class Draft {
 public:
  explicit Draft(const Problem& problem) : Draft(problem, has_symmetric_matrix(problem)) {}
  /// @param symmetric  the two triangles of a bare LCP's M hold the same numbers, and change together
  Draft(const Problem& problem, bool symmetric);
  Draft(const Draft&) = delete;  // groups point into it
  Draft& operator=(const Draft&) = delete;

  /// Numbers of one meaning: masses, velocities, ... Those that are zero are left out, and so are the normals and
  /// tangents of a scene, which are unit vectors. A group may be empty.
  using Group = std::vector<Number>;
  const std::vector<Group>& groups() const { return groups_; }

  Problem problem() const;

 private:
  void collect(RigidScene& scene);
  void collect(ContactProblem& contact);
  void collect(Lcp& lcp);

  bool symmetric_;
  std::string name_;
  std::variant<Lcp, ContactProblem, RigidScene> data_;
  std::vector<Group> groups_;
};

}  // namespace lcpbench
