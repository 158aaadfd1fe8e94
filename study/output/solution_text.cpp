#include "study/output/solution_text.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/round_cone.h"
#include "study/evaluation/fastest_contact.h"
#include "study/output/text_table.h"

namespace lcpbench {
namespace {

constexpr Index kMostUnknowns = 30;
constexpr Index kMostContacts = 20;
/// Most columns and rows of a matrix whose rank is found.
constexpr Index kLargestRanked = 600;

/// The friction of one contact as the table shows it.
struct Friction {
  double along_first = 0, along_second = 0;  ///< [N s]
  double slip = 0;                           ///< [m/s]
};

/// @param begin  of the contact's columns in D @param is_cone  they are a polygon around two tangents
Friction friction_of(const ContactProblem& contact, Index begin, Index edges, bool is_cone, const Vector& f_D,
                     const Vector& velocity) {
  Friction found;
  const auto speed = [&](Index column) { return dot_column(contact.D, begin + column, velocity); };
  for (Index k = 0; k < edges; ++k) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(edges);
    const double f = f_D(begin + k);
    found.along_first += is_cone || edges == 2 ? std::cos(angle) * f : f;
    if (is_cone) found.along_second += std::sin(angle) * f;
    if (!is_cone) found.slip = std::max(found.slip, -speed(k));
  }
  if (is_cone && edges > 0) found.slip = std::hypot(speed(0), speed(edges / 4));
  return found;
}

/// @param scale  of numbers like this: what is rounding beside it is shown as zero
std::string number(double value, double scale) {
  return fmt::format("{:.4g}", std::abs(value) <= 1e-12 * scale ? 0.0 : value);
}

/// "-0.2 to 0.2", "none" for an equality.
std::string bounds_text(const BoundedRowState& state) {
  const auto bound = [](double x) { return std::isinf(x) ? std::string("any") : fmt::format("{:.4g}", x); };
  if (std::isinf(state.lower) && std::isinf(state.upper)) return "none";
  return bound(state.lower) + " to " + bound(state.upper);
}

std::string rows_text(const ContactProblem& contact, const std::string& title, const Vector& z, int width) {
  using Align = TextTable::Align;
  TextTable table({{"row", Align::kLeft, 0, 8}, {"bounds"}, {"impulse"}, {"velocity w"}, {"state", Align::kLeft}});
  const std::vector<BoundedRowState> states = BoundedRowStates(contact).of(z);
  const BoundedRows& rows = contact.rows;
  double largest = 0, fastest = 0;
  for (const BoundedRowState& state : states) {
    largest = std::max(largest, std::abs(state.impulse));
    fastest = std::max(fastest, std::abs(state.velocity));
  }
  fastest = std::max({fastest, fastest_contact(contact, contact.v).m_per_s, contact.v.cwiseAbs().maxCoeff()});
  for (Index row = 0; row < std::min(rows.size(), kMostContacts); ++row) {
    const BoundedRowState& state = states[static_cast<std::size_t>(row)];
    const auto at = static_cast<std::size_t>(row);
    table.add_row({at < rows.names.size() ? fmt::format("{} {}", row, rows.names[at]) : std::to_string(row),
                   bounds_text(state), fmt::format("{} {}", number(state.impulse, largest), impulse_unit(rows, row)),
                   fmt::format("{} {}", number(state.velocity, fastest), velocity_unit(rows, row)),
                   to_string(state.at)});
  }
  if (rows.size() > kMostContacts) {
    table.add_line(fmt::format("and {} more bounded rows: --format json has all", rows.size() - kMostContacts));
  }
  return folded(fmt::format("bounded rows ({}):\n", title), width) + table.text(width);
}

}  // namespace

