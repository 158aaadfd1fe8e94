#pragma once

#include <utility>
#include <vector>

#include <Eigen/SparseCore>

#include "core/contact_problem.h"
#include "core/entries.h"

namespace lcpbench {

/// Coordinates that are added to those of a problem, each with an inertia of its own: parts of a problem in other words
/// get them.
class AddedCoordinates {
 public:
  using Entries = std::vector<Eigen::Triplet<double>>;

  explicit AddedCoordinates(const ContactProblem& problem) : next_(problem.ngc()) {}

  /// @returns the coordinate
  Index add(double inertia, double speed) {
    inertia_.push_back(inertia);
    speeds_.push_back(speed);
    return next_++;
  }
  Index end() const { return next_; }

  Vector velocity(const Vector& v) const {
    Vector all(next_);
    all << v, Eigen::Map<const Vector>(speeds_.data(), static_cast<Index>(speeds_.size()));
    return all;
  }

  /// That of the problem where nothing was added. Of a dense G it becomes one of blocks.
  Inertia inertia(const Inertia& of) const;

  /// J on all coordinates, which has the entries `added`, too. Those may be in columns after the last of J.
  SparseMatrix jacobian(const Jacobian& J, Index columns, Entries added) const {
    for (Index column = 0; column < cols(J); ++column) {
      for_each_entry(J, column, [&](Index row, double entry) { added.emplace_back(row, column, entry); });
    }
    SparseMatrix result(next_, columns);
    result.setFromTriplets(added.begin(), added.end());
    return result;
  }

 private:
  Index next_;
  std::vector<double> inertia_, speeds_;
};

}  // namespace lcpbench
