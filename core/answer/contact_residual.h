#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/answer/cone_friction.h"
#include "core/answer/contact_lcp.h"
#include "core/answer/island_rows.h"
#include "core/answer/measures.h"
#include "core/answer/refined_inertia.h"
#include "core/friction_model.h"

namespace lcpbench {

/// What an answer to a contact problem leaves of its conditions, from the data alone, in 113 bits. Everybody who judges
/// answers to contacts asks here: docs/explanation/verdicts.md has the formulas.
class ContactResidual {
 public:
  /// z, the velocity u = v + G* J f that its impulses lead to, and w = M z + q.
  struct Point {
    QuadVector z, u, w;
    bool is_finite() const { return all_finite(w) && all_finite(u); }
  };

  /// The largest residual of all rows, and the row whose residual is largest relative to the scale of its island.
  struct Worst {
    Quad residual = 0;  ///< of all rows [m/s]
    Quad relative = 0;  ///< rho
    Index row = -1;     ///< -1: no row is violated
    Quad of_row = 0;    ///< its residual
    Quad scale = 0;     ///< that of its island
    Quad of_contacts = 0;    ///< the largest residual of the contacts' rows [m/s]
    Index bounded_row = -1;  ///< the bounded row of the largest residual, angles in m/s; -1: none is violated
    /// No residual may be off by more than kResolvedError of its scale, nor by what changes the verdict; or one is too
    /// large, however far it is off.
    bool is_resolved = true;
  };

  /// @param contact  finite, must outlive this object
  explicit ContactResidual(const ContactProblem& contact);

  /// Another velocity before the impact (ngc), in place of that of the problem.
  void set_velocity(const Vector& v);

  /// Not finite where the inertia is unresolved, unless z has no impulses. @pre lcp @param z  finite, of the right length
  Point at(const Vector& z) const {
    Point point;
    take(z, point);
    return point;
  }
  /// point := at(z), in its memory.
  void take(const Vector& z, Point& point) const;
  /// The same, in the memory of `point`, of z with the least lambdas that its impulses allow, which are written to it.
  void complete(Vector& z, Point& point) const;

  /// The residual of each row that the model has: of the pyramid all, else the normal rows, and in place of each cone
  /// row the residual of the cone. Of the convex model a contact with friction has no normal row. Bounded rows are the
  /// same of all; those of angles count in m/s: see ContactLcp::lever().
  /// @pre lcp; cone unless the model is the pyramid
  template <class Visit>
  void for_each_row(FrictionModel model, const Point& point, Visit&& visit);
  /// @param ignored  [m/s] islands whose residual is no larger count as solved
  Worst worst(FrictionModel model, const Point& point, double ignored = 0);

  /// rho; infinity where 113 bits do not tell what G* is, or not well enough.
  double rho(const Point& point, FrictionModel model = FrictionModel::kPyramid, double ignored = 0);

  /// scale_I of each island by the model's conditions: see ContactScale. Computed at the first call for a model.
  const QuadVector& scales(FrictionModel model);

  const ContactProblem& problem;
  RefinedInertia inertia;
  std::optional<ContactLcp> lcp;     ///< none where no G* can be made of the data
  std::optional<ConeFriction> cone;  ///< none without friction, or if its directions name no round cone

 private:
  Quad pyramid_row(std::size_t row, const Point& point);
  Quad bounded_row(std::size_t row, const Point& point);
  void find_largest(FrictionModel model, const Point& point);
  void note_kind(Index row, Quad residual);
  void measure_errors(const Point& point);

  RowIslands islands_;
  IslandRows rows_;
  QuadVector scales_, convex_scales_;  // of pyramid and cone; of the convex model
  QuadVector largest_, errors_, without_;  // by island
  Point rest_;                             // no impulses, where without_ is of the convex model
  std::vector<Index> row_of_;          // the row of largest_
  Quad of_contacts_ = 0, of_bounded_ = 0;  // the largest residuals of both kinds, where there are bounded rows
  Index bounded_row_ = -1;
};

template <class Visit>
void ContactResidual::for_each_row(FrictionModel model, const Point& point, Visit&& visit) {
  if (model == FrictionModel::kPyramid) {
    for (std::size_t row = 0; row < lcp->first_bounded(); ++row) visit(static_cast<Index>(row), pyramid_row(row, point));
  }
  for (std::size_t row = lcp->first_bounded(); row < lcp->size(); ++row) {
    visit(static_cast<Index>(row), bounded_row(row, point));
  }
  if (model == FrictionModel::kPyramid) return;
  const ContactLayout& layout = lcp->layout();
  const bool convex = model == FrictionModel::kConvex;
  for (Index contact = 0; contact < layout.nc; ++contact) {
    const auto row = static_cast<std::size_t>(contact);
    const bool slides = cone && cone->has_friction(contact);
    if (!slides || !convex) visit(contact, pyramid_row(row, point));
    if (!slides) continue;
    visit(layout.lambda_offset() + layout.lambda[row],
          convex ? cone->convex_residual(contact, point.z, point.u) : cone->residual(contact, point.z, point.u));
  }
}

}  // namespace lcpbench
