#pragma once

#include <cstddef>
#include <vector>

#include "native/contacts/contact_impulses.h"
#include "native/proximal_newton/friction_polygon.h"

namespace lcpbench {

/// A contact's normal and two tangents T, on the coordinates that they move. Its directions of friction are T times
/// those of edge_direction().
struct ContactRows {
  Eigen::Matrix3Xd J;
  std::vector<int> coordinates;  ///< in rising order
  Index friction = -1;           ///< in ContactImpulses::frictions; -1: none

  /// J u.
  Eigen::Vector3d velocity(const Vector& u) const {
    Eigen::Vector3d w = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < coordinates.size(); ++k) w += J.col(static_cast<Index>(k)) * u(coordinates[k]);
    return w;
  }
  /// momentum += J'f.
  void add_momentum(const Eigen::Vector3d& f, Vector& momentum) const {
    for (std::size_t k = 0; k < coordinates.size(); ++k) {
      momentum(coordinates[k]) += J.col(static_cast<Index>(k)).dot(f);
    }
  }
};

/// Fills `rows` for all contacts, or stops at the first one whose directions are not T times those of edge_direction().
/// @returns that contact; -1: none
Index find_contact_rows(const ContactImpulses& contacts, std::vector<ContactRows>& rows);

/// The polygon of each contact's friction. Contacts of as many edges share one.
class ContactPolygons {
 public:
  void find(const ContactImpulses& contacts);
  /// nullptr: the contact has no friction.
  const FrictionPolygon* of(std::size_t contact) const {
    return of_[contact] < 0 ? nullptr : &polygons_[static_cast<std::size_t>(of_[contact])];
  }

 private:
  std::vector<FrictionPolygon> polygons_;
  std::vector<std::ptrdiff_t> of_;  ///< each contact's; -1: none
};

/// Impulses along the normal and both tangents of each contact, from those along directions.
void net_impulses(const ContactImpulses& contacts, Eigen::Matrix3Xd& impulse);
/// The other way: friction goes along two neighbouring directions, with the least sum. The velocity becomes theirs.
void set_net_impulses(const Eigen::Matrix3Xd& impulse, const ContactPolygons& polygons, ContactImpulses& contacts);

}  // namespace lcpbench
