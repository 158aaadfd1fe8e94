#pragma once

#include <vector>

#include "native/contacts/contact_impulses.h"

namespace lcpbench {

/// A contact's normal and two tangents T, on the coordinates that they move. Its directions of friction are T times
/// those of edge_direction().
struct ContactRows {
  Eigen::Matrix3Xd J;
  std::vector<int> coordinates;  ///< in rising order
  Index friction = -1;           ///< in ContactImpulses::frictions; -1: none
};

/// Fills `rows` for all contacts, or stops at the first one whose directions are not T times those of edge_direction().
/// @returns that contact; -1: none
Index find_contact_rows(const ContactImpulses& contacts, std::vector<ContactRows>& rows);

}  // namespace lcpbench
