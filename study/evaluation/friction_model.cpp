#include "study/evaluation/friction_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "core/islands.h"
#include "study/evaluation/quad_inertia.h"

namespace lcpbench {
namespace {

/// A vector along the two tangents of a contact.
struct Tangential {
  Quad first = 0;
  Quad second = 0;

  Quad length() const { return sqrt(first * first + second * second); }
};

/// Measures one answer; every row costs a pass over its column, and a diagonal entry a solve with G.
class Cone {
 public:
  Cone(const ContactProblem& problem, const QuadInertia& inertia, const Vector& z)
      : problem_(problem), inertia_(inertia), layout_(contact_layout(problem)), z_(z) {
    for (const double value : problem.v) v_.push_back(value);
    velocity_.assign(v_.size(), 0);
    for (Index j = 0; j < layout_.lambda_offset(); ++j) {
      for_each_entry(j, [&](std::size_t row, double value) { velocity_[row] += Quad{value} * z_(j); });
    }
    inertia_.solve(velocity_);
    for (std::size_t i = 0; i < v_.size(); ++i) velocity_[i] += v_[i];
  }

  void measure(Errors& errors) const {
    const RowIslands islands = row_islands(problem_);
    std::vector<Quad> scale(static_cast<std::size_t>(islands.count), 0);
    const auto of_row = [&](Index row) {
      return static_cast<std::size_t>(islands.of_row[static_cast<std::size_t>(row)]);
    };
    for (Index row = 0; row < layout_.lambda_offset(); ++row) {
      Quad& largest = scale[of_row(row)];
      largest = std::max(largest, row_scale(row));
    }
    Quad largest = 0;
    Quad rho = 0;
    errors.worst = {};
    const auto take = [&](const WorstRow& row, Quad residual) {
      largest = std::max(largest, residual);
      const Quad relative = quotient(residual, scale[of_row(row.row)]);
      if (!(relative > rho)) return;
      rho = relative;
      errors.worst = row;
      errors.worst.residual = to_double(residual);
      errors.worst.scale = to_double(scale[of_row(row.row)]);
    };
    Quad excess = 0;
    for (Index contact = 0; contact < layout_.nc; ++contact) {
      const Quad w = normal_velocity(contact);
      take({.row = contact, .z = z_(contact), .w = to_double(w)}, normal_residual(contact, w));
      if (layout_.lambda[static_cast<std::size_t>(contact)] < 0) continue;
      const Quad slack = problem_.mu(contact) * Quad{z_(contact)} - impulse(contact).length();
      excess = std::max(excess, -slack);
      take({.row = layout_.lambda_offset() + layout_.lambda[static_cast<std::size_t>(contact)],
            .z = to_double(slip(contact).length()),
            .w = to_double(slack)},
           friction_residual(contact));
    }
    errors.velocity_residual_m_per_s = to_double(largest);
    errors.velocity_residual_relative = to_double(rho);
    errors.cone_violation = to_double(excess);
    errors.solved =
        errors.velocity_residual_relative <= kSolvedVelocityResidual && std::isfinite(errors.velocity_residual_m_per_s);
  }

 private:
  /// Of column j of [N D].
  template <class Visit>
  void for_each_entry(Index j, Visit visit) const {
    const Jacobian& J = j < layout_.nc ? problem_.N : problem_.D;
    const Index column = j < layout_.nc ? j : j - layout_.nc;
    if (const auto* dense = std::get_if<Matrix>(&J)) {
      for (Index i = 0; i < dense->rows(); ++i) {
        if ((*dense)(i, column) != 0) visit(static_cast<std::size_t>(i), (*dense)(i, column));
      }
    } else {
      for (SparseMatrix::InnerIterator entry(std::get<SparseMatrix>(J), column); entry; ++entry) {
        if (entry.value() != 0) visit(static_cast<std::size_t>(entry.row()), entry.value());
      }
    }
  }

  Quad project(Index j, const QuadVector& x) const {
    Quad sum = 0;
    for_each_entry(j, [&](std::size_t row, double value) { sum += Quad{value} * x[row]; });
    return sum;
  }

  /// M_jj.
  Quad diagonal(Index j) const {
    QuadVector response(v_.size(), 0);
    std::vector<std::size_t> pattern;
    for_each_entry(j, [&](std::size_t row, double value) {
      response[row] = value;
      pattern.push_back(row);
    });
    inertia_.solve(response, pattern);
    return project(j, response);
  }

