#include "native/proximal_newton/contact_rows.h"

#include <algorithm>
#include <array>

#include "core/compliance.h"

namespace lcpbench {
namespace {

/// By this part of its largest entry a direction may differ from T times edge_direction().
constexpr double kMostMissed = 1e-9;

/// visit(coordinate, entry) for the entries of a column that are not zero.
void for_each_entry(const ContactImpulses& contacts, Index column, auto&& visit) {
  contacts.columns.J.for_each_run(column, [&](Index first, const PackedColumns::Entries& entries) {
    for (Index k = 0; k < entries.size(); ++k) {
      if (entries(k) != 0) visit(static_cast<int>(first + k), entries(k));
    }
  });
}

Eigen::Vector2d direction_of(Index k, const SignedFriction& friction) {
  const std::array<double, 2> direction = edge_direction(k, 2 * friction.directions);
  return {direction[0], direction[1]};
}

/// T by least squares. @returns whether the directions are T times those of edge_direction()
bool find_tangents(const ContactImpulses& contacts, ContactRows& own, auto&& place) {
  const SignedFriction& friction = contacts.frictions[static_cast<std::size_t>(own.friction)];
  const Index half = friction.directions;
  Matrix D = Matrix::Zero(own.J.cols(), half);
  for (Index t = 0; t < half; ++t) {
    for_each_entry(contacts, friction.first_column + t, [&](int row, double entry) { D(place(row), t) = entry; });
    const double part = half == 1 ? 1.0 : 2.0 / static_cast<double>(half);  // sum of c c' over the directions c
    own.J.bottomRows<2>() += part * direction_of(t, friction) * D.col(t).transpose();
  }
  for (Index t = 0; t < half; ++t) {
    const Vector missed = D.col(t) - own.J.bottomRows<2>().transpose() * direction_of(t, friction);
    if (!(missed.lpNorm<Eigen::Infinity>() <= kMostMissed * D.col(t).lpNorm<Eigen::Infinity>())) return false;
  }
  return true;
}

}  // namespace

Index find_contact_rows(const ContactImpulses& contacts, std::vector<ContactRows>& rows) {
  rows.assign(static_cast<std::size_t>(contacts.contacts), {});
  for (Index i = 0; i < contacts.contacts; ++i) {
    ContactRows& own = rows[static_cast<std::size_t>(i)];
    own.friction = contacts.friction_of[static_cast<std::size_t>(i)];
    const auto add = [&](int row, double) { own.coordinates.push_back(row); };
    for_each_entry(contacts, i, add);
    if (own.friction >= 0) {
      const SignedFriction& friction = contacts.frictions[static_cast<std::size_t>(own.friction)];
      for (Index t = 0; t < friction.directions; ++t) for_each_entry(contacts, friction.first_column + t, add);
    }
    std::sort(own.coordinates.begin(), own.coordinates.end());
    own.coordinates.erase(std::unique(own.coordinates.begin(), own.coordinates.end()), own.coordinates.end());
    const auto place = [&](int row) {
      return std::lower_bound(own.coordinates.begin(), own.coordinates.end(), row) - own.coordinates.begin();
    };
    own.J.setZero(3, static_cast<Index>(own.coordinates.size()));
    for_each_entry(contacts, i, [&](int row, double entry) { own.J(0, place(row)) = entry; });
    if (own.friction >= 0 && !find_tangents(contacts, own, place)) return i;
  }
  return -1;
}

void ContactPolygons::find(const ContactImpulses& contacts) {
  of_.assign(static_cast<std::size_t>(contacts.contacts), -1);
  polygons_.clear();
  for (const SignedFriction& friction : contacts.frictions) {
    const auto known = std::find_if(polygons_.begin(), polygons_.end(), [&](const FrictionPolygon& polygon) {
      return polygon.edges() == 2 * friction.directions;
    });
    of_[static_cast<std::size_t>(friction.contact)] = known - polygons_.begin();
    if (known == polygons_.end()) polygons_.emplace_back(2 * friction.directions);
  }
}

void net_impulses(const ContactImpulses& contacts, Eigen::Matrix3Xd& impulse) {
  impulse.setZero();
  impulse.row(0) = contacts.impulse.head(contacts.contacts).transpose();
  for (const SignedFriction& friction : contacts.frictions) {
    for (Index t = 0; t < friction.directions; ++t) {
      impulse.col(friction.contact).tail<2>() +=
          contacts.impulse(friction.first_column + t) * direction_of(t, friction);
    }
  }
}

void set_net_impulses(const Eigen::Matrix3Xd& impulse, const ContactPolygons& polygons, ContactImpulses& contacts) {
  contacts.impulse.setZero();
  contacts.impulse.head(contacts.contacts) = impulse.row(0).transpose();
  for (const SignedFriction& friction : contacts.frictions) {
    const FrictionPolygon& polygon = *polygons.of(static_cast<std::size_t>(friction.contact));
    const FrictionPolygon::Parts parts = polygon.split(impulse.col(friction.contact).tail<2>());
    for (std::size_t k = 0; k < 2; ++k) {
      if (parts.impulses[k] == 0) continue;
      const Index direction = parts.directions[k];
      const bool is_opposite = direction >= friction.directions;
      contacts.impulse(friction.first_column + (is_opposite ? direction - friction.directions : direction)) +=
          is_opposite ? -parts.impulses[k] : parts.impulses[k];
    }
  }
  contacts.recompute_velocity();
}

}  // namespace lcpbench