std::string solution_text(const Problem& problem, const std::string& title, const Vector& z, const Vector& velocity,
                          const std::vector<std::string>& names, int width) {
  const ContactProblem* const contact = problem.contact();
  if (contact == nullptr) {
    if (z.size() > kMostUnknowns) return "";
    return folded(fmt::format("z ({}): {:.6g}\n", title, fmt::join(Vector(z.array() + 0.0), " ")), width);  // no -0
  }
  if (velocity.size() != contact->ngc()) return "";
  const std::string rows = contact->has_rows() ? rows_text(*contact, title, z, width) : "";
  if (contact->nc() == 0) return rows;
  const ContactLayout layout = contact_layout(*contact);
  const bool is_cone = why_no_round_cone(*contact).empty();
  using Align = TextTable::Align;
  std::vector<TextTable::Column> columns{{"contact", Align::kLeft, 0, 8}, {"normal N s"}};
  if (contact->frictional()) {
    columns.push_back({is_cone ? "1st tangent N s" : "sum of friction N s"});
    if (is_cone) columns.push_back({"2nd tangent N s"});
    columns.push_back({"slip m/s"});
  }
  TextTable table(std::move(columns));
  const double largest = z.head(layout.lambda_offset()).cwiseAbs().maxCoeff();
  const double fastest =
      std::max(fastest_contact(*contact, contact->v).m_per_s, fastest_contact(*contact, velocity).m_per_s);
  const Vector f_D = z.segment(layout.friction_offset(), layout.friction);
  for (Index i = 0; i < std::min(layout.nc, kMostContacts); ++i) {
    const auto at = static_cast<std::size_t>(i);
    std::vector<std::string> cells{names.empty() ? std::to_string(i) : fmt::format("{} {}", i, names[at]),
                                   number(z(i), largest)};
    const Index begin = layout.friction_begin[at];
    if (const Index edges = layout.friction_begin[at + 1] - begin; edges > 0) {
      const Friction friction = friction_of(*contact, begin, edges, is_cone, f_D, velocity);
      cells.push_back(number(friction.along_first, largest));
      if (is_cone) cells.push_back(number(friction.along_second, largest));
      cells.push_back(number(friction.slip, fastest));
    }
    table.add_row(std::move(cells));
  }
  if (layout.nc > kMostContacts) {
    table.add_line(fmt::format("and {} more contacts: --format json has all", layout.nc - kMostContacts));
  }
  return folded(fmt::format("contacts ({}):\n", title), width) + table.text(width) + rows;
}

Json row_states_json(const BoundedRows& rows, const std::vector<BoundedRowState>& states) {
  Json array = Json::array();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const BoundedRowState& state = states[i];
    array.push_back({{"row", i},
                     {"name", i < rows.names.size() ? Json(rows.names[i]) : Json()},
                     {"unit", rows.is_angle[i] != 0 ? "rad" : "m"},
                     {"lower", json_number(state.lower)},
                     {"upper", json_number(state.upper)},
                     {"impulse", json_number(state.impulse)},
                     {"velocity", json_number(state.velocity)},
                     {"state", to_string(state.at)}});
  }
  return array;
}

bool may_have_other_impulses(const ContactProblem& contact, const Vector& velocity) {
  const ContactLayout layout = contact_layout(contact);
  const double touching = least_difference(contact);
  std::vector<Vector> columns;
  const auto add = [&](const Jacobian& J, Index column) {
    const Vector direction = std::visit([&](const auto& matrix) { return Vector(matrix.col(column)); }, J);
    columns.push_back(direction / std::max(direction.norm(), 1e-300));
  };
  for (Index i = 0; i < layout.nc; ++i) {
    if (contact.normal_compliance(i) > 0) continue;  // its velocity decides its impulse
    if (dot_column(contact.N, i, velocity) + contact.offset(i) > touching) continue;
    add(contact.N, i);
    const Index begin = layout.friction_begin[static_cast<std::size_t>(i)];
    const Index edges = layout.friction_begin[static_cast<std::size_t>(i) + 1] - begin;
    if (contact.mu(i) > 0 && !(contact.tangential_compliance(i) > 0)) {
      for (Index k = 0; k < std::min<Index>(edges / 2, 2); ++k) add(contact.D, begin + (k == 0 ? 0 : edges / 4));
    }
    if (static_cast<Index>(columns.size()) > std::min(contact.ngc(), kLargestRanked)) return true;
  }
  double resting = touching;  // of a row that may move
  for (Index row = 0; row < layout.rows; ++row) {
    resting = std::max(resting, 1e-3 * std::abs(dot_column(contact.rows.R, row, contact.v) + contact.rows.offset(row)));
  }
  for (Index row = 0; row < layout.rows; ++row) {
    if (contact.rows.yields(row) > 0) continue;
    const double w = dot_column(contact.rows.R, row, velocity) + contact.rows.offset(row);
    if (!contact.rows.bounds.is_free(row) && std::abs(w) > resting) continue;
    add(contact.rows.R, row);
    if (static_cast<Index>(columns.size()) > std::min(contact.ngc(), kLargestRanked)) return true;
  }
  if (columns.empty()) return false;
  Matrix J(contact.ngc(), static_cast<Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) J.col(static_cast<Index>(k)) = columns[k];
  Eigen::ColPivHouseholderQR<Matrix> factors(J);
  factors.setThreshold(1e-9);  // of unit columns: well above what six digits of a direction leave
  return factors.rank() < J.cols();
}

double share_of_scale(const ContactProblem& contact, double m_per_s) {
  double scale = fastest_contact(contact, contact.v).m_per_s;
  for (Index i = 0; i < contact.nc(); ++i) {
    scale = std::max(scale, std::abs(dot_column(contact.N, i, contact.v) + contact.offset(i)));
  }
  for (const double offset : contact.offset_t) scale = std::max(scale, std::abs(offset));
  return m_per_s / scale;
}

}  // namespace lcpbench