  /// |q_j|, or 1e4 times the error of forming it in double where that is more.
  Quad row_scale(Index j) const {
    Quad q = 0;
    Quad magnitude = 0;
    Index terms = 1;
    const auto add = [&](Quad term) {
      q += term;
      magnitude += abs(term);
      ++terms;
    };
    for_each_entry(j, [&](std::size_t row, double value) { add(Quad{value} * v_[row]); });
    if (j < layout_.nc && problem_.offset(j) != 0) add(problem_.offset(j));
    const Quad floor = static_cast<double>(terms) * (0x1p-53 * magnitude + 0x1p-1074);
    return std::max(abs(q), floor / kSolvedVelocityResidual);
  }

  Quad normal_velocity(Index contact) const { return project(contact, velocity_) + problem_.offset(contact); }

  Quad normal_residual(Index contact, Quad w) const {
    return finite_or_infinity(abs(std::min(z_(contact) == 0 ? Quad{0} : diagonal(contact) * z_(contact), w)));
  }

  Index first_direction(Index contact) const {
    return layout_.friction_offset() + layout_.friction_begin[static_cast<std::size_t>(contact)];
  }
  Index edges(Index contact) const { return problem_.edges[static_cast<std::size_t>(contact)]; }
  Index second_direction(Index contact) const { return first_direction(contact) + edges(contact) / 4; }

  Tangential impulse(Index contact) const {
    Tangential sum;
    for (Index k = 0; k < edges(contact); ++k) {
      const Quad f = z_(first_direction(contact) + k);
      const Index quarters = 4 * k / edges(contact);
      if (quarters * edges(contact) == 4 * k) {  // exact: along a tangent
        (quarters % 2 == 0 ? sum.first : sum.second) += quarters < 2 ? f : -f;
        continue;
      }
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges(contact));
      sum.first += f * std::cos(angle);
      sum.second += f * std::sin(angle);
    }
    return sum;
  }

  Tangential slip(Index contact) const {
    return {project(first_direction(contact), velocity_), project(second_direction(contact), velocity_)};
  }

  Quad friction_residual(Index contact) const {
    const Quad diagonal_entry = std::max(diagonal(first_direction(contact)), diagonal(second_direction(contact)));
    const Tangential f = impulse(contact);
    const Tangential u = slip(contact);
    const Tangential held{diagonal_entry * f.first, diagonal_entry * f.second};
    const Tangential aim{held.first - u.first, held.second - u.second};
    const Quad radius = problem_.mu(contact) * diagonal_entry * std::max(Quad{z_(contact)}, Quad{0});
    const Quad length = aim.length();
    const Quad shrink = length > radius ? radius / length : Quad{1};
    return finite_or_infinity(Tangential{held.first - shrink * aim.first, held.second - shrink * aim.second}.length());
  }

  static Quad finite_or_infinity(Quad value) {
    return is_finite(value) ? value : Quad{std::numeric_limits<double>::infinity()};
  }

  const ContactProblem& problem_;
  const QuadInertia& inertia_;
  const ContactLayout layout_;
  const Vector& z_;
  QuadVector v_;
  QuadVector velocity_;  ///< v+
};

}  // namespace

const char* to_string(FrictionModel model) { return model == FrictionModel::kCone ? "cone" : "pyramid"; }

FrictionModel friction_model(std::string_view all_settings) {
  const std::string settings = "," + std::string(all_settings) + ",";
  return settings.find(",cone=true,") != std::string::npos ? FrictionModel::kCone : FrictionModel::kPyramid;
}

FrictionModel friction_model(std::string_view all_settings, const Problem& problem) {
  const ContactProblem* contact = problem.contact();
  return contact != nullptr && contact->frictional() ? friction_model(all_settings) : FrictionModel::kPyramid;
}

void measure_cone(const Problem& problem, const Answer& answer, Errors& errors) {
  const ContactProblem* contact = problem.contact();
  if (contact == nullptr || !contact->frictional() || !errors.usable) return;
  for (double Errors::*const measure :
       {&Errors::natural_residual, &Errors::backward_componentwise, &Errors::backward_row_norm,
        &Errors::forward_velocity, &Errors::complementarity_j, &Errors::velocity_residual_m_per_s,
        &Errors::velocity_residual_relative, &Errors::cone_violation}) {
    errors.*measure = Errors::kNone;
  }
  errors.worst = {};
  errors.solved = false;
  const bool round =
      std::all_of(contact->edges.begin(), contact->edges.end(), [](int edges) { return edges % 4 == 0; });
  const QuadInertia inertia(contact->inertia);
  if (!round || !inertia.well_defined() || !contact->v.allFinite() || !all_finite(contact->N) ||
      !all_finite(contact->D)) {
    return;
  }
  Cone(*contact, inertia, answer.z).measure(errors);
}

}  // namespace lcpbench
