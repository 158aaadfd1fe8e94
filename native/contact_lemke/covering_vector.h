#pragma once

#include "native/contact_lemke/contacts.h"
#include "native/contact_lemke/friction_state.h"

namespace lcpbench::lemke::LCPBENCH_LEVEL {

/// The covering vector: what a unit of the artificial variable z0 adds to each velocity and to each cone row.
///
/// By default it is positive on normal velocities only. The classic one is positive on every row.
template <class Scalar>
class CoveringVector {
 public:
  CoveringVector(const Contacts<Scalar>& contacts, const FrictionState& friction)
      : contacts_(contacts), friction_(friction) {}

  /// Takes all memory; touches none of it. @pre the contacts are reserved
  void reserve() {
    normals_.resize(contacts_.padded_nc());
    cones_.resize(contacts_.nc());
  }

  /// @param variant  of the default vector. 0: equal entries; > 0: unequal ones, others for each number
  void choose(bool classic, Count variant) {
    classic_ = classic;
    const bool equal = !classic && variant == 0;
    const Count first = classic ? 0 : (variant - 1) * contacts_.nc();
    for (Count c = 0; c < contacts_.nc(); ++c) normals_[c] = equal ? Scalar(1) : spread(c + first);
    for (Count c = contacts_.nc(); c < contacts_.padded_nc(); ++c) normals_[c] = 0;
  }

  /// The covering vector is zero.
  void clear() {
    classic_ = false;
    for (Count c = 0; c < contacts_.padded_nc(); ++c) normals_[c] = 0;
  }

  /// The classic one covers a cone row, whose variable is an impulse, by what brings as much velocity as the others.
  /// @param norm  what a unit of the normal impulse causes
  void cover_cone(Count contact, Scalar norm) { cones_[contact] = norm > 0 ? Scalar(1) / norm : Scalar(1); }

  /// Of the normal velocities, padded.
  const Scalar* of_normals() const { return normals_.data(); }
  Scalar of_directions(Count contact) const { return classic_ ? spread(contact + contacts_.nc()) : Scalar(0); }
  Scalar of_cone(Count contact) const { return classic_ ? cones_[contact] : Scalar(0); }

  /// Of the velocity (d_s - d_base)'u, where the zero direction stands for lambda, which is not covered.
  Scalar of(Label label) const {
    if (label.is_normal()) return normals_[label.contact];
    const Count zero = contacts_.edges(label.contact);
    const Scalar directions = of_directions(label.contact);
    const Scalar own = label.direction == zero ? Scalar(0) : directions;
    const Scalar base = friction_.base(label.contact) == zero ? Scalar(0) : directions;
    return own - base;
  }

 private:
  /// In [1, 2), another number for each k >= 0: unequal entries make ties in the ratio test unlikely.
  static Scalar spread(Count k) {
    const double golden = 0.6180339887498949;  // the golden ratio - 1
    const double turns = golden * static_cast<double>(k + 1);
    return static_cast<Scalar>(1 + (turns - static_cast<double>(static_cast<Count>(turns))));
  }

  const Contacts<Scalar>& contacts_;
  const FrictionState& friction_;
  bool classic_ = false;
  Buffer<Scalar> normals_, cones_;
};

}  // namespace lcpbench::lemke::LCPBENCH_LEVEL
