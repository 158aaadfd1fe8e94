// ConeIsland: loads the contacts, as rows in whitened coordinates, and their velocity.

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/entries.h"
#include "native/cone_ipm/cone_island.h"
#include "native/contacts/contact_impulses.h"
#include "native/velocity_ipm/whitened_normals.h"

namespace lcpbench {
namespace {

/// Up to so many coordinates keep_what_moves() is used whenever it removes one; above, where it removes at least half
/// of them, because the rows that it makes are dense.
constexpr Index kSmall = 40;

}  // namespace

void ConeIsland::load(const ContactProblem& island) {
  const ContactLayout layout = contact_layout(island);
  contacts_.clear();
  columns_.clear();
  entries_.clear();
  is_soft_ = island.compliance_n.size() > 0 || island.compliance_t.size() > 0;
  root_ = inverse_root(island.inertia);
  for (Index i = 0; i < layout.nc; ++i) add_contact(island, layout, root_, i);
  const Index rows = contacts_.empty() ? 0 : contacts_.back().row + contacts_.back().rows;
  Index coordinates = root_.cols();
  if (rows < coordinates && (coordinates <= kSmall || 2 * rows <= coordinates)) {
    keep_what_moves(rows);
    coordinates = rows;
  }
  for (Vector* each : {&q_, &x_, &y_, &u_, &slip_, &dx_, &dy_, &target_, &residual_, &rows_, &best_x_, &x_held_}) {
    each->setZero(rows);
  }
  momentum_.resize(island.ngc());
  whitened_.resize(root_.cols());
  w_.setZero(coordinates);
  dw_.setZero(coordinates);
  scalings_.resize(contacts_.size());
  lu_.resize(coordinates);
  set_velocity(island, island.v);
}

/// Changes to the coordinates Q'w, where A' = Q R: R' takes the place of A. They are as many as rows; contacts move no
/// others. O(coordinates rows^2). @pre rows < root_.cols()
void ConeIsland::keep_what_moves(Index rows) {
  Matrix transposed = Matrix::Zero(root_.cols(), rows);  // A'
  std::size_t entry = 0;
  for (const Contact& contact : contacts_) {
    for (Index k = contact.first; k < contact.first + contact.columns; ++k) {
      for (Index r = 0; r < contact.rows; ++r) {
        transposed(columns_[static_cast<std::size_t>(k)], contact.row + r) = entries_[entry++];
      }
    }
  }
  const Eigen::HouseholderQR<Matrix> qr(transposed);
  const Matrix R = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  columns_.clear();
  entries_.clear();
  for (Contact& contact : contacts_) {
    contact.first = static_cast<Index>(columns_.size());
    contact.columns = contact.row + contact.rows;
    for (Index j = 0; j < contact.columns; ++j) {
      columns_.push_back(j);
      for (Index r = 0; r < contact.rows; ++r) entries_.push_back(R(j, contact.row + r));
    }
  }
}

/// Appends the rows J'Z of a contact to A, where Z Z' = G*; of a contact with friction the normal one is divided by mu.
/// @param root  Z
void ConeIsland::add_contact(const ContactProblem& island, const ContactLayout& layout, const Matrix& root,
                             Index contact) {
  const auto column = [&](const Jacobian& J, Index j) -> Vector {
    if (const auto* dense = std::get_if<Matrix>(&J)) return root.transpose() * dense->col(j);
    return root.transpose() * std::get<SparseMatrix>(J).col(j);
  };
  const auto c = static_cast<std::size_t>(contact);
  Contact to;
  to.mu = layout.lambda[c] >= 0 ? island.mu(contact) : 0.0;
  if (layout.lambda[c] >= 0) {
    to.tangents = {layout.friction_begin[c], layout.friction_begin[c] + island.edges[c] / 4};
  }
  to.rows = to.mu > 0 ? 3 : 1;
  to.row = contacts_.empty() ? 0 : contacts_.back().row + contacts_.back().rows;
  to.first = static_cast<Index>(columns_.size());
  Matrix A(to.rows, root.cols());
  const Vector normal = column(island.N, contact);
  const double r_n = island.normal_compliance(contact), r_t = island.tangential_compliance(contact);
  to.diagonal_normal = normal.squaredNorm() + r_n;
  to.compliance(0) = r_n;
  A.row(0) = normal.transpose();
  if (to.rows == 3) {
    A.row(0) /= to.mu;
    A.row(1) = column(island.D, to.tangents[0]).transpose();
    A.row(2) = column(island.D, to.tangents[1]).transpose();
    to.diagonal_tangent = std::max(A.row(1).squaredNorm(), A.row(2).squaredNorm()) + r_t;
    to.compliance << r_n / (to.mu * to.mu), r_t, r_t;
  }
  for (Index j = 0; j < A.cols(); ++j) {
    if (A.col(j).isZero(0)) continue;
    columns_.push_back(j);
    entries_.insert(entries_.end(), A.col(j).begin(), A.col(j).end());
    ++to.columns;
  }
  contacts_.push_back(to);
}

/// Sets q_, unit_, q_max_ and what makes the scale. Slips along tangents count where mu is zero, too.
void ConeIsland::set_velocity(const ContactProblem& island, const Vector& v) {
  double fastest = 0;
  ContactScale<double> scale;
  const auto look_at = [&](double speed) { fastest = max_or_infinity(fastest, speed); };
  const auto velocity_along = [&](const Jacobian& J, Index column) {
    double velocity = 0, terms = 0, entries = 0;
    for_each_entry(J, column, [&](Index row, double entry) {
      velocity += entry * v(row);
      terms += std::abs(entry * v(row));
      ++entries;
    });
    scale.add_row(velocity, terms, entries);
    return velocity;
  };
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    const auto i = static_cast<Index>(c);
    const double normal = velocity_along(island.N, i) + island.offset(i);
    scale.add_approach(normal);
    q_(contact.row) = contact.rows == 3 ? normal / contact.mu : normal;
    look_at(-normal);
    if (contact.tangents[0] < 0) continue;
    const double t1 = velocity_along(island.D, contact.tangents[0]) + island.tangential_offset(i, 0);
    const double t2 = velocity_along(island.D, contact.tangents[1]) + island.tangential_offset(i, 1);
    look_at(std::abs(t1));
    look_at(std::abs(t2));
    if (contact.rows == 3) q_.segment<2>(contact.row + 1) << t1, t2;
  }
  const bool is_finite = std::isfinite(fastest);
  unit_ = fastest > 0 && is_finite ? std::ldexp(1.0, std::ilogb(fastest)) : 1.0;
  q_ /= unit_;
  q_max_ = fastest / unit_;
  approach_ = scale.without / unit_;
  floor_ = scale.floor() / unit_;
}

}  // namespace lcpbench
